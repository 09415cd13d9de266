"""What is said of the progress of whatever takes long, on stderr."""

import logging
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from hydroservo.control.loop import Loop

Report = Callable[[float, str], None]  # the fraction done, and what is being done

PATIENCE = 2.0  # s
FIRST_LINE, LONGEST_PAUSE = 10.0, 600.0  # s
PAUSE = 1.0  # s, before which a rate would be a guess
SAID: set[str] = set()  # warnings of this command

LOG = logging.getLogger("hydroservo.engine")


@contextmanager
def progress_bar(what: str) -> Iterator[Report]:
    """A function to report progress to.

    After two seconds a bar appears on stderr if that is a terminal; it is gone when all is done. If it is
    none, such as the log of a job, there is a line after ten seconds, and more after pauses that grow to ten
    minutes.
    """
    if not sys.stderr.isatty():
        yield occasional_lines()
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


def occasional_lines() -> Report:
    """Reports progress in a line for about each doubling of the time that it takes."""
    pause = FIRST_LINE
    due = time.monotonic() + pause

    def report(fraction: float, what: str) -> None:
        nonlocal pause, due
        now = time.monotonic()
        if now >= due:
            print(f"hydroservo: {100.0 * fraction:.0f} % done: {what}", file=sys.stderr, flush=True)
            due = now + pause
            pause = min(2.0 * pause, LONGEST_PAUSE)

    return report


def progress_with_rate(report: Report, count: int, what: str = "runs") -> Callable[[float], None]:
    """Reports how many of something are done, how many per second, and how long the others will take."""
    first: tuple[float, float] | None = None  # the clock and the fraction at the first report

    def progress(fraction: float) -> None:
        nonlocal first
        now = time.monotonic()
        first = first or (now, fraction)
        seconds, done = now - first[0], fraction - first[1]
        text = f"{round(fraction * count):,} of {count:,} {what}"
        if seconds > PAUSE and done > 0.0:
            left = round((1.0 - fraction) * seconds / done)
            text += f", {done * count / seconds:,.0f} per second, {left // 60}:{left % 60:02d} left"
        report(fraction, text)

    return progress


def warn_of_sizes(scenario: str, loop: "Loop") -> None:
    """A size that no machine has, before a run of it that may take long, on stderr."""
    from hydroservo.runs.cautions.loop import size_cautions

    for text in size_cautions(loop):
        say_warning(scenario, text)


def say_warning(name: str, text: str) -> None:
    """A warning in one line on stderr, once a command: what is known before a run is in its result too."""
    line = ": ".join(filter(None, ["hydroservo: warning", name, text]))
    if line not in SAID:
        SAID.add(line)
        typer.echo(line, err=True)


class LogCollector(logging.Handler):
    """Keeps what is logged, for there may be a progress bar on stderr."""

    def __init__(self) -> None:
        super().__init__()
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


@contextmanager
def log_kernels(wanted: bool) -> Iterator[None]:
    """At its end, where the kernels that were used came from, a line for each on stderr."""
    if not wanted:
        yield
        return
    lines = LogCollector()
    LOG.addHandler(lines)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.setLevel(logging.NOTSET)
        LOG.removeHandler(lines)
        for text in lines.texts:
            typer.echo(f"hydroservo: {text}", err=True)
