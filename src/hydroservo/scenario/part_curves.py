"""What the block of a part does, in the curves of data sheets."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.block import Block
from hydroservo.core.command_scale import FULL
from hydroservo.core.roles import Accumulator, MeteringEdges, Oil, Plant, Supply, Valve
from hydroservo.machine.valves.second_order import UNLIMITED

Vector = NDArray[np.float64]
Rated = Mapping[str, float]  # what constructors take, in SI units, by path in the block
RATED_DROP = 7e6  # [Pa] over two edges, at which servo valves are rated
FORCE_PRESSURE, MEAN_PRESSURE = 1e7, 5e6  # [Pa] of a cylinder's forces, and in both of its chambers
HIGHEST = 3e7  # [Pa] of curves over pressure
POINTS, STEPS = 241, 2400  # of a curve, and of one that is an integral
SMALL = 1e-3  # of a valve's range, by which it is moved to find its slopes
SMALL_MOTIONS = {"hysteresis": 0.0, "slew_limit": UNLIMITED}  # of a valve
DECADES = 1.0  # of a frequency response, to either side of the corner


class PartResult(NamedTuple):
    """What follows from a part's numbers, in an SI unit."""

    meaning: str
    value: float
    unit: str


class PartCurve(NamedTuple):
    """A line of a panel, its two axes in SI units."""

    label: str
    x: Vector
    y: Vector


class PartPanel(NamedTuple):
    """A panel of a part's picture, its axes with their SI units."""

    x: tuple[str, str]
    y: tuple[str, str]
    curves: tuple[PartCurve, ...]
    logarithmic: bool = False  # the axis of x


class PartSheet(NamedTuple):
    """What follows from a part."""

    results: tuple[PartResult, ...] = ()
    panels: tuple[PartPanel, ...] = ()
    caption: str = ""


def no_sheet(_block: Block, _rated: Rated) -> PartSheet:
    """Of a block of whose role no data sheet has a curve."""
    return PartSheet()


def valve_sheet(valve: Any, rated: Rated) -> PartSheet:
    """Flow over command at the rated drop, and the frequency response of small motions."""
    drop = rated.get("orifice.rated_drop", RATED_DROP)
    if not (hasattr(valve, "gain") and hasattr(valve, "max_opening") and hasattr(valve.orifice, "flow")):
        return PartSheet()
    share = np.linspace(-1.0, 1.0, POINTS)
    commanded = np.clip(valve.gain * FULL * share, -valve.max_opening, valve.max_opening)
    half = 0.5 * getattr(valve, "hysteresis", 0.0)
    ways = (("command rises", -half), ("command falls", half)) if half else (("", 0.0),)
    curves = []
    for label, lag in ways:
        opened = np.clip(commanded + lag, -valve.max_opening, valve.max_opening)
        curves.append(PartCurve(label, 100.0 * share, flows(valve.orifice, opened, drop)))
    (full,) = flows(valve.orifice, np.array([valve.max_opening]), drop)
    results = [PartResult(f"flow of the open valve under {drop * 1e-5:g} bar", float(full), "m^3/s")]
    panels = [PartPanel(("command", "%"), (f"flow under {drop * 1e-5:g} bar", "m^3/s"), tuple(curves))]
    caption = "Flow over command at the drop over both edges"
    state = valve.init()
    if state and all(isinstance(one, float) for one in state):
        panels += response_panels(valve)
        caption += "; response of small motions, without hysteresis and limits of speed"
        results += [
            PartResult(name.replace("_", " "), getattr(valve, name), unit)
            for name, unit in (("natural_frequency", "rad/s"), ("damping_ratio", ""), ("time_constant", "s"))
            if name in valve._fields
        ]
    return PartSheet(tuple(results), tuple(panels), f"{caption}.")


def flows(edges: Any, openings: Vector, drop: float) -> Vector:
    """The flows of edges under a drop, without load [m^3/s]."""
    return np.array([float(edges.flow(float(one), drop, 0.0)) for one in openings])


