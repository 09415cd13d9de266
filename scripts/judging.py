"""What scripts that hold laws against each other share: unseen seeds, means over them, tables in pages."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from hydroservo import Loop, simulate_batch

SEEDS = np.arange(100, 120)  # none of which a search has seen


def means(loop: Loop, values: Mapping[str, float] | None = None) -> tuple[float, float]:
    """rms error and total variation of the command; infinite where a run diverged.

    Args:
        loop: the loop that is judged.
        values: numbers by path that it has in place of its own.
    """
    columns = {path: np.full(SEEDS.size, value) for path, value in (values or {}).items()}
    runs = simulate_batch(loop, {**columns, "simulation.seed": SEEDS})
    if runs["diverged"].any():
        return np.inf, np.inf
    return float(runs["rms_error"].mean()), float(runs["control_total_variation"].mean())


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of a page, its columns but the first aligned on the right."""
    lines = [header, ("---", *["---:"] * (len(header) - 1)), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def with_text(page: str, mark: str, text: str) -> str:
    """A page with another text between the comments that name it.

    Raises:
        SystemExit: the page has no such comments.
    """
    begin, end = f"<!-- {mark}: begin -->\n", f"<!-- {mark}: end -->"
    before, found, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not (found and closed):
        raise SystemExit(f"the page has no {begin.strip()} ... {end}")
    return before + begin + text + end + after


def write_text(page: Path, mark: str, text: str) -> None:
    """Into a page, between the comments that name it."""
    page.write_text(with_text(page.read_text("utf-8"), mark, text), "utf-8")
