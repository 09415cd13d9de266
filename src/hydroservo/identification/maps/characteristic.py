"""A valve's measured characteristic, from slow sweeps or stairs of the command, as a table."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import counted, plain_quantity
from hydroservo.core.hooks import line_pressures
from hydroservo.identification.log import COMMAND
from hydroservo.identification.log_check import stroke_of
from hydroservo.identification.maps.bent import bent_line, shift_commands
from hydroservo.identification.maps.monotone import (
    Edge,
    Points,
    answer_edge,
    has_answer,
    mirror_passes,
    side_points,
)
from hydroservo.identification.maps.piston import Piston, require_signals
from hydroservo.identification.maps.played import check_size, played_curve
from hydroservo.identification.maps.result import DrawnLine, Interval, MapContents, curve_of
from hydroservo.identification.maps.stairs import LEVEL, stairs, stretches_at_rest
from hydroservo.identification.maps.sweeps import (
    FEWEST,
    Pass,
    check_slow,
    command_span,
    hysteresis_of,
    lag_of,
    line_through,
    loops_of,
    passes,
    swept_curve,
    too_fast,
)
from hydroservo.identification.maps.valve_flow import (
    DEAD_BAND,
    WIDEST,
    at_no_load,
    dead_band_of,
    drops,
    flow_signals,
)
from hydroservo.identification.regression import thin_out
from hydroservo.identification.segments import Segment, UnderstoodLog

if TYPE_CHECKING:
    import xarray as xr

FLAT = 0.1  # of the mean slope, below which a point does not tell how far both directions lie apart
SLOPE_OFF = 0.03  # of the slope of a bent curve, by which volts are made of what lies between directions
ONE_SIDED = "no flow is met by both a rising and a falling command: reach the same levels from both sides"

Samples = NDArray[np.float64]


class Quantity(NamedTuple):
    """What a characteristic is of."""

    name: str
    unit: str
    meaning: str


FLOW = Quantity("flow", "m^3/s", "flow at port A at half of the supply's drop")
SPEED = Quantity("speed", "m/s", "speed of the piston, at the load that it met")


class Sides(NamedTuple):
    """Both sides of a table."""

    above: Points  # of the positive answer
    below: Points  # of the negative one, mirrored
    begins: tuple[Edge, Edge]  # where the positive answer begins, and the negative one
    null: Samples  # the commands at which the table is 0, shape (1,), or (2,) about a dead band [V]

    @property
    def null_half(self) -> Samples:
        """Half of the intervals of these, as answers."""
        edges = np.array([edge.half * edge.slope for edge in self.begins[::-1]])
        return edges if self.null.size > 1 else edges.mean(keepdims=True)


def characteristic_map(
    logs: Sequence[UnderstoodLog], loop: Loop | None, piston: Piston | None
) -> MapContents:
    """The flow of a valve over its command, or the speed of its axis, as a monotone table::

        Q = C(u -+ h/2 -+ T |du/dt|),   C = 0 between u- and u+, and not falling outside

    The upper signs are those of a rising command. Where the pressure in chamber A was measured, it is the
    flow at port A at half of the supply's drop, as ``valve-flow`` has it, else the speed at the load that the
    piston met, which has a single rod's areas in it. Where the command rests for most of a log, that is one
    of stairs, and the settled part of each of its levels counts.

    Source: ISO 10770-1 (flow over command without load, hysteresis); of the table, as ``side_points`` has it.
    Fails where the width of the hysteresis changes along the curve, of which it shows that at each point and
    takes off the mean; and where the axis creeps in the dead band, which then is narrower or none.
    """
    name = logs[0].log.name
    quantity = quantity_of(logs, loop, piston)
    met, remarks = samples_of(logs, quantity, loop, piston)
    span = command_span(met, name)
    check_both_ways(met, quantity, name)
    samples, apart = met, 0.0
    hysteresis: dict[str, Interval] = {}
    unknown = {"hysteresis": ONE_SIDED}
    line = bent_line(met)
    if line is None and any(one.rate.any() for one in met):  # a sweep so fast that no curve has both branches
        line = line_through(met)
    if line is not None:
        loops = loops_of([line], lag_of(loop))
        width, half = loops.hysteresis
        loops = loops._replace(hysteresis=(width, float(np.hypot(half, SLOPE_OFF * width))))
        remarks += check_slow(loops, WIDEST, span, name)
        if fast := too_fast(loops, WIDEST, span):
            raise ScenarioError(name, "command", fast)
        apart = max(
            loops.apart[0], 0.0
        )  # a width below 0 is none: what did not settle lies there as if it were
        samples = shift_commands(met, apart, loops.lag, loops.rate)
        hysteresis, unknown = hysteresis_of(loops)
    sides = sides_of(samples, name)
    edges, crossed = edge_numbers(sides)
    table = table_of(sides, samples, apart, quantity)
    check_size(table, loop, name)
    changes, left = played_curve(table, hysteresis.get("hysteresis"), loop)
    return MapContents(
        swept_curve(met, *quantity),
        edges | largest_answers(sides, quantity) | hysteresis,
        [DrawnLine("table", table["command"].values, table[quantity.name].values)],
        remarks=[*remarks, *left],
        undetermined=unknown | crossed,
        characteristic=table,
        changes=changes,
    )


def quantity_of(logs: Sequence[UnderstoodLog], loop: Loop | None, piston: Piston | None) -> Quantity:
    """The flow where its drop is known in all of the logs, else the speed."""
    if loop is None or piston is None:
        return SPEED
    line = line_pressures(loop)
    stretches = [{**one.measured, "velocity": np.zeros(one.samples)} for log in logs for one in log.segments]
    return FLOW if all(drops(rows, line, piston) for rows in stretches) else SPEED


def samples_of(
    logs: Sequence[UnderstoodLog], quantity: Quantity, loop: Loop | None, piston: Piston | None
) -> tuple[list[Pass], list[str]]:
    """The samples that count, of sweeps and of stairs, and what there is to say of them."""
    found: list[Pass] = []
    unsettled = 0
    for log in logs:
        require_signals(log, ("velocity", "position"), "a characteristic")
        check_command(log)
        for one in log.segments:
            period, command, answer = answer_in(one, quantity, loop, piston)
            if stretches_at_rest(command):
                levels, restless = stairs(command, answer)
                found += levels
                unsettled += restless
            else:
                found += passes(period, command, answer)
    return found, [*sample_remarks(quantity, unsettled, loop is not None)]


def sample_remarks(quantity: Quantity, unsettled: int, has_scenario: bool) -> Iterator[str]:
    """What there is to say of the samples."""
    if quantity is SPEED:
        why = "no pressure_a was measured" if has_scenario else "no scenario gives areas and supply"
        yield f"{why}: the table is the speed at the load that was met, and has a single rod's areas in it"
    if unsettled:
        yield f"{counted(unsettled, 'level')} of the command did not settle and are left out: rest longer"


def check_command(log: UnderstoodLog) -> None:
    """Refuse a log whose command never changes."""
    every = np.concatenate([one.inputs[COMMAND] for one in log.segments])
    if not np.ptp(every) > 0.0:
        problem = f"is {plain_quantity(float(every[0]), 'V')} throughout: it must rise and fall through null"
        raise ScenarioError(log.log.name, "command", problem)


def answer_in(
    one: Segment, quantity: Quantity, loop: Loop | None, piston: Piston | None
) -> tuple[float, Samples, Samples]:
    """The time between samples [s], the command, and flow or speed of a stretch."""
    rows = flow_signals(one, np.inf if loop is None else stroke_of(loop.plant))
    answer = rows["velocity"]
    if quantity is FLOW and loop is not None and piston is not None:
        answer = at_no_load(rows, line_pressures(loop), piston, one.period)
    period, few = thin_out(one.period, {COMMAND: rows[COMMAND], quantity.name: answer})
    return period, few[COMMAND], few[quantity.name]


def check_both_ways(samples: Sequence[Pass], quantity: Quantity, name: str) -> None:
    """Refuse samples of one direction of flow alone."""
    for way, side in (("positive", samples), ("negative", mirror_passes(samples))):
        if not has_answer(side):
            problem = f"shows no {way} {quantity.name} beyond its noise: sweep farther, and both ways"
            raise ScenarioError(name, "command", problem)


def sides_of(samples: Sequence[Pass], name: str) -> Sides:
    """Both sides of the table, which meet in a dead band or in one command."""
    mirrored = mirror_passes(samples)
    above, below = answer_edge(samples), answer_edge(mirrored)
    below = below._replace(command=-below.command)
    null = np.array([below.command, above.command])
    if not null[1] - null[0] > np.hypot(above.half, below.half):  # nor where one of these is nan
        null = null.mean(keepdims=True)
    check_levels(samples, null[-1], name)
    check_levels(mirrored, -null[0], name)
    plus, minus = side_points(samples, null[-1]), side_points(mirrored, -null[0])
    if plus is None or minus is None:
        raise ScenarioError(name, "command", "has too few samples for a table: sweep slower or more often")
    return Sides(plus, minus, (above, below), null)


def check_levels(side: Sequence[Pass], edge: float, name: str) -> None:
    """Refuse a side whose samples beyond its edge are all at one command."""
    every = np.concatenate([one.command for one in side])
    apart = LEVEL * np.ptp(every)
    beyond = every[every > edge + apart]
    if not beyond.size or np.ptp(beyond) <= apart:
        raise ScenarioError(name, "command", "has one level beyond null on a side: add some")


def edge_numbers(sides: Sides) -> tuple[dict[str, Interval], dict[str, str]]:
    """Where the answer begins, and why that cannot be determined."""
    above, below = sides.begins
    if why := above.why or below.why:
        return {}, dict.fromkeys(DEAD_BAND, why)
    numbers, unknown = dead_band_of((above.command, above.half), (below.command, below.half))
    if sides.null.size > 1 or unknown:
        return numbers, unknown
    why = f"it is at most {plain_quantity(numbers['dead_band'].high, 'V')} wide, and may be none"
    return {"null_offset": numbers["null_offset"]}, dict.fromkeys(DEAD_BAND[:3], why)


def largest_answers(sides: Sides, quantity: Quantity) -> dict[str, Interval]:
    """The ends of the table."""
    found = {}
    for way, sign, side in (("plus", 1.0, sides.above), ("minus", -1.0, sides.below)):
        meaning = f"{quantity.name} at {plain_quantity(sign * side.command[-1], 'V')}, where the table ends"
        value, half = sign * float(side.answer[-1]), float(side.half[-1])
        found[f"{quantity.name}_{way}"] = Interval.around(value, half, quantity.unit, meaning)
    return found


def table_of(sides: Sides, samples: Sequence[Pass], apart: float, quantity: Quantity) -> "xr.Dataset":
    """The points of the table, with what samples say of each."""
    command = np.concatenate([-sides.below.command[::-1], sides.null, sides.above.command])
    answer = np.concatenate([-sides.below.answer[::-1], 0.0 * sides.null, sides.above.answer])
    half = np.concatenate([sides.below.half[::-1], sides.null_half, sides.above.half])
    deviation, width, count = point_samples(samples, command, answer, apart)
    name, unit, meaning = quantity
    columns = command, answer, half, deviation, width, count.astype(int)
    about = {
        "command": ("V", "command"),
        name: (unit, meaning),
        f"{name}_half": (unit, "half of the 95 % interval"),
        f"{name}_deviation": (unit, "standard deviation of samples"),
        "hysteresis": ("V", "how far a falling and a rising command lie apart"),
        "samples": ("", "samples nearest to the point"),
    }
    return curve_of(dict(zip(about, columns, strict=True)), about).assign_attrs(quantity=name)


def point_samples(
    samples: Sequence[Pass], command: Samples, answer: Samples, apart: float
) -> tuple[Samples, Samples, Samples]:
    """The deviation of the samples nearest to each point, how far its directions lie apart, and how many.

    Directions lie apart by what they do in the mean, and by what samples here are beside the table over its
    slope; nan where the table is flat, or one direction has too few.
    """
    u = np.concatenate([one.command for one in samples])
    left = np.concatenate([one.answer for one in samples]) - np.interp(u, command, answer)
    rising = np.concatenate([np.full(one.command.size, one.rising) for one in samples])
    nearest = np.searchsorted(0.5 * (command[1:] + command[:-1]), u)
    slope = np.gradient(answer, command)
    steep = slope > FLAT * (answer[-1] - answer[0]) / (command[-1] - command[0])
    deviation, width, count = np.full((3, command.size), np.nan)
    for i in range(command.size):
        ways = [left[(nearest == i) & (rising == way)] for way in (True, False)]
        every = np.concatenate(ways)
        count[i] = every.size
        deviation[i] = every.std(ddof=1) if every.size > 1 else np.nan
        if steep[i] and min(one.size for one in ways) >= FEWEST:
            width[i] = apart + (ways[1].mean() - ways[0].mean()) / slope[i]
    return deviation, width, count
