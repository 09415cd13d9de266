"""No drive makes or loses oil, and none makes energy: balances over a run, integrated tightly."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from hydroservo import Loop, replace
from hydroservo.control.loop import MachineState
from hydroservo.control.wiring import wired
from hydroservo.core.block import values
from hydroservo.core.hooks import resting
from hydroservo.core.signals import PortFlows
from hydroservo.core.states import filled
from hydroservo.machine.drives import (
    CheckValve,
    Counterbalance,
    Hoses,
    Lines,
    LoadSensing,
    PortValves,
    PressureCompensator,
    PumpDrive,
    ValveOnSupply,
)
from hydroservo.machine.mechanics import Mass, Viscous
from hydroservo.machine.oils import ConstantOil
from hydroservo.machine.plants import Cylinder, LoadPressurePlant
from hydroservo.machine.supplies import IdealSupply, ReliefValve
from hydroservo.machine.valves import FourEdges, NoValve, StaticValve
from hydroservo.testing.examples import example

OIL = ConstantOil(1e9)
ROD = Cylinder(
    area_a=3.1e-3,
    area_b=1.6e-3,
    stroke=0.3,
    dead_volume_a=1e-4,
    dead_volume_b=1e-4,
    start_position=0.15,
    oil=OIL,
    mechanism=Mass(160.0),
    internal_leakage=1e-13,
    start_pressure_a=10e5,
    start_pressure_b=19.375e5,
    friction=Viscous(800.0),
)
CHECK = CheckValve(cracking_pressure=5e4, conductance=2e-9, pilot_ratio=3.0)
PUMP = PumpDrive(
    displacement=2.5e-6,
    command_gain=30.0,
    max_speed=300.0,
    speed_gain=2.0,
    max_torque=40.0,
    inertia=0.005,
    check_valve=CHECK,
    relief=ReliefValve(180e5, 1e-9),
    viscous=2e-3,
    leakage=2e-13,
    case_leakage=1e-13,
)
EDGES = FourEdges.rated(rated_flow=6e-4, rated_drop=70e5, rated_opening=1e-3)
VALVE = StaticValve(gain=1e-4, max_opening=1e-3, orifice=EDGES)
PUMPED = example(Loop, plant=ROD, valve=NoValve(), supply=IdealSupply(8e5, 1e5), drive=PUMP)
METERED = PUMPED._replace(valve=VALVE, supply=IdealSupply(120e5, 2e5), drive=ValveOnSupply())
HOSES = Hoses(1.5e-4, 1.2e-4, 5e9, 6e9, OIL)
LINES = Lines(1.5e-4, 2e6, 5e9, OIL)
COUNTERBALANCE = Counterbalance(
    pilot_ratio=3.0,
    cracking_pressure=30e5,
    opening_range=10e5,
    rated_flow=5e-4,
    rated_drop=15e5,
    check_valve=CheckValve(1e5, 2e-9),
    volume=5e-5,
    oil=OIL,
)
SPAN = 0.1  # s
Watched = Callable[[Loop, MachineState, MachineState, PortFlows, float], list[float]]


def run(loop: Loop, watched: Watched) -> tuple[MachineState, MachineState, NDArray[np.float64]]:
    """The first and the last state of a loop's machine, and the integrals of what is watched."""
    start, numbers = trajectory(loop, watched)
    count = len(values(start))
    return start, filled(start, iter(numbers[:count, -1].tolist())), numbers[count:, -1]


def trajectory(loop: Loop, watched: Watched) -> tuple[MachineState, NDArray[np.float64]]:
    """The first state of a loop's machine, and all states and integrals under u = 6 sin(10 pi t)."""
    loop = resting(loop)
    start = loop.machine(loop.init())
    count = len(values(start))

    def rates(t: float, numbers: NDArray[np.float64]) -> list[float]:
        x: MachineState = filled(start, iter(numbers[:count].tolist()))
        u = 6.0 * math.sin(10.0 * math.pi * t)
        rate, ports = loop.rates(x, u, 2000.0), loop.ports(x, u)
        flows = loop.plant.flows(x.plant, ports)
        seen = loop.plant.outputs(x.plant, ports.feed.line, 2000.0)
        power = ports.power(flows, seen.pressure_a, seen.pressure_b)
        return [*values(rate), *watched(loop, x, rate, flows, power)]

    extra = len(rates(0.0, np.array(values(start)))) - count
    first = [*values(start), *[0.0] * extra]
    size = np.maximum(np.abs(first), 1e-6)
    found = solve_ivp(rates, (0.0, SPAN), first, method="DOP853", rtol=1e-11, atol=1e-12 * size)
    return start, found.y


