"""The flow of a valve against its command, from slow sweeps of a cylinder that moves freely."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import quantity
from hydroservo.core.hooks import line_pressures
from hydroservo.core.signals import Pressures
from hydroservo.identification.log import COMMAND
from hydroservo.identification.log_check import stroke_of
from hydroservo.identification.maps.monotone import has_answer, mirror_passes
from hydroservo.identification.maps.piston import Piston, require_signals, stretch_velocity
from hydroservo.identification.maps.result import DrawnLine, Interval, MapContents, unchanged_number
from hydroservo.identification.maps.sweeps import (
    Pass,
    SweepLine,
    check_slow,
    choose_samples,
    command_span,
    hysteresis_of,
    lag_of,
    line_through,
    loops_of,
    mean_answer,
    passes,
    swept_curve,
    too_fast,
)
from hydroservo.identification.regression import thin_out
from hydroservo.identification.segments import Segment, UnderstoodLog

LINEAR = (0.15, 0.85)  # of the largest flow, between which the curve is taken for a line
LEAST_DROP = 0.05  # of half the supply's, below which none is divided by
END = 1e-3  # of the stroke, within which the piston rests at its end
WINDOW = 25  # samples of a mean velocity, by which it has a sign
WIDEST = 0.1  # of the command's span, that both its directions may lie apart
DEAD_BAND = ("dead_band_plus", "dead_band_minus", "dead_band", "null_offset")
BENT = 0.05  # of the largest flow, that may be left of a line
MEASURE_IT = "map characteristic measures a bent one"

Samples = NDArray[np.float64]


class Side(NamedTuple):
    """The line of one direction of flow."""

    line: SweepLine  # the regression
    largest: float  # flow [m^3/s]


def valve_flow_map(logs: Sequence[UnderstoodLog], loop: Loop, piston: Piston) -> MapContents:
    """The flow curve of a valve without load::

        Q = k+ (u - u+ -+ h/2) above u+,   k- (u - u- -+ h/2) below u-,   0 between

    -h/2 as the command rises and +h/2 as it falls. The flow is A_A v, and with both pressures measured what
    leaks and is compressed by the scenario's numbers too. With pressure_a measured it is that at half of the
    supply's drop, Q sqrt(d_0/d) with d the drop over the edge of port A that is open.

    Source: ISO 10770-1 (flow curve, lap by straight lines that are carried on to no flow, hysteresis).
    Fails where leakage and compression count beside the flow and are not known, and for a flow whose gain
    bends: then a deviation from the lines is said.
    """
    line = line_pressures(loop)
    sweeps: list[Pass] = []
    normalised = True
    for log in logs:
        require_signals(log, ("velocity", "position"), "a flow curve")
        for one in log.segments:
            period, rows = thin_out(one.period, flow_signals(one, stroke_of(piston.plant)))
            normalised &= "drop" in drops(rows, line, piston)
            flow = at_no_load(rows, line, piston, period)
            sweeps += passes(period, rows[COMMAND], flow)
    name = logs[0].log.name
    span = command_span(sweeps, name)
    sides = {sign: side_of(sweeps, sign, name) for sign in (1.0, -1.0)}
    loops = loops_of([side.line for side in sides.values()], lag_of(loop), static=normalised)
    remarks = [*check_slow(loops, WIDEST, span, name), *flow_remarks(sides, normalised)]
    hysteresis, unknown = hysteresis_of(loops)
    numbers = gains_of(sides, "" if normalised else ", at the load that it met") | hysteresis
    fast = too_fast(loops, WIDEST, span)
    edges, crossed = dead_band_of(*(sides[sign].line.null() for sign in (1.0, -1.0)))
    if fast:
        edges, crossed = {}, dict.fromkeys(DEAD_BAND, fast)
    numbers |= edges
    curve = swept_curve(sweeps, "flow", "m^3/s", "flow at port A without load")
    values, left = valve_values(numbers, loop, line, normalised)
    return MapContents(curve, numbers, [*flow_lines(sides)], values, [*remarks, *left], unknown | crossed)


def flow_signals(one: Segment, stroke: float) -> dict[str, Samples]:
    """Signals that count, with nan where the piston is at an end of its stroke [m]."""
    velocity = stretch_velocity(one)
    if "position" in one.measured and np.isfinite(stroke):
        x = one.measured["position"]
        velocity = np.where((x > END * stroke) & (x < (1.0 - END) * stroke), velocity, np.nan)
    taken = ("position", "pressure_a", "pressure_b", "hydraulic_force")
    return {COMMAND: one.inputs[COMMAND], "velocity": velocity} | {
        name: one.measured[name] for name in taken if name in one.measured
    }


def drops(rows: Mapping[str, Samples], line: Pressures, piston: Piston) -> dict[str, Samples]:
    """The drop over the open edge of port A [Pa], where pressures tell it."""
    outwards = uniform_mean(rows["velocity"]) > 0.0
    if "pressure_a" in rows:
        a = rows["pressure_a"]
        return {"drop": np.where(outwards, line.supply - a, a - line.tank)}
    if "hydraulic_force" in rows and not piston.has_chambers:
        load = rows["hydraulic_force"] / piston.area_a
        return {"drop": 0.5 * (line.supply - line.tank - np.where(outwards, load, -load))}
    return {}


def uniform_mean(values: Samples) -> Samples:
    """Means over neighbours, by which a noisy velocity has a sign."""
    there = np.isfinite(values)
    window = np.ones(WINDOW)
    sums = np.convolve(np.where(there, values, 0.0), window, mode="same")
    return np.asarray(sums / np.maximum(np.convolve(there, window, mode="same"), 1.0))


def at_no_load(rows: Mapping[str, Samples], line: Pressures, piston: Piston, period: float) -> Samples:
    """The flow at port A [m^3/s], at half of the supply's drop where pressures tell it."""
    flow: Samples = piston.area_a * rows["velocity"] + beside_motion(rows, piston, period)
    half = 0.5 * (line.supply - line.tank)
    for drop in drops(rows, line, piston).values():
        flow = flow * np.sqrt(half / np.maximum(drop, LEAST_DROP * half))
    return flow


