"""Makes sure that Ctrl-C is heard.

While LLVM compiles it calls back into Python, and Python drops what is raised in such a callback or in a
``__del__``: an interrupt that lands there would print a traceback, and the run would go on.
"""

import signal
import sys
from typing import Any, NoReturn

__all__ = ["INTERRUPTED", "heard", "repeat_interrupts"]

INTERRUPTED = 130  # exit status: 128 + SIGINT, as shells have it
PAUSE = 0.2  # s
REPEATS = hasattr(signal, "setitimer")  # not on Windows


def repeat_interrupts() -> None:
    """From now on, repeat an interrupt until :func:`heard` is called, and say nothing of those dropped."""
    sys.unraisablehook = dropped
    if REPEATS:
        signal.signal(signal.SIGINT, interrupt)
        signal.signal(signal.SIGALRM, interrupt)


def heard() -> None:
    """Stop repeating the interrupt: it has been acted on."""
    if REPEATS:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def interrupt(_number: int, _frame: Any) -> NoReturn:
    signal.setitimer(signal.ITIMER_REAL, PAUSE)  # a timer of the system: a thread could wait for itself here
    raise KeyboardInterrupt


def dropped(exception: Any) -> None:
    if not issubclass(exception.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(exception)
