"""The load pressure of blocked ports against the command, from slow sweeps about null."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ScenarioError
from hydroservo.core.formatting import quantity
from hydroservo.core.hooks import line_pressures
from hydroservo.core.signals import Pressures
from hydroservo.identification.log import COMMAND
from hydroservo.identification.maps.piston import Piston, require_signals
from hydroservo.identification.maps.result import DrawnLine, Interval, MapContents, unchanged_number
from hydroservo.identification.maps.sweeps import (
    DENSE,
    Pass,
    SweepLine,
    check_slow,
    choose_samples,
    command_span,
    hysteresis_of,
    lag_of,
    line_through,
    loops_of,
    passes,
    swept_curve,
)
from hydroservo.identification.regression import thin_out
from hydroservo.identification.segments import Segment, UnderstoodLog
from hydroservo.machine.valves.four_edges import FourEdges, blocked_pressure

SHARE = 0.4  # of the largest load pressure, up to which either way the gain is taken
FEW = 100  # means of a stretch, by which it is seen to move
MOVED = 1e-3  # m/s, from which on a port is not blocked
WIDEST = 0.4  # of the command's span, that both its directions may lie apart
POINTS = 41  # of a model's curve, from which its gain is taken

Samples = NDArray[np.float64]


def pressure_gain_map(logs: Sequence[UnderstoodLog], loop: Loop | None, piston: Piston | None) -> MapContents:
    """The pressure gain of a valve with blocked ports, by least squares::

        p_L = K_p (u - u_0 -+ h/2)          within 40 % of the largest load pressure, either way

    -h/2 as the command rises and +h/2 as it falls; p_L = p_A - p_B, or the hydraulic force over the piston's
    area of a plant that is described by its load pressure.

    Source: ISO 10770-1 and SAE ARP490 (the mean slope within 40 % of the largest load pressure).
    Fails where the lines hold so much oil that the valve's leakage does not keep up with the sweep.
    """
    sweeps: list[Pass] = []
    for log in logs:
        name = log.log.name
        for one in log.segments:
            check_blocked(one, name)
            signal = load_pressure(one, piston)
            if signal is None:
                require_signals(log, ("pressure_a",), "the pressure gain")
                require_signals(log, ("pressure_b",), "the pressure gain")
                raise ScenarioError(name, "", "pressure_a and pressure_b must be in the same stretch")
            period, rows = thin_out(one.period, {COMMAND: one.inputs[COMMAND], "p_L": signal}, DENSE)
            sweeps += passes(period, rows[COMMAND], rows["p_L"])
    name = logs[0].log.name
    span = command_span(sweeps, name)
    most = largest_load_pressure(sweeps, loop, name)
    line = gain_line(sweeps, SHARE * most, name)
    null, (slope, half) = line.null(), line.slope()
    values, left = ({}, []) if loop is None else edge_values(slope, half, loop)
    loops = loops_of([line], lag_of(loop) + oil_lag(values, loop, piston))
    remarks = [*check_slow(loops, WIDEST, span, name)]
    hysteresis, unknown = hysteresis_of(loops)
    valve: Any = None if loop is None else loop.valve
    if hasattr(valve, "hysteresis") and values and hysteresis:
        values["valve.hysteresis"] = hysteresis["hysteresis"].times(valve.gain, "m")
    numbers = {
        "pressure_gain": Interval.around(slope, half, "Pa/V", "pressure gain at null"),
        "null_offset": Interval.around(*null, "V", "command at which the load pressure is 0"),
        **hysteresis,
    }
    reach = SHARE * most / slope
    ends = null[0] + reach * np.array([-1.0, 1.0])
    drawn = DrawnLine("line", ends, SHARE * most * np.array([-1.0, 1.0]))
    curve = swept_curve(sweeps, "load_pressure", "Pa", "load pressure p_A - p_B")
    return MapContents(curve, numbers, [drawn], values, [*remarks, *left], unknown)


def check_blocked(one: Segment, name: str) -> None:
    """Refuse a log in which the piston moves."""
    rows = {key: one.measured[key] for key in ("velocity", "position") if key in one.measured}
    if rows:
        period, few = thin_out(one.period, rows, FEW)  # means, for a position's slope is noisy
        speeds = few["velocity"] if "velocity" in few else np.gradient(few["position"], period)
        moved = float(np.nanmedian(np.abs(speeds)))
        if moved > MOVED:
            shown = quantity(moved, "m/s")
            problem = f"the piston moves, at {shown} and faster half of the time: ports must be blocked"
            raise ScenarioError(name, "", problem)


def load_pressure(one: Segment, piston: Piston | None) -> Samples | None:
    """p_L [Pa]; None where it was not measured."""
    if {"pressure_a", "pressure_b"} <= set(one.measured):
        return one.measured["pressure_a"] - one.measured["pressure_b"]
    if "hydraulic_force" in one.measured and piston is not None and not piston.has_chambers:
        return one.measured["hydraulic_force"] / piston.area_a
    return None


def largest_load_pressure(sweeps: Sequence[Pass], loop: Loop | None, name: str) -> float:
    """The largest load pressure: the supply's drop, or that of the sweep without a scenario [Pa]."""
    seen = float(np.quantile(np.abs(np.concatenate([one.answer for one in sweeps])), 0.99))
    if loop is None:
        return seen
    line = line_pressures(loop)
    drop = float(line.supply - line.tank)
    if not seen > SHARE * drop:
        problem = (
            f"the load pressure reaches {quantity(seen, 'Pa')}, and the gain is taken up to 40 % of the "
            f"supply's {quantity(drop, 'Pa')}: sweep farther, with blocked ports"
        )
        raise ScenarioError(name, "", problem)
    return drop