def response_panels(valve: Any) -> list[PartPanel]:
    """Amplitude and phase of a valve's opening over frequency, from the slopes of its equations at null."""
    small = {name: value for name, value in SMALL_MOTIONS.items() if name in valve._fields}
    rates, inputs = valve_slopes(valve._replace(**small))
    corner = float(np.abs(np.linalg.eigvals(rates)).max()) / (2.0 * math.pi)
    frequency = np.geomspace(corner * 10.0**-DECADES, corner * 10.0 ** (0.5 * DECADES), POINTS)
    unit = np.eye(len(inputs))
    opened = np.array([np.linalg.solve(2j * math.pi * f * unit - rates, inputs)[0] for f in frequency])
    still = np.linalg.solve(-rates, inputs)[0]
    gain, phase = opened / still, np.degrees(np.unwrap(np.angle(opened / still)))
    x = ("frequency", "Hz")
    return [
        PartPanel(x, ("amplitude", "dB"), (PartCurve("", frequency, 20.0 * np.log10(np.abs(gain))),), True),
        PartPanel(x, ("phase", "deg"), (PartCurve("", frequency, phase),), True),
    ]


def valve_slopes(valve: Any) -> tuple[Vector, Vector]:
    """The slopes of a valve's rates by its state, whose first number is the opening, and by its command."""
    start, step = valve.init(), SMALL * valve.max_opening

    def rates(offsets: Vector, command: float) -> Vector:
        state = type(start)(*(a + float(b) for a, b in zip(start, offsets, strict=True)))
        return np.array(valve.deriv(state, command), dtype=float)

    columns = [(rates(one, 0.0) - rates(-one, 0.0)) / (2.0 * step) for one in step * np.eye(len(start))]
    command, still = SMALL * FULL, np.zeros(len(start))
    return np.array(columns).T, (rates(still, command) - rates(still, -command)) / (2.0 * command)


def edges_sheet(edges: Any, rated: Rated) -> PartSheet:
    """Flow over opening at the rated drop."""
    if "rated_opening" not in rated:
        return PartSheet()
    drop, share = rated["rated_drop"], np.linspace(-1.0, 1.0, POINTS)
    flow = flows(edges, rated["rated_opening"] * share, drop)
    y = (f"flow under {drop * 1e-5:g} bar", "m^3/s")
    results = (PartResult(f"flow when rated, under {drop * 1e-5:g} bar", float(flow[-1]), "m^3/s"),)
    panel = PartPanel(("opening of the rated one", "%"), y, (PartCurve("", 100.0 * share, flow),))
    return PartSheet(results, (panel,), "Flow over opening at the drop over both edges.")


def cylinder_sheet(plant: Any, _rated: Rated) -> PartSheet:
    """Areas and forces, and the natural frequency of the load on the oil over the stroke."""
    if not hasattr(plant, "area_a"):
        return PartSheet()
    position = np.linspace(0.0, plant.stroke, POINTS)
    frequency = np.array([load_frequency(plant, float(x)) for x in position])
    results = (
        PartResult("area of the piston", plant.area_a, "m^2"),
        PartResult("area of the ring", plant.area_b, "m^2"),
        PartResult("force out at 100 bar", FORCE_PRESSURE * plant.area_a, "N"),
        PartResult("force in at 100 bar", FORCE_PRESSURE * plant.area_b, "N"),
        PartResult("lowest natural frequency", float(frequency.min()), "Hz"),
    )
    panel = PartPanel(("position", "m"), ("natural frequency", "Hz"), (PartCurve("", position, frequency),))
    return PartSheet(results, (panel,), "Natural frequency of the load on both columns of oil, at 50 bar.")


