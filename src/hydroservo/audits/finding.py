"""What an audit says: of assumptions, of the run, and of the forecast."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hydroservo.audits.chatter import Chatter
from hydroservo.audits.oscillation import OSCILLATION, SustainedOscillation
from hydroservo.core.formatting import counted, number, quantity
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.runs.run_finding import pressure_line
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.audits.audit import Audit, BlockAssumptions, Strain
    from hydroservo.core.assumptions import Assumption
    from hydroservo.figures.style import Plot

THRESHOLD = OSCILLATION.threshold
COLUMNS = (
    Column("block"),
    Column("it assumes that"),
    *(Column("value"), Column("bound"), UNIT),
    Column("margin", digits=3),
    Column("verdict"),
    Column("worst at", "s"),
)
VERDICTS = {
    True: Cell("holds", mark=Mark.GOOD),
    False: Cell("fails", mark=Mark.BAD),
    None: Cell("cannot be told", mark=Mark.DOUBTFUL),
}
NOTE = "Worst at: the instant of the run on which it was measured."
CAPTION = "The factor by which each assumption holds; below 1 it fails. At an edge: beyond the axis."


def audit_lines(found: "Audit") -> list[Line]:
    """What an audit says besides its assumptions."""
    said = []
    if found.lost:
        said.append(Line("The run diverged", ", and what is measured on it cannot be told.", Mark.BAD))
    if found.oscillation is not None:
        said.append(sustained_line(found.oscillation))
    said.append(forecast_line(found.chatter, found.no_forecast, found.oscillation))
    return [*said, *(strain_lines(found.strain) if found.strain is not None else ())]


def sustained_line(one: SustainedOscillation) -> Line:
    """What the run shows."""
    run = f"A run of {number(one.longer)} s" if one.longer else "The run"
    if one.oscillates:
        sizes = f"{quantity(one.command, 'V')} and {quantity(one.amplitude, one.unit)}"
        text = f", by {sizes} at {number(one.frequency)} Hz to its end. {cause_sentence(one)}"
        return Line(f"{run} oscillates", text, Mark.BAD)
    if one.command == 0.0:
        return Line(
            f"{run} does not oscillate", f" with {quantity(THRESHOLD, 'V')} of command or more.", Mark.GOOD
        )
    longer = " whether it oscillates; a longer simulation.duration may tell."
    return Line(f"{run} is too short to tell", longer, Mark.DOUBTFUL)


def cause_sentence(one: SustainedOscillation) -> str:
    """What keeps an oscillation up."""
    names = [each.phrase for each in one.causes]
    if not names:
        tried = ", ".join(dict.fromkeys(each.cause for each in one.remains))
        return f"No single cause was found; tried were {tried}."
    if len(names) == 1:
        return f"It dies out {names[0]}."
    needs = "both" if len(names) == 2 else f"all {len(names)}"
    return f"It needs {needs}: {', '.join(names[:-1])} or {names[-1]}, it dies out."


def forecast_line(one: Chatter | None, reason: str, run: SustainedOscillation | None) -> Line:
    """What harmonic balance predicts, held against the run."""
    if one is None:
        return Line("No chatter can be predicted", f": {reason}.", Mark.DOUBTFUL)
    size, at = quantity(one.threshold, "V"), f"with demand and load as at {one.time:.4g} s"
    jolt = f" A jolt could leave a swing of {quantity(one.after_a_jolt, 'V')}." if one.after_a_jolt else ""
    if one.chatters:
        tone = f"{quantity(one.amplitude, 'V')} at {one.frequency:.4g} Hz"
        text = f", by {one.cause}: {tone}, {at}.{jolt}"
        if run is not None and run.command == 0.0:
            text += " The run shows none that lasts to its end."
        return Line("Chatter is predicted", text, Mark.BAD)
    if run is not None and run.oscillates:
        text = (
            f" misses that: it predicts less than {size} {at}, and leaves out noise and steps of sensors, "
            f"slow swings, swings far from a sine, and other instants.{jolt}"
        )
        return Line("Harmonic balance", text, Mark.DOUBTFUL)
    return Line("No chatter is predicted", f" with {size} of command or more, {at}.{jolt}", Mark.GOOD)


def strain_lines(one: "Strain") -> list[Line]:
    """What a run asks of its machine that it may not have."""
    said = []
    lead, stop, rest = pressure_line(one._asdict()).partition(": ")
    if lead:
        said.append(Line(lead, stop + rest, Mark.BAD))
    if one.above_supply:
        high, supply = quantity(one.pressure_max, "Pa"), quantity(one.supply_pressure, "Pa")
        text = f": it reaches {high}, and the supply {supply}. Cylinder and hoses must be rated for that."
        said.append(Line("A chamber is above the supply", text, Mark.DOUBTFUL))
    if one.limited > 0.0:
        text = f" for {number(100.0 * one.limited)} % of the run."
        said.append(Line("The command is at its limit", text, Mark.DOUBTFUL))
    return said


def audit_finding(audit: "Audit", scenario: str = "") -> Finding:
    """What an audit says."""
    margins = [one for one in audit.assumptions() if one.holds is not None]
    rows = [row for asked in audit.asked for row in assumption_rows(asked)]
    return Finding(
        title_of("Audit", scenario),
        [assumption_count_line([one.holds for one in audit.assumptions()]), *audit_lines(audit)],
        [],
        [Table("assumptions", COLUMNS, rows, "What the law assumes of its loop.", NOTE)],
        [Picture("margins", CAPTION, lambda: draw_audit_margins(margins))] if margins else [],
        audit_numbers(audit, scenario),
        origins=[origin_of_loop(scenario, audit.loop)] if audit.loop else [],
    )


def draw_audit_margins(margins: "Sequence[Assumption]") -> "Plot":
    from hydroservo.figures.audit import plot_margins

    return plot_margins(margins)


def assumption_count_line(verdicts: Sequence[bool | None]) -> Line:
    """How many assumptions hold and how many cannot be told."""
    if not verdicts:
        return Line("The law does not say what it assumes, or assumes nothing here.")
    untold = verdicts.count(None)
    rest = f"; {untold} cannot be told" if untold else ""
    true, every = verdicts.count(True), counted(len(verdicts), "assumption")
    return Line(f"{true} of {every} hold{'s' if true == 1 else ''}{rest}.")


def assumption_rows(asked: "BlockAssumptions") -> list[list[Cell]]:
    """A row for each assumption of a block; one that says why for a block without any."""
    if not asked.assumptions:
        why = "does not say what it assumes" if asked.assumptions is None else "assumes nothing here"
        return [[Cell(asked.block), Cell(why, mark=Mark.QUIET), *[Cell()] * (len(COLUMNS) - 2)]]
    return [
        [
            Cell(asked.block),
            Cell(one.meaning),
            *(Cell(one.value, one.unit), Cell(one.bound, one.unit), Cell()),
            Cell(one.margin),
            VERDICTS[one.holds],
            Cell(one.at if math.isfinite(one.at) else None, "s"),
        ]
        for one in asked.assumptions
    ]


def audit_numbers(audit: "Audit", scenario: str) -> dict[str, Any]:
    """All numbers of an audit, in SI units."""
    oscillation = audit.oscillation
    return {
        "scenario": scenario,
        "holds": audit.holds,
        "diverged": audit.lost,
        "assumptions": [
            {"path": asked.path, "block": asked.block, **one._asdict(), "holds": one.holds}
            for asked in audit.asked
            for one in asked.assumptions or ()
        ],
        "silent": [{"path": one.path, "block": one.block} for one in audit.asked if one.assumptions is None],
        "chatter": None if audit.chatter is None else audit.chatter._asdict(),
        "no_forecast": audit.no_forecast,
        "oscillation": None if oscillation is None else oscillation.numbers(),
        "strain": None if audit.strain is None else audit.strain._asdict(),
    }
