"""Makes sure that Ctrl-C is heard, and that SIGTERM and a closed terminal end a command as it does.

While LLVM compiles it calls back into Python, and Python drops what is raised in such a callback or in a
``__del__``: an interrupt that lands there would print a traceback, and the run would go on. And Python hears
nothing while compiled code runs, which never ends where a ``while`` of a block does not.
"""

import os
import signal
import sys
from time import sleep

TYPE_CHECKING = False  # as typing has it, during whose import an interrupt would print a traceback
if TYPE_CHECKING:
    from typing import Any, NoReturn

INTERRUPTED = 130  # exit status: 128 + SIGINT, as shells have it; of other signals 128 + theirs
ENDINGS = {int(signal.SIGINT): "interrupted", int(signal.SIGTERM): "terminated"}
if sys.platform != "win32":
    ENDINGS[int(signal.SIGHUP)] = "hung up"
PAUSE = 0.2  # s
PATIENCE = 10.0  # s, after which whatever does not answer is left
REPEATS = hasattr(signal, "setitimer")  # not on Windows


def end_on_interrupt() -> None:
    """From now on, end at once on an interrupt, as is right while there is nothing to put in order."""
    if not is_ignored():
        signal.signal(signal.SIGINT, lambda _number, _frame: leave())


def repeat_interrupts() -> None:
    """From now on, repeat an interrupt until it is acknowledged, and say nothing of those dropped."""
    sys.unraisablehook = silence_dropped_interrupt
    if not REPEATS:
        if not is_ignored():
            signal.signal(signal.SIGINT, signal.default_int_handler)
        return
    signal.signal(signal.SIGALRM, raise_interrupt)
    for number in ENDINGS:
        if not is_ignored(number):
            signal.signal(number, raise_interrupt)
    leave_what_does_not_answer()


def is_ignored(number: int = signal.SIGINT) -> bool:
    """Whether this process was started with a signal ignored, as in the background of a script."""
    return signal.getsignal(number) is signal.SIG_IGN


def ignore_interrupts() -> None:
    """From now on, let nothing break off the end of the process: all is done."""
    for number in ENDINGS:
        signal.signal(number, signal.SIG_IGN)
    acknowledge_interrupt()


CAUGHT: list[int] = []  # the signals that are to end this process
ANSWERS: list[str] = []  # what is to be said of an interrupt that was acted on


def acknowledge_interrupt(where: str = "") -> None:
    """Stop repeating the interrupt: it has been acted on, ``where`` is said of it besides."""
    ANSWERS.append(where)
    if REPEATS:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def raise_interrupt(number: int, _frame: "Any") -> "NoReturn":
    CAUGHT.extend({number} & ENDINGS.keys())
    signal.setitimer(signal.ITIMER_REAL, PAUSE)  # a timer of the system: a thread could wait for itself here
    raise KeyboardInterrupt


def leave_what_does_not_answer() -> None:
    """From now on, leave where an interrupt is not acted on for some seconds.

    The system's part of a signal writes to a pipe at once, whatever the main thread is doing.
    """
    import threading

    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=watch_for_answer, args=(read,), daemon=True).start()


def watch_for_answer(pipe: int) -> None:
    """Wait for an interrupt, and then for the answer."""
    while (number := os.read(pipe, 1)[0]) not in ENDINGS:
        pass
    sleep(PATIENCE)
    if not ANSWERS:
        CAUGHT.append(number)
        end_process(
            f"; what was computed did not stop within {PATIENCE:g} s, as a while without end does not"
        )


def silence_dropped_interrupt(exception: "Any") -> None:
    if not issubclass(exception.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(exception)


def leave() -> "NoReturn":
    """End at once: Python may crash as it closes an interrupted compiler, and nothing is left to do."""
    where = "".join(ANSWERS[:1])
    ignore_interrupts()
    end_process(where)


def end_process(why: str) -> "NoReturn":
    """End the process, from any thread, and say why."""
    number = CAUGHT[0] if CAUGHT else signal.SIGINT
    try:
        sys.stderr.write(f"hydroservo: {ENDINGS[number]}{why}; nothing was left half-written\n")
        sys.stderr.flush()
    except OSError:  # the terminal is gone
        pass
    discard_unwritten()
    if outputs := sys.modules.get("hydroservo.core.outputs"):
        outputs.remove_temporary_folders()
    os._exit(128 + number)


def discard_unwritten() -> None:
    """Keep Python from complaining at its exit of output that nobody takes any more."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
