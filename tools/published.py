"""Machines that others computed, rebuilt from these blocks: their numbers, and ours beside them."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from hydroservo import load_scenario, simulate
from hydroservo.core.constants import ATMOSPHERE, GRAVITY
from hydroservo.core.signals import PortFlows, Pressures
from hydroservo.machine.drives import open_ports
from hydroservo.machine.mechanics import Mass, NoStops, OneLinkArm, Viscous, ViscousState
from hydroservo.machine.oils import AeratedOil, ConstantOil
from hydroservo.machine.plants import Cylinder, CylinderState
from hydroservo.machine.supplies import GasAccumulator, PumpSupply
from hydroservo.machine.valves import FourEdges, SecondOrderValve, SecondOrderValveState
from hydroservo.testing.examples import example

INCH, POUND, PSI = 0.0254, 0.45359237, 6894.757293168361
VAST = 1e6  # by which a chamber and its oil's stiffness grow together, so that its volume stays what it is

Vector = NDArray[np.float64]


class Compared(NamedTuple):
    """A number of theirs, and what the blocks here give for it."""

    what: str
    unit: str
    theirs: float
    ours: float
    within: float  # relative, what theirs can be trusted to

    @property
    def deviation(self) -> float:
        """Ours less theirs, relative to theirs."""
        return self.ours / self.theirs - 1.0


class Case(NamedTuple):
    """What somebody published of a machine."""

    name: str
    source: str
    trusted: str  # why theirs is trusted that far
    compared: Callable[[], list[Compared]]


def cylinder_state(y: Vector) -> CylinderState:
    velocity, position, pressure_a, pressure_b = map(float, y[:4])
    return CylinderState(velocity, position, pressure_a, pressure_b, ViscousState())


def cylinder_rates(plant: Cylinder, flows: PortFlows, y: Vector) -> Vector:
    """The rates of velocity, position and the two pressures."""
    return np.array(plant.deriv(cylinder_state(y), flows, 0.0)[:4])


def port_flows(plant: Cylinder, edges: FourEdges, opening: float, line: Pressures, y: Vector) -> PortFlows:
    return plant.flows(cylinder_state(y), open_ports(edges, opening, line))


def natural_frequency() -> list[Compared]:
    """4 in bore, 2.5 in rod, 12 in stroke, 1000 lb, 180 000 psi, at mid-stroke, without dead volumes.

    Ours: the largest eigenvalue of the machine's Jacobian, by differences.
    """
    little = 1e-9
    plant = Cylinder.from_diameters(
        4.0 * INCH,
        2.5 * INCH,
        12.0 * INCH,
        ConstantOil(180e3 * PSI),
        Mass(1000.0 * POUND),
        line_volume_a=little,
        line_volume_b=little,
    )
    at = np.array([0.0, plant.start_position, plant.area_b / plant.area_a * 1e6, 1e6])
    shut = PortFlows(0.0, 0.0, 0.0, 0.0)
    nudges = np.diag([1e-4, 1e-6, 1e3, 1e3])
    columns = [
        (cylinder_rates(plant, shut, at + one) - cylinder_rates(plant, shut, at - one)) / (2.0 * one.sum())
        for one in nudges
    ]
    ours = np.abs(np.linalg.eigvals(np.column_stack(columns))).max() / (2.0 * math.pi)
    return [Compared("natural frequency", "Hz", 77.033, float(ours), 1e-4)]


def air_in_oil() -> list[Compared]:
    """2 % of free air, compressed slowly, in a liquid of 300 000 psi: what is left of the bulk modulus.

    The chart also knows of air that dissolves and is stiffer at low pressure.
    """
    oil = AeratedOil(300e3 * PSI, 0.02, 1.0)
    return [
        Compared(
            f"share left at {pressure:,.0f} psi",
            "",
            printed,
            oil.bulk_modulus(pressure * PSI) / ((300e3 + pressure) * PSI),
            within,
        )
        for pressure, printed, within in ((500.0, 0.8, 0.08), (2000.0, 0.98, 0.005))
    ]


def driven_arm() -> list[tuple[str, str, float]]:
    """A beam of 120 kg and 1 m on a hinge, turned by a cylinder under proportional control, after 0.4 s.

    Theirs starts with 2 rad/s and its centre at rest, which the hinge does not allow: of 10 kg m^2 about the
    centre and 40 about the hinge, its impulse leaves 0.5 rad/s.
    """
    side, area, start = 0.25, 0.01, 0.1
    drawn_in = math.sqrt(2.0) * side
    arm = OneLinkArm(
        base_distance=side,
        pin_distance=side,
        closed_length=drawn_in - start,
        level_angle=0.5 * math.pi,
        arm_inertia=10.0 + 120.0 * 0.5**2,
        arm_mass=120.0,
        centre_distance=0.5 * 9.81 / GRAVITY,
        payload=0.0,
        reach=0.0,
        moving_mass=1e-9,
    )
    plant = example(
        Cylinder,
        area_a=area,
        area_b=area,
        stroke=0.3,
        dead_volume_a=VAST,
        dead_volume_b=VAST,
        internal_leakage=0.0,
        oil=ConstantOil(1e11 * VAST),
        friction=Viscous(2e5),
        stops=NoStops(),
        mechanism=arm,
    )
    edges = FourEdges(1.0, 2e-5, 2.0, clearance=0.0, transition_drop=0.0)  # 2e-5 m^3/s per root of a Pa
    line = Pressures(200e5, 0.0)

    def rates(t: float, y: Vector) -> Vector:
        wanted = 0.1 * (min(max(1.0 - math.cos(math.pi * t), 0.5), 1.5) - 0.5)
        opening = 2.0 * (wanted - (float(y[1]) - start))
        return cylinder_rates(plant, port_flows(plant, edges, opening, line, y), y)

    y = np.array([0.5 * side * side / drawn_in, start, 20e5, 20e5])
    for span in ((0.0, 1.0 / 3.0), (1.0 / 3.0, 0.4)):  # where the demand has its bend
        y = solve_ivp(rates, span, y, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    length = arm.length(float(y[1]))
    cosine = arm.cosine(length)
    turning = float(y[0]) / arm.lever(length, arm.sine(cosine))
    upward = side * arm.sine(cosine) * turning
    return [
        ("pressure in chamber A", "Pa", float(y[2])),
        ("pressure in chamber B", "Pa", float(y[3])),
        ("upward velocity of the rod's pin", "m/s", upward),
    ]


def arm_as_printed() -> list[Compared]:
    """Steps of 1 us."""
    theirs = (6441296.09086297, 3008420.04232005, 0.20338669)
    return [
        Compared(what, unit, value, ours, 3e-5)
        for value, (what, unit, ours) in zip(theirs, driven_arm(), strict=True)
    ]


def arm_converged() -> list[Compared]:
    """The same model file run with steps h of 10 and 5 us, twice the second result less the first."""
    coarse = (6442009.83373252, 3008832.43473214, 0.20339942)
    fine = (6441652.74801485, 3008603.51683977, 0.20339054)
    return [
        Compared(what, unit, 2.0 * better - value, ours, 2e-7)
        for value, better, (what, unit, ours) in zip(coarse, fine, driven_arm(), strict=True)
    ]


def spool_edges() -> list[Compared]:
    """A spool with 0.1 mm underlap moved slowly from -1 mm to 1 mm; 200 bar, 100 bar at both ports, 1 bar.

    Slopes are taken from two of their samples each, at 0.51 and 0.54 s and at 0.6 and 0.7 s, of a ramp of
    2 mm/s: the spool's lag and their delays drop out.
    """
    edges = FourEdges(0.67, math.pi * 0.01, 890.0, lap=-1e-4, clearance=0.0, transition_drop=0.0)

    def at(opening: float) -> PortFlows:
        return edges.port_flows(opening, Pressures(2e7, 1e5), 1e7, 1e7)

    def gain(low: float, high: float) -> float:
        return (at(high).a - at(low).a) / (high - low)

    inside = (0.0004674 - 8.97094e-5) / (0.002 * 0.03)
    outside = (0.00155873 - 0.000927667) / (0.002 * 0.1)
    return [
        Compared("flow from the supply at null", "m^3/s", 0.000631066, at(0.0).supply, 2e-6),
        Compared("flow to the tank at null", "m^3/s", 0.000627903, at(0.0).tank, 2e-6),
        Compared("flow gain of port A inside the underlap", "m^2/s", inside, gain(2e-5, 8e-5), 1e-5),
        Compared("flow gain of port A outside", "m^2/s", outside, gain(2e-4, 4e-4), 2e-5),
    ]


def valve_and_cylinder() -> list[Compared]:
    """A cylinder of 1.5 and 1 cm^2 that carries 50 g, driven from end to end by a sine of 0.5 mm and 1 Hz.

    Theirs passes signals on a step of 1 ms late, twice: its spool and its piston. At 0.2 s the speed is near
    its crest, which the delay changes least; half a period later the way back has the same delay, so their
    ratio has none. Ours is sent out and back from rest each time the spool crosses its middle.
    """
    edges = FourEdges(0.67, math.pi * 0.01, 890.0, lap=-1e-6, clearance=0.0, transition_drop=0.0)
    valve = SecondOrderValve(1.0, 300.0, 0.01, edges, damping_ratio=1.0, slew_limit=100.0)
    plant = example(
        Cylinder,
        area_a=1.5e-4,
        area_b=1e-4,
        dead_volume_a=1e-4 * VAST,
        dead_volume_b=1e-4 * VAST,
        internal_leakage=0.0,
        oil=ConstantOil(1e9 * VAST),
        friction=Viscous(0.0),
        stops=NoStops(),
        mechanism=Mass(0.05),
    )
    line = Pressures(100e5, 1e5)

    def rates(t: float, y: Vector) -> Vector:
        spool = SecondOrderValveState(*map(float, y[4:]))
        flows = port_flows(plant, edges, spool.opening, line, y)
        moved = valve.deriv(spool, 5e-4 * math.sin(2.0 * math.pi * t))
        return np.concatenate([cylinder_rates(plant, flows, y), moved])

    def speed(begin: float, end: float, *start: float) -> float:
        done = solve_ivp(rates, (begin, end), start, "Radau", rtol=1e-6, atol=1e-9)
        return float(done.y[0, -1])

    lag = math.atan(2.0 * math.pi / 300.0) / math.pi
    spool_speed = -5e-4 * 2.0 * math.pi / (1.0 + (2.0 * math.pi / 300.0) ** 2)
    out = speed(0.0, 0.2, 0.0, 0.0, 1e5, 1e5, 0.0, 0.0)
    back = speed(0.5 + lag, 0.7, 0.0, 1.0, 50e5, 75e5, 0.0, spool_speed)
    theirs_back = -6.96739 + 0.25 * (6.96739 - 7.03445)  # between their samples at 0.699 and 0.703 s
    return [
        Compared("speed out at 0.2 s", "m/s", 8.59685, out, 0.01),
        Compared("speed back at 0.7 s", "m/s", theirs_back, back, 0.01),
        Compared("speed out over speed back", "", 8.59685 / theirs_back, out / back, 2e-3),
    ]


def accumulator() -> list[Compared]:
    """A litre of oil of 1 GPa and a litre of gas at 100 bar take in 95.49 cm^3 from 1 bar on; n = 1.2.

    Their pressures are absolute.
    """
    gas = GasAccumulator(precharge=1e7 - ATMOSPHERE, gas_volume=1e-3, exponent=1.2)
    supply = example(PumpSupply, volume=1e-3, bulk_modulus=1e9, free_air=1e-12, accumulator=gas)
    done = solve_ivp(
        lambda _, p: 1.0 / np.array([supply.line_compliance(float(p[0]))]),
        (0.0, 9.54925e-5),
        [1e5 - ATMOSPHERE],
        "LSODA",
        rtol=1e-9,
        atol=1e-3,
        max_step=1e-7,
    )
    absolute = float(done.y[0, -1]) + ATMOSPHERE
    oil = 9.54925e-5 - 1e-3 * (absolute - 1e5) / 1e9
    return [
        Compared("pressure of the gas", "Pa", 1.11171e7, absolute, 5e-5),
        Compared("volume of the gas", "m^3", 0.000915534, 1e-3 - oil, 5e-5),
    ]


HOPSAN = "Hopsan of Linköping University, github.com/Hopsan/hopsan, Models/Component Test Validations"
HOPSAN_EXAMPLES = (
    "Hopsan of Linköping University, github.com/Hopsan/hopsan, Models/Example Models Validations"
)


def position_servo() -> list[Compared]:
    """The peaks after the two steps of its demand, as examples/hopsan_position_servo.toml gives them."""
    example = Path(__file__).parents[1] / "examples/hopsan_position_servo.toml"
    run = simulate(load_scenario(example), record=["plant.position"])
    times, position = np.asarray(run["time"]), np.asarray(run["plant.position"])
    return [
        Compared(f"{which} peak of the position", "m", theirs, float(position[part].max()), 4e-3)
        for which, theirs, part in (
            ("first", 0.292157, times < 1.0),
            ("second", 0.811454, times > 1.0),
        )
    ]


CASES = (
    Case(
        "Natural frequency of a cylinder",
        "Delta Computer Systems, Computing the Natural Frequency of the Cylinder and Load, "
        "forum.deltamotion.com/t/1042",
        "five digits are printed",
        natural_frequency,
    ),
    Case(
        "Bulk modulus with air",
        "The Lee Company, Engineering data, Bulk Modulus (Actual), two worked examples in MIL-H-83282",
        "read off a chart, which also knows of air that dissolves",
        air_in_oil,
    ),
    Case(
        "An arm driven by a cylinder",
        "Exudyn, github.com/jgerstmayr/EXUDYN, main/pythonDev/TestModels/hydraulicActuatorSimpleTest.py: the "
        "numbers in its closing comment",
        "the file gives 1e-5 for its steps of 1 µs; a run with ten times longer ones says 2e-5",
        arm_as_printed,
    ),
    Case(
        "The same arm, converged",
        "that file run by Exudyn 1.13.6 from PyPI with initialVelocities=[0,0,2] and Newton's tolerances "
        "at 1e-11 and 1e-13, steps of 10 and 5 µs extrapolated to 0",
        "eight digits are printed, and the error left is of second order in the step",
        arm_converged,
    ),
    Case(
        "Four edges with underlap",
        f"{HOPSAN}/Hydraulic43ValveTest.hvd",
        "six digits are printed",
        spool_edges,
    ),
    Case(
        "A valve and a single-rod cylinder",
        f"{HOPSAN}/HydraulicCylinderQTest2.hvd",
        "1 % is the file's own tolerance",
        valve_and_cylinder,
    ),
    Case(
        "Oil and gas under pressure",
        f"{HOPSAN}/HydraulicAckumulatorTest.hvd",
        "their account of the oil closes to 1e-4 of what came in",
        accumulator,
    ),
    Case(
        "A position servo whose chambers tear",
        f"{HOPSAN_EXAMPLES}/Position Servo.hvd",
        "the same exchange of waves in steps of 1 µs, in place of 0.1 ms, comes to 0.2913 and 0.8104 m",
        position_servo,
    ),
)
