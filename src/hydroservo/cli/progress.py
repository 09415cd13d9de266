"""A progress bar for what takes more than two seconds."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

__all__ = ["Report", "progress_bar"]

Report = Callable[[float, str], None]  # the fraction done, and what is being done

PATIENCE = 2.0  # s


@contextmanager
def progress_bar(what: str) -> Iterator[Report]:
    """A function to report progress to.

    After two seconds a bar appears on stderr if that is a terminal; it is gone when all is done.
    """
    if not sys.stderr.isatty():
        yield lambda _fraction, _what: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
    console = Console(stderr=True)
    bar = Progress(*columns, console=console, transient=True, redirect_stdout=False, redirect_stderr=False)
    task = bar.add_task(what, total=1.0)
    timer = threading.Timer(PATIENCE, bar.start)
    timer.daemon = True
    timer.start()
    try:
        yield lambda fraction, now: bar.update(task, completed=fraction, description=now)
    finally:
        timer.cancel()
        timer.join()
        bar.stop()
