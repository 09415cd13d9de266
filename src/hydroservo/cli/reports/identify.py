"""What an identification leaves in its folder: a scenario with what was found, and what the report says."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from hydroservo.cli.files import OwnFiles
from hydroservo.cli.identify_tables import Further, tables_of
from hydroservo.cli.reporting import in_one_block, table_of
from hydroservo.figures.identified import plot_fit, plot_log
from hydroservo.formatting import quantity
from hydroservo.identification import Identified
from hydroservo.identification.result import UNFIT
from hydroservo.outputs import write_text
from hydroservo.reports.report import Picture, Report, logs_of, origin_of_loop

TITLES = {
    "parameters": "What was sought, and whether the logs tell it.",
    "comparison": "Both scenarios on what was held out.",
    "effects": "What the model may miss.",
    "proposal": "What a log of the proposed command would tell.",
}


def identified_files(found: Identified, folder: Path) -> OwnFiles:
    """A scenario with what was found.

    Args:
        found: what ``identify`` returned.
        folder: where the scenario will stand.
    """
    return {"scenario.toml": lambda path: write_text(path, found.toml(folder))}


def identify_report(command: str, found: Identified, more: Further, logs: Sequence[Path]) -> Report:
    """The report of an identification.

    Args:
        command: makes it again.
        found: what ``identify`` returned.
        more: what was asked besides.
        logs: the files of its logs.
    """
    tables = [
        table_of(
            name, shown, TITLES.get(name) or f"How log {name.removeprefix('signals-')} is met: {shown.title}."
        )
        for name, shown in tables_of(found, more).items()
    ]
    return Report(
        f"Identification of {found.scenario}",
        in_short(found),
        in_one_block(found.remarks),
        [*pictures(found)],
        tables,
        command,
        [origin_of_loop(f"{found.scenario}, with what was found", found.loop)],
        logs_of(logs),
    )


def pictures(found: Identified) -> Iterator[Picture]:
    """Each log as it was understood and as it is met."""
    for i, fit in enumerate(found.logs, 1):
        name = fit.understood.log.name
        yield Picture(f"log-{i}", f"How {name} was understood.", plot_log(fit.understood))
        yield Picture(
            f"fit-{i}", f"How {name} is met: measured, and simulated with what was found.", plot_fit(fit)
        )


def in_short(found: Identified) -> list[str]:
    """The numbers that the logs tell, and those that they do not, in a sentence each."""
    told = {path: one for path, one in found.parameters.items() if one.identifiable}
    lines = [] if found.fits else [UNFIT]
    if told:
        shown = [
            f"{path} is {quantity(one.value, one.unit)} "
            f"({quantity(one.low, one.unit)} to {quantity(one.high, one.unit)})"
            for path, one in told.items()
        ]
        lines.append(f"{'; '.join(shown)}, with 95 % intervals.")
    left = [path for path in found.parameters if path not in told]
    if found.fits and left:
        lines.append(f"The logs do not tell {', '.join(left)}.")
    return lines
