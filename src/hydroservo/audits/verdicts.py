"""What an audit says of a run and of the forecast, in sentences."""

from typing import TYPE_CHECKING

from hydroservo.audits.chatter import Chatter
from hydroservo.audits.strain import Strain
from hydroservo.audits.sustained import OSCILLATION, Sustained
from hydroservo.formatting import number, quantity
from hydroservo.runs.behaviour import pressure_line
from hydroservo.show import Line, Mark

if TYPE_CHECKING:
    from hydroservo.audits.audited import Audit

THRESHOLD = OSCILLATION.threshold


def verdicts(found: "Audit") -> list[Line]:
    """What an audit says besides its assumptions."""
    said = []
    if found.lost:
        said.append(Line("The run diverged", ", and what is measured on it cannot be told.", Mark.BAD))
    if found.oscillation is not None:
        said.append(oscillation(found.oscillation))
    said.append(forecast(found.chatter, found.no_forecast, found.oscillation))
    return [*said, *(strained(found.strain) if found.strain is not None else ())]


def oscillation(one: Sustained) -> Line:
    """What the run shows."""
    run = f"A run of {number(one.longer)} s" if one.longer else "The run"
    if one.oscillates:
        sizes = f"{quantity(one.command, 'V')} and {quantity(one.amplitude, one.unit)}"
        text = f", by {sizes} at {number(one.frequency)} Hz to its end. {kept_up(one)}"
        return Line(f"{run} oscillates", text, Mark.BAD)
    if one.command == 0.0:
        return Line(
            f"{run} does not oscillate", f" with {quantity(THRESHOLD, 'V')} of command or more.", Mark.GOOD
        )
    return Line(f"{run} is too short to tell", " whether it oscillates.", Mark.DOUBTFUL)


def kept_up(one: Sustained) -> str:
    """What keeps an oscillation up."""
    names = [each.phrase for each in one.causes]
    if not names:
        tried = ", ".join(dict.fromkeys(each.cause for each in one.remains))
        return f"No single cause was found; tried were {tried}."
    if len(names) == 1:
        return f"It dies out {names[0]}."
    needs = "both" if len(names) == 2 else f"all {len(names)}"
    return f"It needs {needs}: {', '.join(names[:-1])} or {names[-1]}, it dies out."


def forecast(one: Chatter | None, reason: str, run: Sustained | None) -> Line:
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


def strained(one: Strain) -> list[Line]:
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