def beside_motion(rows: Mapping[str, Samples], piston: Piston, period: float) -> Samples:
    """What of the flow at port A leaks and is compressed, by the scenario's numbers [m^3/s]."""
    plant = piston.plant
    if not piston.has_chambers or not {"pressure_a", "pressure_b"} <= rows.keys():
        return np.zeros(rows["velocity"].size)
    a, b = rows["pressure_a"], rows["pressure_b"]
    leaks = plant.internal_leakage * (a - b) + plant.external_leakage * np.maximum(a, 0.0)
    position = rows.get("position", np.full(a.size, plant.start_position))
    modulus = np.array([plant.oil.bulk_modulus(p) for p in a.tolist()])
    found: Samples = leaks + piston.volumes(position)[0] / modulus * np.gradient(a, period)
    return found


def side_of(sweeps: Sequence[Pass], sign: float, name: str) -> Side:
    """The line of one direction of flow."""
    means = np.concatenate([mean_answer(sweeps, rising)[1] for rising in (True, False)])
    largest = float((sign * means).max())
    found = None
    if largest > 0.05 * float(np.abs(means).max()):
        on_line = choose_samples(sweeps, *sorted(sign * share * largest for share in LINEAR))
        found = line_through(on_line)
    if found is None:
        way = "positive" if sign > 0.0 else "negative"
        problem = f"shows no {way} flow that follows the command: sweep farther, slower, or both ways"
        if has_answer(sweeps if sign > 0.0 else mirror_passes(sweeps)):
            problem = f"its {way} flow is bent, and no straight line goes through it: {MEASURE_IT}"
        raise ScenarioError(name, "command", problem)
    return Side(found, largest)


def gains_of(sides: Mapping[float, Side], at: str) -> dict[str, Interval]:
    """The flow gains, and at which load."""
    plus, minus = (sides[sign].line.slope() for sign in (1.0, -1.0))
    unit = "m^3/(s V)"
    return {
        "flow_gain_plus": Interval.around(*plus, unit, f"flow gain of positive flow{at}"),
        "flow_gain_minus": Interval.around(*minus, unit, f"flow gain of negative flow{at}"),
    }


