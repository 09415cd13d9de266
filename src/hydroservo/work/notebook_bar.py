"""A bar in the notebook for whatever takes long and was given no other way to say how far it is."""

import sys
import time
from collections.abc import Callable
from functools import wraps
from html import escape
from typing import Any, ParamSpec, TypeVar

PATIENCE = 1.0  # s
PAUSE = 0.2  # s, between two looks of the bar

P = ParamSpec("P")
Result = TypeVar("Result")


class Bar:
    """A bar below the cell, by IPython's display alone: no widget need be installed.

    It appears at the first report after a second, and is gone when all is done.
    """

    shown: "Bar | None" = None  # the one there is: what a search calls has none of its own

    def __init__(self, what: str) -> None:
        self.what = what
        self.began = self.looked = time.monotonic()
        self.display: Any = None

    def report(self, fraction: float, *_: object) -> None:
        """Say how much is done."""
        now = time.monotonic()
        if now < self.began + PATIENCE or now < self.looked + PAUSE:
            return
        from IPython import display

        self.looked = now
        page = display.HTML(self.page(fraction, now - self.began))
        if self.display is None:
            self.display = display.display(page, display_id=True)
        else:
            self.display.update(page)

    def page(self, fraction: float, seconds: float) -> str:
        left = f", {seconds * (1.0 / fraction - 1.0):.0f} s left" if fraction > 0.0 else ""
        bar = f'<progress value="{fraction:.4f}" max="1"></progress>'
        return f"{bar} {escape(self.what)}: {100.0 * fraction:.0f} % in {seconds:.0f} s{left}"

    def close(self) -> None:
        """Take it away."""
        if self.display is not None:
            from IPython import display

            self.display.update(display.HTML(""))


def in_notebook() -> bool:
    """Whether a notebook's kernel runs this, and not a program or a terminal's IPython."""
    found = sys.modules.get("IPython")
    return found is not None and hasattr(found.get_ipython(), "kernel")


def shows_progress(function: Callable[P, Result]) -> Callable[P, Result]:
    """A function with an argument ``progress`` that has a bar in a notebook where nothing is given for it."""

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> Result:
        if kwargs.get("progress") is not None or Bar.shown is not None or not in_notebook():
            return function(*args, **kwargs)
        Bar.shown = bar = Bar(function.__name__.replace("_", " "))
        try:
            return function(*args, **kwargs | {"progress": bar.report})  # type: ignore[arg-type]
        finally:
            Bar.shown = None
            bar.close()

    return called