def load_frequency(plant: Any, position: float) -> float:
    """sqrt((A_A^2 beta/V_A + A_B^2 beta/V_B)/m)/(2 pi) at a position [Hz]."""
    state = plant.init()._replace(position=position, pressure_a=MEAN_PRESSURE, pressure_b=MEAN_PRESSURE)
    stiffness = plant.area_a**2 * plant.stiffness_a(state) + plant.area_b**2 * plant.stiffness_b(state)
    mass = plant.carried.inertia(state.carried, plant.mechanism, position)
    return math.sqrt(stiffness / mass) / (2.0 * math.pi)


def oil_sheet(oil: Any, _rated: Rated) -> PartSheet:
    """Bulk modulus over pressure."""
    pressure = np.linspace(0.0, HIGHEST, POINTS)
    modulus = np.array([float(oil.bulk_modulus(float(one))) for one in pressure])
    results = (PartResult("bulk modulus at 100 bar", float(oil.bulk_modulus(FORCE_PRESSURE)), "Pa"),)
    panel = PartPanel(("pressure", "Pa"), ("bulk modulus", "Pa"), (PartCurve("", pressure, modulus),))
    return PartSheet(results, (panel,), "Bulk modulus of the oil with its air over pressure.")


def accumulator_sheet(accumulator: Any, _rated: Rated) -> PartSheet:
    """Oil taken in over pressure."""
    pressure = np.linspace(0.0, HIGHEST, STEPS + 1)
    middle = 0.5 * (pressure[1:] + pressure[:-1])
    compliance = np.array([float(accumulator.compliance(float(one))) for one in middle])
    oil = np.concatenate([[0.0], np.cumsum(compliance * np.diff(pressure))])
    results = (PartResult("oil taken in up to 200 bar", float(np.interp(2e7, pressure, oil)), "m^3"),)
    panel = PartPanel(("pressure", "Pa"), ("oil taken in", "m^3"), (PartCurve("", pressure, oil),))
    return PartSheet(results, (panel,), "Oil taken in from the precharge on.")


def supply_sheet(supply: Any, rated: Rated) -> PartSheet:
    """Flow of a pump over pressure, the relief valve shut."""
    if "rated_pressure" not in rated or not hasattr(supply, "speed_gain"):
        return PartSheet()
    highest = rated["rated_pressure"]
    pressure = np.linspace(0.0, highest, POINTS)
    slope = supply.speed_gain + supply.viscous
    speed = (supply.speed_gain * supply.demanded_speed - supply.displacement * pressure) / slope
    flow = supply.displacement * speed - supply.leakage * pressure
    results = (
        PartResult("flow without pressure", float(flow[0]), "m^3/s"),
        PartResult(f"flow at {highest * 1e-5:g} bar", float(flow[-1]), "m^3/s"),
    )
    panel = PartPanel(("pressure", "Pa"), ("flow", "m^3/s"), (PartCurve("", pressure, flow),))
    return PartSheet(results, (panel,), "Flow of the pump over pressure at its rated speed.")


SHEETS: Mapping[type, Callable[[Any, Rated], PartSheet]] = {
    Plant: cylinder_sheet,
    Valve: valve_sheet,
    MeteringEdges: edges_sheet,
    Supply: supply_sheet,
    Accumulator: accumulator_sheet,
    Oil: oil_sheet,
}
ASSUMED: Mapping[type, Mapping[str, Any]] = {  # for a sheet alone
    Plant: {
        "stroke": "300 mm",
        "oil": {"type": "AeratedOil"},
        "mechanism": {"type": "Mass", "mass": "100 kg"},
    },
    Accumulator: {"precharge": "100 bar"},
    Supply: {
        "max_torque": "1000 N m",
        "inertia": "0.01 kg m^2",
        "volume": "1 L",
        "bulk_modulus": "14000 bar",
        "speed_gain": "1e6 N m s/rad",
        "relief": {"type": "ReliefValve", "cracking_pressure": "300 bar", "gradient": "1e-9 m^3/(s Pa)"},
    },
}