def chambers(loop: Loop, x: Any, rate: Any) -> tuple[float, float]:
    """What the oil in the two chambers takes in by compression [m^3/s]."""
    return rate.pressure_a / loop.plant.stiffness_a(x), rate.pressure_b / loop.plant.stiffness_b(x)


DRIVES = {
    "pump": PUMPED,
    "valve": METERED,
    "regeneration": METERED._replace(valve=VALVE._replace(orifice=EDGES._replace(regeneration=True))),
    "hoses": METERED._replace(drive=HOSES),
    "hoses of a pump": PUMPED._replace(drive=HOSES._replace(drive=PUMP)),
    "counterbalance in a": METERED._replace(drive=COUNTERBALANCE),
    "counterbalance in b": METERED._replace(drive=COUNTERBALANCE._replace(in_line_b=True)),
    "compensator": METERED._replace(drive=PressureCompensator(8e5)),
    "lines": METERED._replace(drive=LINES),
    "port valves": METERED._replace(drive=PortValves(ReliefValve(60e5, 2e-9), CheckValve(3e4, 2e-9))),
    "two pumps": PUMPED._replace(drive=PUMP._replace(displacement_ratio=0.5)),
    "load sensing": METERED._replace(drive=LoadSensing(20e5, 0.05)),
}


@pytest.mark.parametrize("name", DRIVES)
def test_what_leaves_the_lines_is_in_the_cylinder_in_the_hoses_or_compressed(name: str) -> None:
    def watched(loop: Loop, x: Any, rate: Any, flows: PortFlows, power: float) -> list[float]:
        a, b = chambers(loop, x.plant, rate.plant)
        return [flows.supply - flows.tank, abs(flows.supply) + abs(flows.tank), a + b]

    loop = DRIVES[name]
    start, end, (drawn, moved, compressed) = run(loop, watched)
    swept = (ROD.area_a - ROD.area_b) * (end.plant.position - start.plant.position)
    held = sum(
        volume * (after - before) / OIL.effective_bulk_modulus
        for volume, before, after in held_in(loop, start.drive, end.drive)
    )
    assert moved > 1e-6
    assert drawn == pytest.approx(swept + compressed + held, abs=1e-9 * moved)


BY_LOAD_PRESSURE = LoadPressurePlant(
    mass=160.0,
    damping=800.0,
    piston_area=2e-3,
    total_volume=8e-4,
    bulk_modulus=1e9,
    leakage=1e-13,
    stroke=0.3,
    start_position=0.15,
)


@pytest.mark.parametrize("drive", [ValveOnSupply(), Hoses(1.5e-4, 1.5e-4, 5e9, 5e9, OIL)])
def test_a_plant_described_by_its_load_pressure_neither_makes_nor_loses_oil(
    drive: ValveOnSupply | Hoses,
) -> None:
    """What goes in comes out of it; drives that would have it otherwise are refused, see tests/unit."""

    def watched(loop: Loop, x: Any, rate: Any, flows: PortFlows, power: float) -> list[float]:
        return [flows.supply - flows.tank, abs(flows.supply) + abs(flows.tank)]

    loop = wired(METERED._replace(plant=BY_LOAD_PRESSURE, drive=drive))
    start, end, (drawn, moved) = run(loop, watched)
    held = sum(
        volume * (after - before) / OIL.effective_bulk_modulus
        for volume, before, after in held_in(loop, start.drive, end.drive)
    )
    assert moved > 1e-6
    assert drawn == pytest.approx(held, abs=1e-9 * moved)


def held_in(loop: Loop, before: Any, after: Any) -> list[tuple[float, float, float]]:
    """The volumes of a drive that hold oil [m^3], with their pressures before and after [Pa]."""
    drive = loop.drive
    if isinstance(drive, Hoses):
        return [
            (drive.volume_a, before.pressure_a, after.pressure_a),
            (drive.volume_b, before.pressure_b, after.pressure_b),
        ]
    if isinstance(drive, Lines):
        return [
            (drive.volume, before.pressure_a, after.pressure_a),
            (drive.volume, before.pressure_b, after.pressure_b),
        ]
    if isinstance(drive, Counterbalance):
        return [(drive.volume, before.pressure, after.pressure)]
    return []