def dead_band_of(
    above: tuple[float, float], below: tuple[float, float]
) -> tuple[dict[str, Interval], dict[str, str]]:
    """Where flow begins either way, each with half its interval [V], and what of it cannot be determined."""
    half = 0.5 * float(np.hypot(above[1], below[1]))
    middle = Interval.around(0.5 * (above[0] + below[0]), half, "V", "middle of the dead band")
    width = Interval.around(above[0] - below[0], 2.0 * half, "V", "width of the dead band")
    if width.high < 0.0:
        overlap = quantity(-width.value, "V")
        why = f"both lines reach no flow {overlap} beyond each other, as those of an underlapped valve do"
        return {"null_offset": middle}, dict.fromkeys(DEAD_BAND[:3], why)
    return {
        "dead_band_plus": Interval.around(*above, "V", "command at which positive flow begins"),
        "dead_band_minus": Interval.around(*below, "V", "command at which negative flow begins"),
        "dead_band": width.at_least_0(),
        "null_offset": middle,
    }, {}


def flow_lines(sides: Mapping[float, Side]) -> Iterator[DrawnLine]:
    """The lines, in the mean of both directions of the command."""
    x, y = [], []
    for sign, side in sides.items():
        edge, gain = side.line.null()[0], side.line.slope()[0]
        end = edge + sign * side.largest / gain
        x += [edge, end, np.nan]
        y += [0.0, sign * side.largest, np.nan]
    yield DrawnLine("lines", np.array(x), np.array(y))


def flow_remarks(sides: Mapping[float, Side], normalised: bool) -> Iterator[str]:
    """What there is to say of the lines."""
    if not normalised:
        yield (
            "no pressure_a was measured: the flow is that at the load that the piston met, intervals do not "
            "hold that without load, and the area of the edges is not told"
        )
    for sign, side in sides.items():
        if side.line.found.scatter > BENT * side.largest:
            way = "positive" if sign > 0.0 else "negative"
            share = 100.0 * side.line.found.scatter / side.largest
            beside = f"{way} flow lies {share:.2g} % of its largest beside its line"
            yield f"{beside}: it bends or swings; {MEASURE_IT}"


def valve_values(
    numbers: Mapping[str, Interval], loop: Loop, line: Pressures, normalised: bool
) -> tuple[dict[str, Interval], list[str]]:
    """The numbers of the scenario's valve, and what has no place in it."""
    valve: Any = loop.valve
    orifice: Any = getattr(valve, "orifice", None)
    if not hasattr(orifice, "area_gradient") or not hasattr(valve, "gain"):
        return {}, [f"{type(valve).__name__} has no gain and area gradient that would be written"]
    left = ["null_offset has no place in a scenario"] if "null_offset" in numbers else []
    found = {"valve.orifice.area_gradient": unchanged_number(orifice.area_gradient)}
    if normalised:
        gain = mean_gain(numbers)
        opening = 0.5 * valve.max_opening
        per_opening = flow_per_opening(orifice._replace(area_gradient=1.0), opening, line.supply - line.tank)
        found["valve.orifice.area_gradient"] = gain.times(1.0 / (valve.gain * per_opening), "m")
    if hasattr(orifice, "lap") and "dead_band" in numbers:
        overlap = numbers["dead_band"].times(0.5 * valve.gain, "m")
        extra = getattr(orifice, "extra_lap_pa", 0.0) + getattr(
            orifice, "extra_lap_at", 0.0
        )  # port A's, stays
        value, low, high = (end - 0.5 * float(extra) for end in overlap[:3])
        found["valve.orifice.lap"] = Interval(value, low, high, overlap.unit, overlap.meaning)
        found["valve.orifice.clearance"] = unchanged_number(orifice.clearance)
    if hasattr(valve, "hysteresis") and "hysteresis" in numbers:
        found["valve.hysteresis"] = numbers["hysteresis"].times(valve.gain, "m")
    return found, left


def mean_gain(numbers: Mapping[str, Interval]) -> Interval:
    """The mean of both ways' flow gains."""
    gains = [numbers["flow_gain_plus"], numbers["flow_gain_minus"]]
    widths = [one.high - one.low for one in gains]
    half = 0.25 * float(np.hypot(widths[0], widths[1]))
    mean = 0.5 * (gains[0].value + gains[1].value)
    return Interval.around(mean, half, gains[0].unit, "area of an edge per opening, the mean of both ways")


def flow_per_opening(edges: Any, opening: float, drop: float) -> float:
    """Flow per opening, around one that is open by far [m^2/s]."""
    high, low = (edges.flow(factor * opening, drop, 0.0) for factor in (1.05, 0.95))
    return float((high - low) / (0.1 * opening))