def gain_line(sweeps: Sequence[Pass], reach: float, name: str) -> SweepLine:
    """The line through samples within ``reach`` [Pa], 40 % of the largest load pressure."""
    found = line_through(choose_samples(sweeps, -reach, reach))
    if found is not None:
        return found
    mirrored = [one._replace(answer=-one.answer) for one in sweeps]
    if line_through(choose_samples(mirrored, -reach, reach)) is not None:
        problem = "p_A - p_B falls as the command rises: pressure_a and pressure_b are swapped, or command is"
        raise ScenarioError(name, "", f"{problem} reversed")
    problem = (
        "too few samples within 40 % of the largest load pressure rise with the command, both ways: "
        "block the ports, and sweep slower, more often or less far"
    )
    raise ScenarioError(name, "", problem)


def edge_values(slope: float, half: float, loop: Loop) -> tuple[dict[str, Interval], list[str]]:
    """The clearance of the scenario's edges that has the gain, and what has no place in the scenario."""
    valve: Any = loop.valve
    edges: Any = getattr(valve, "orifice", None)
    left = ["null_offset has no place in a scenario"]
    if not isinstance(edges, FourEdges) or any((edges.extra_lap_pa, edges.extra_lap_at, edges.extra_lap_pb)):
        return {}, [*left, f"{type(edges).__name__} has no clearance that the pressure gain would tell"]
    line = line_pressures(loop)
    gains = (slope, slope + half, slope - half)
    found = [clearance_of(edges, one / valve.gain, line) for one in gains]
    if any(one is None for one in found):
        steepest = "edges of the scenario's lap cannot have this pressure gain"
        return {}, [*left, f"{steepest}: it says nothing of valve.orifice.clearance"]
    best, low, high = (float(one or 0.0) for one in found)
    meaning = "opening of an edge that is just closed"
    values = {"valve.orifice.clearance": Interval(best, low, high, "m", meaning)}
    values["valve.orifice.area_gradient"] = unchanged_number(edges.area_gradient)
    return values, left


def oil_lag(values: Mapping[str, Interval], loop: Loop | None, piston: Piston | None) -> float:
    """The time in which the valve's leakage fills the blocked volumes, V/(beta dQ/dp) at null [s].

    0 where the edges or the volumes are not known.
    """
    if loop is None or piston is None or not piston.has_chambers or not values:
        return 0.0
    edges: Any = loop.valve
    edges = edges.orifice._replace(clearance=values["valve.orifice.clearance"].value)
    line = line_pressures(loop)
    middle, step = 0.5 * (line.supply + line.tank), 1e-3 * (line.supply - line.tank)
    flows = [edges.port_flows(0.0, line, p, p).a for p in (middle - step, middle + step)]
    volumes = piston.volumes(np.array([piston.plant.start_position]))
    volume = 0.5 * float(volumes[0][0] + volumes[1][0])
    return float(volume / piston.plant.oil.bulk_modulus(middle) * 2.0 * step / (flows[0] - flows[1]))


def clearance_of(edges: FourEdges, gain: float, line: Pressures) -> float | None:
    """The clearance with which blocked ports have a pressure gain [m]; None if none does."""
    from scipy.optimize import brentq

    def beyond(clearance: float) -> float:
        return gain_per_opening(edges._replace(clearance=clearance), line) - gain

    least, most = 1e-8, 1e-3
    if not beyond(least) > 0.0 > beyond(most):
        return None
    return float(brentq(beyond, least, most, rtol=1e-9))


def gain_per_opening(edges: FourEdges, line: Pressures) -> float:
    """The slope of the load pressure over the opening, as :func:`pressure_gain_map` takes it [Pa/m]."""
    from scipy.optimize import brentq

    drop = line.supply - line.tank
    fed = Pressures(drop, 0.0)

    def load(x: float) -> float:
        a = blocked_pressure(lambda p: edges.port_flows(x, fed, p, p).a, drop)
        b = blocked_pressure(lambda p: -edges.port_flows(x, fed, p, p).b, drop)
        return a - b

    reach = brentq(lambda x: load(x) - SHARE * drop, 0.0, 1.0, rtol=1e-9)
    openings = np.linspace(-reach, reach, POINTS)
    return float(np.polyfit(openings, [load(x) for x in openings], 1)[0])