def pump_losses(drive: PumpDrive, s: Any, line: Any, a: float, b: float) -> float:
    """What a pump drive turns into heat [W]."""
    fed = [
        (line.supply - p) * (drive.check_valve.piloted(line.supply - p, other - line.supply))
        + (p - line.supply) * drive.relief.flow(p - line.supply)
        for p, other in ((a, b), (b, a))
    ]
    case = drive.case_leakage * ((a - line.tank) ** 2 + (b - line.tank) ** 2)
    return drive.viscous * s.speed**2 + drive.leakage * (a - b) ** 2 + case + sum(fed)


@pytest.mark.parametrize("name", ["pump", "two pumps", "hoses of a pump"])
def test_what_the_shaft_and_the_line_give_is_work_motion_compression_and_heat(name: str) -> None:
    def watched(loop: Loop, x: Any, rate: Any, flows: PortFlows, power: float) -> list[float]:
        plant, line = x.plant, loop.supply.pressures(x.supply)
        a, b = chambers(loop, plant, rate.plant)
        heat = loop.plant.friction.coefficient * plant.velocity**2
        heat += loop.plant.internal_leakage * (plant.pressure_a - plant.pressure_b) ** 2
        pump, ends = x.drive, (plant.pressure_a, plant.pressure_b)
        if isinstance(loop.drive, Hoses):
            pump, ends = x.drive.drive, (x.drive.pressure_a, x.drive.pressure_b)
            heat += loop.drive.resistance_a * flows.a**2 + loop.drive.resistance_b * flows.b**2
        heat += pump_losses(PUMP, pump, line, *ends)
        stored = plant.pressure_a * a + plant.pressure_b * b
        return [power - line.tank * flows.tank, abs(power), heat + stored + 2000.0 * plant.velocity]

    loop = DRIVES[name]
    start, end, (given, size, taken) = run(loop, watched)
    shafts = [getattr(one.drive, "drive", one.drive).speed for one in (start, end)]
    motion = 0.5 * 160.0 * (end.plant.velocity**2 - start.plant.velocity**2)
    motion += 0.5 * PUMP.inertia * (shafts[1] ** 2 - shafts[0] ** 2)
    motion += sum(
        0.5 * volume * (after**2 - before**2) / OIL.effective_bulk_modulus
        for volume, before, after in held_in(loop, start.drive, end.drive)
    )
    assert size > 10.0
    assert given == pytest.approx(motion + taken, abs=1e-9 * size)


@pytest.mark.parametrize("name", [name for name in DRIVES if "pump" not in name])
def test_no_drive_makes_energy(name: str) -> None:
    def watched(loop: Loop, x: Any, rate: Any, flows: PortFlows, power: float) -> list[float]:
        line = loop.supply.pressures(x.supply)
        given = x.plant.pressure_a * flows.a - x.plant.pressure_b * flows.b
        return [power - line.tank * flows.tank - given, abs(power)]

    loop = DRIVES[name]
    start, end, (lost, size) = run(loop, watched)
    if isinstance(loop.drive, Lines):
        pairs = zip(start.drive[2:4], end.drive[2:4], strict=True)
        lost -= sum(0.5 * loop.drive.inertance * (after**2 - before**2) for before, after in pairs)
    held = sum(
        0.5 * volume * (after**2 - before**2) / OIL.effective_bulk_modulus
        for volume, before, after in held_in(loop, start.drive, end.drive)
    )
    assert size > 10.0
    assert lost - held > 0.1 * size


def test_with_replenishing_no_chamber_is_torn_open() -> None:
    """The pump takes more out of the smaller chamber than comes; the supply's line gives the rest."""

    def lowest(loop: Loop) -> float:
        _, numbers = trajectory(loop, lambda *_: [])
        return float(numbers[2:4].min())  # both chambers' pressures

    assert lowest(PUMPED) > 5e5
    assert lowest(replace(PUMPED, {"drive.check_valve.conductance": 1e-15})) < -1e5
