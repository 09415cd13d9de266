"""What masters make of the loop, as a table."""

from benchmarks.masters import ALL
from benchmarks.masters.master import Master
from benchmarks.masters.measure import Result, Results
from benchmarks.masters.system import SAMPLES
from benchmarks.table import Line, digits, markdown

__all__ = ["page", "table"]

HEADER = (
    "master",
    "what it does at each sample",
    "package",
    "FMI",
    f"as simulated, of {SAMPLES:,}",
    "rms error [mm/s]",
    "with gains for the delay [mm/s]",
)


def page(results: Results) -> str:
    """What the documentation shows."""
    return markdown(*table(results), left=3)


def table(results: Results) -> tuple[Line, list[Line]]:
    """A row for each master that was measured, the least error first."""
    pairs = [(one, results[one.name]) for one in ALL if one.name in results]
    return HEADER, [row(*pair) for pair in sorted(pairs, key=lambda pair: pair[1]["error"])]


def row(master: Master, result: Result) -> Line:
    return (
        master.name,
        master.how,
        f"{master.package} {result['version']}",
        ", ".join(result["fmi"]),
        f"{result['equal']:,}",
        *(digits(1e3 * result[key]) for key in ("error", "error_with_gains_for_delay")),
    )
