"""The margins of a loop that has kinks: while it moves, and only where its nonlinear runs agree."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from hydroservo.control.loop import Loop
from hydroservo.core.formatting import number
from hydroservo.linear.margins import Judged, Margins
from hydroservo.linear.onset import MOST
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.linear.places import kinked, largest_command, while_moving

AGREED = 1.5  # dB, by which a gain margin may miss the onset of oscillation
LEAST = 0.1  # of the largest command of the run, from which a point that is asked for has margins of its own


class Trusted(NamedTuple):
    """Margins that hold, or why there are none.

    Attributes:
        margins: nan where none hold.
        here: whether they are those of the point itself.
        remark: where they are from, or why there are none; empty for those of a smooth loop at its point.
    """

    margins: Margins
    here: bool
    remark: str


def trusted_margins(point: OperatingPoint, judged: Judged, loop: Loop, onset: float) -> Trusted:
    """The margins of a loop about a point, or those while it moves where the point has none that hold.

    Those of a smooth loop are its own. Where it has a kink at the point, or rests within an overlap, which
    the onset of oscillation shows, they are the worst of those under which its machine moves, as of
    :func:`~hydroservo.linear.places.while_moving`.

    Args:
        point: where the loop stays.
        judged: the loop there.
        loop: the same, as it runs.
        onset: the factor on its gain from which it oscillates; nan for unknown, infinite for none. A loop
            that oscillates as it stands has no margins.

    Source: chosen here.
    Fails for loops whose gain at other commands is higher still.
    """
    here = judged.margins
    if onset == 1.0 and here.stable:
        return Trusted(without(here, onset), False, f"no margins: the loop {says(onset)}")
    known = not math.isnan(onset)
    holds = here.stable and agrees(here.gain_margin, onset) and (judged.linear or onset < math.inf)
    if judged.linear and not here.stable:
        problem = problem_of({point.command: here}, judged, loop, onset) if onset > 1.0 else ""
        return Trusted(here, True, problem and f"no margins: {problem}")
    if judged.linear and holds and known:
        return Trusted(here, True, "")
    largest = largest_command(loop)
    if judged.linear and abs(point.command) >= LEAST * largest > 0.0:
        return Trusted(here, True, "")
    found = {one.command: at.margins for one, at in while_moving(loop, largest)}
    moving = [one.gain_margin for command, one in found.items() if abs(command) >= LEAST * largest]
    if not known and moving:  # rest within an overlap is quieter than any motion
        found = {command: one for command, one in found.items() if one.gain_margin <= max(moving)}
        holds = holds and here.gain_margin <= max(moving)
    if holds and judged.linear:
        found[point.command] = here
    problem = problem_of(found, judged, loop, onset)
    if problem:
        return Trusted(without(here, onset), False, f"no margins: {problem}")
    worst, span = worst_of(list(found.values()), here), span_of(found)
    said = f"margins are the worst under {commands_of(found)}: gain margin {span} dB"
    return Trusted(worst, holds, "" if list(found) == [point.command] else said)


def problem_of(found: Mapping[float, Margins], judged: Judged, loop: Loop, onset: float) -> str:
    """Why no margins hold; empty where they do.

    Args:
        found: margins by the command [V] of their point.
        judged: the loop at its own point.
        loop: the same, as it runs.
        onset: the factor on its gain from which it oscillates.
    """
    if not found:
        known = "" if math.isnan(onset) else f"the loop {says(onset)}; "
        return f"{no_slope(judged, loop)}; {known}measure with a larger amplitude"
    unstable = [command for command, one in found.items() if not one.stable]
    if unstable:
        link = "and" if onset == 1.0 else "but"
        known = "" if math.isnan(onset) else f", {link} the loop itself {says(onset)}"
        return f"small motions are unstable under {commands_of(unstable)}{known}"
    if not agrees(min(one.gain_margin for one in found.values()), onset):
        return f"{span_of(found)} dB for small motions under {commands_of(found)}, but the loop {says(onset)}"
    return ""


def commands_of(commands: Iterable[float]) -> str:
    return f"{', '.join(number(one) for one in sorted(commands))} V"


def span_of(found: Mapping[float, Margins]) -> str:
    """The least and the largest gain margin [dB]."""
    every = [one.gain_margin for one in found.values()]
    return " to ".join(dict.fromkeys(number(decibels(one)) for one in (min(every), max(every))))


def worst_of(every: Sequence[Margins], here: Margins) -> Margins:
    """The least of all margins, and the largest sensitivity; crossovers are those of the point itself."""
    return here._replace(
        stable=True,
        gain_margin=min(one.gain_margin for one in every),
        gain_reduction_margin=max(one.gain_reduction_margin for one in every),
        phase_margin=min(one.phase_margin for one in every),
        delay_margin=min(one.delay_margin for one in every),
        disk_margin=min(one.disk_margin for one in every),
        sensitivity_peak=max(one.sensitivity_peak for one in every),
    )


def without(here: Margins, onset: float) -> Margins:
    """No margins; of the point itself only what is no margin is left."""
    none = dict.fromkeys((name for name in Margins._fields if name.endswith(("margin", "peak"))), math.nan)
    return here._replace(stable=here.stable and onset != 1.0)._replace(**none)  # type: ignore[arg-type]


def agrees(gain_margin: float, onset: float) -> bool:
    """Whether a gain margin is about where the loop begins to oscillate, or nothing is known of that."""
    if math.isnan(onset) or math.isnan(gain_margin):
        return math.isnan(onset)
    highest = 10.0 ** (MOST / 20.0)
    apart = decibels(min(gain_margin, highest)) - decibels(min(onset, highest))
    return abs(apart) <= AGREED


def decibels(factor: float) -> float:
    return 20.0 * math.log10(factor) if factor < math.inf else math.inf


def says(onset: float) -> str:
    """What the loop does by itself, behind its name."""
    if onset == 1.0:
        return "oscillates as it stands"
    if onset == math.inf:
        return f"does not oscillate up to {MOST:g} dB"
    return f"oscillates from {number(decibels(onset))} dB"


def no_slope(judged: Judged, loop: Loop) -> str:
    """Which blocks leave a loop without a slope."""
    causes = [f"the {path.partition('.')[0]}'s hysteresis" for path, _ in kinked(loop, "hysteresis")]
    causes += [f"the {path.partition('.')[0]}'s overlap" for path, _ in kinked(loop, "lap")]
    friction = getattr(loop.plant, "friction", None)
    if friction is not None and type(friction).__name__ != "Viscous":
        causes.append(f"friction ({type(friction).__name__})")
    path = max(judged.errors, key=lambda name: judged.errors[name])
    causes = list(dict.fromkeys(causes)) or [f"{path} ({type(getattr(loop, path)).__name__})"]
    return f"{', '.join(causes)}: no slope here, nor while moving"
