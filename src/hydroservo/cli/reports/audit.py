"""What the report of an audit says."""

from hydroservo.audits import Audit
from hydroservo.cli.audit_tables import assumptions_table, lines_of
from hydroservo.cli.reporting import sentences, table_of
from hydroservo.figures.margins import plot_margins
from hydroservo.loop import Loop
from hydroservo.reports.report import Picture, Report, origin_of_loop


def audit_report(command: str, scenario: str, loop: Loop, found: Audit) -> Report:
    """The report of an audit.

    Args:
        command: makes it again.
        scenario: as the user named it.
        loop: the scenario's.
        found: what ``audit`` returned.
    """
    margins = [one for one in found.assumptions() if one.holds is not None]
    caption = "The factor by which each assumption holds; below 1 it fails. At an edge: beyond the axis."
    return Report(
        f"Audit of {scenario}",
        [*counted([one.holds for one in found.assumptions()]), *sentences(lines_of(found))],
        [],
        [Picture("margins", caption, plot_margins(margins))] if margins else [],
        [table_of("assumptions", assumptions_table(scenario, found), "What the law supposes of its loop.")],
        command,
        [origin_of_loop(scenario, loop)],
    )


def counted(verdicts: list[bool | None]) -> list[str]:
    """How many assumptions hold and how many cannot be told, in a sentence."""
    if not verdicts:
        return ["The law does not say what it supposes, or supposes nothing here."]
    untold = verdicts.count(None)
    rest = f"; {untold} cannot be told" if untold else ""
    return [f"{verdicts.count(True)} of {len(verdicts)} assumptions hold{rest}."]
