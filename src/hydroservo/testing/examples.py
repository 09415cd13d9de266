"""An example of each block without defaults of its own: the machine and the laws of the first paper.

Tests, benchmarks and the contract ask for them where any machine will do.
"""

import math
from typing import Any, TypeVar, cast

from hydroservo.control import controllers, error_dynamics, observers
from hydroservo.control.holds import DelayedHold
from hydroservo.control.loop import Loop, Simulation
from hydroservo.control.monitors import ContactForce
from hydroservo.control.references import Chirp, Multisine, PointToPoint, Ramp, Step, ThereAndBack
from hydroservo.core.block import Block
from hydroservo.core.curve import Curve
from hydroservo.machine import drives, mechanics, sensors
from hydroservo.machine.loads import Constant as ConstantLoad
from hydroservo.machine.loads import Square as SquareLoad
from hydroservo.machine.loads import Step as StepLoad
from hydroservo.machine.oils import CavitatingOil, ConstantOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.plants.design_model import THIS_MACHINE
from hydroservo.machine.supplies import GasAccumulator, PumpSupply, ReliefValve, SlowPoppet
from hydroservo.machine.valves import CurvedEdges, FirstOrderValve, FourCurves, FourEdges, SecondOrderValve
from hydroservo.papers.tsmc_eha_2021 import machine

Example = TypeVar("Example", bound=Block)

PLANT, VALVE, SUPPLY, LAW = machine.PLANT, machine.VALVE, machine.SUPPLY, machine.PROPORTIONAL_INTEGRAL
LIMIT, AMPLITUDE, FORCE = machine.COMMAND_LIMIT, machine.AMPLITUDE, machine.LOAD
RELIEF = ReliefValve(cracking_pressure=SUPPLY.supply_pressure, gradient=2.5e-10)
NOTCHES = Curve.from_samples([0.0, 0.2, 0.5, 1.0], [0.0, 0.04, 0.2, 1.0])
EDGES = FourEdges(**machine.ORIFICE._asdict())
CYLINDER = Cylinder(
    area_a=PLANT.piston_area,
    area_b=PLANT.piston_area,
    stroke=PLANT.stroke,
    dead_volume_a=2.4551e-5,  # [m^3] so that V_t is the plant's
    dead_volume_b=2.4551e-5,
    start_position=PLANT.start_position,
    oil=ConstantOil(PLANT.bulk_modulus),
    mechanism=mechanics.Mass(PLANT.mass),
    internal_leakage=PLANT.leakage,
    friction=mechanics.Viscous(PLANT.damping),
)
PUMP = PumpSupply(
    displacement=3.2e-7,
    demanded_speed=157.0,
    max_torque=5.0,
    inertia=0.002,
    volume=2e-4,
    bulk_modulus=PLANT.bulk_modulus,
    relief=RELIEF,
    speed_gain=1.0,
    viscous=1e-3,
    leakage=7e-13,
    return_pressure=2e5,
)
OIL = ConstantOil(PLANT.bulk_modulus)
CHECK_VALVE = drives.CheckValve(cracking_pressure=5e4, conductance=1e-9)
KALMAN = observers.KalmanObserver(100.0, 1e6, velocity_noise=5e-4, hydraulic_force_noise=5.0)
TRANSDUCER = sensors.PressureTransducer(0.0, 60e5)
PRESSING = controllers.FixedDemand(controllers.PID(0.05, 0.1, anti_windup=1.0), 50.0)
ARM = mechanics.OneLinkArm(
    base_distance=0.3,
    pin_distance=0.08,
    closed_length=0.2715,
    level_angle=0.5 * math.pi,
    arm_inertia=0.25,
    arm_mass=2.0,
    centre_distance=0.3,
    moving_mass=1.0,
    payload=3.0,
    reach=0.6,
)
BLOCKS: tuple[Block, ...] = (
    machine.MODEL,
    machine.OBSERVER._replace(realisation=observers.BoundaryLayer()),
    machine.ORIFICE,
    machine.REFERENCES["sine"],
    machine.REFERENCES["square"],
    PLANT,
    VALVE,
    SUPPLY,
    LAW,
    RELIEF,
    EDGES,
    CYLINDER,
    PUMP,
    TRANSDUCER,
    ARM,
    controllers.AccelerationFeedback(LAW, acceleration_gain=2e-3),
    controllers.AdaptiveRobust(
        300.0,
        300.0,
        adaptation_gain=100.0,
        robust_gain=0.01,
        damping_spread=0.4,
        stiffness_spread=0.2,
        leakage_spread=0.6,
        input_spread=0.5,
        largest_load=30.0,
        largest_flow=1e5,
        dead_zone=1e-4,
    ),
    error_dynamics.AdaptiveSuperTwisting(200.0, least_rate=100.0, largest_rate=1e6, growth=1e5),
    observers.AdaptiveTSMObserver(
        machine.OBSERVER._replace(realisation=observers.Implicit()),
        largest_gain_1=300.0,
        largest_gain_2=1e6,
        gain_rate_1=3e3,
        gain_rate_2=1e7,
    ),
    controllers.AntiWindup(
        LAW._replace(saturation=controllers.Saturation(1000.0)), gain=100.0, saturation=LIMIT
    ),
    controllers.Cascade(LAW, proportional_gain=10.0, max_velocity=0.1, rate_feedforward=1.0),
    CavitatingOil(PLANT.bulk_modulus),
    ContactForce(50.0),
    mechanics.Contact(mechanics.Mass(PLANT.mass), position=0.05, stiffness=1e6, dissipation=1.0),
    Chirp(AMPLITUDE),
    CurvedEdges(VALVE.max_opening, NOTCHES),
    ConstantLoad(FORCE),
    ConstantOil(PLANT.bulk_modulus),
    controllers.DAC(LAW),
    controllers.CharacteristicCompensation(
        LAW, Curve.from_samples([-10.0, -0.1, 0.1, 10.0], [-9.0, -0.6, 0.5, 8.0])
    ),
    controllers.DeadBandCompensation(LAW, extend_overlap=0.5, retract_overlap=0.4, threshold=0.05),
    controllers.DeadBandJump(LAW, extend_overlap=0.5, retract_overlap=0.4, threshold=0.05),
    controllers.Delay(LAW),
    DelayedHold(5e-4),
    controllers.DirectionalGain(LAW, extend_gain=1.0, retract_gain=1.4),
    controllers.Dither(LAW, amplitude=0.1, frequency=100.0),
    CHECK_VALVE,
    drives.Counterbalance(
        pilot_ratio=3.0,
        cracking_pressure=60e5,
        opening_range=10e5,
        rated_flow=1e-4,
        rated_drop=10e5,
        check_valve=CHECK_VALVE,
        volume=1e-5,
        oil=OIL,
    ),
    drives.Hoses(2e-5, 2e-5, 1e10, 1e10, OIL),
    drives.Lines(2e-5, 1e7, 1e10, OIL),
    drives.LoadSensing(margin=10e5, time_constant=0.02),
    drives.PressureCompensator(spring_pressure=7e5),
    drives.PortValves(RELIEF, CHECK_VALVE),
    drives.PumpDrive(
        displacement=3.2e-7,
        command_gain=30.0,
        max_speed=300.0,
        speed_gain=1.0,
        max_torque=5.0,
        inertia=0.002,
        check_valve=CHECK_VALVE,
        relief=RELIEF,
        viscous=1e-3,
        leakage=7e-13,
        case_leakage=2e-13,
    ),
    mechanics.ElastoPlastic(mechanics.LuGre(1e6, 80.0, 40.0, 60.0, 5e-3, PLANT.damping)),
    sensors.Encoder(1e-6),
    sensors.ExactDifferentiator(1.0),
    sensors.FilteredDifference(2e-3),
    PRESSING,
    controllers.ForceLimit(LAW, PRESSING),
    FourCurves(VALVE.max_opening, NOTCHES, NOTCHES, NOTCHES, NOTCHES),
    controllers.FirstOrderADRC(103.0, bandwidth=50.0, observer_bandwidth=200.0),
    controllers.SecondOrderADRC(1.34e6, bandwidth=100.0, observer_bandwidth=500.0),
    observers.ExtendedStateObserver(300.0, 600.0),
    observers.HighGainObserver(200.0, 100.0),
    controllers.HInfinityLoopShaping(3.0, 600.0, machine.VALVE_LAG),
    error_dynamics.HomogeneousErrorDynamics(3e3, 200.0, exponent=0.8),
    controllers.Impedance(LAW, force=50.0, mass=1.0, damping=1e3),
    controllers.InternalModel(
        1e-3, 0.25, 30.0, resonant_rate=30.0, time_constant=machine.VALVE_LAG, anti_windup=0.2
    ),
    controllers.Inverting(error_dynamics.LinearErrorDynamics(300.0, 300.0), KALMAN),
    controllers.LQI(1e-3, 30.0, machine.VALVE_LAG, anti_windup=0.2),
    error_dynamics.LinearErrorDynamics(300.0, 300.0),
    error_dynamics.NaiveSuperTwisting(surface_gain=200.0, disturbance_rate=1e4),
    error_dynamics.NonsingularTerminalErrorDynamics(
        2e3, 200.0, 100.0, surface_exponent=9 / 7, exponent=5 / 9
    ),
    error_dynamics.RISEErrorDynamics(200.0, feedback_gain=200.0, integral_rate=50.0, sign_gain=1e3),
    error_dynamics.SuperTwisting(surface_gain=200.0, disturbance_rate=1e4),
    error_dynamics.TerminalErrorDynamics(*machine.TERMINAL[:6]),
    KALMAN,
    sensors.NoisySensors(5e-4, 5.0),
    controllers.PID(3.0, 100.0, 1e-3, 0.9, 1e-3, 1e-6),
    controllers.PressureFeedback(LAW, force_gain=1e-4, time_constant=0.02),
    observers.PositionKalmanObserver(100.0, 1e6, position_noise=3e-7, hydraulic_force_noise=5.0),
    sensors.RigSensors(sensors.Encoder(1e-6), pressure_a=TRANSDUCER, pressure_b=TRANSDUCER),
    controllers.FlowCompensation(
        LAW,
        SUPPLY.supply_pressure,
        PLANT.piston_area,
        PLANT.piston_area,
        rated_drop=20e5,
        least_drop=2e5,
        time_constant=0.02,
    ),
    controllers.InvertedPolarity(LAW),
    FirstOrderValve(VALVE.gain, machine.VALVE_LAG, VALVE.max_opening, machine.ORIFICE),
    sensors.LoadCell(0.5),
    mechanics.LuGre(1e6, 80.0, 40.0, 60.0, 5e-3, PLANT.damping),
    mechanics.Mass(PLANT.mass),
    mechanics.MassSpringDamper(PLANT.mass, stiffness=1e4, rest_position=0.039),
    Multisine(AMPLITUDE),
    controllers.OffsetFreeLQ(1e-3, machine.VALVE_LAG, KALMAN),
    controllers.LinearMPC(1e-3, machine.VALVE_LAG, KALMAN, 1, 1e6),
    controllers.RadialBasis(0.04, 20.0),
    PointToPoint(0.0, AMPLITUDE, max_rate=0.1, max_second_rate=1.0, max_third_rate=20.0, time=1e-3),
    Ramp(0.0, AMPLITUDE, rate=0.1, time=1e-3),
    controllers.RateLimit(LAW, rate=1000.0),
    controllers.ReferenceFilter(LAW, bandwidth=200.0),
    SlowPoppet(5e-3),
    SecondOrderValve(VALVE.gain, 300.0, VALVE.max_opening, machine.ORIFICE, slew_limit=0.5),
    machine.LOADS["sine"],
    SquareLoad(FORCE, machine.PERIOD),
    GasAccumulator(precharge=30e5, gas_volume=5e-4),
    Step(0.0, AMPLITUDE, time=1e-3),
    StepLoad(0.0, FORCE),
    ThereAndBack(Ramp(0.0, AMPLITUDE, rate=0.1, time=1e-3), turn=3e-3),
    mechanics.Stribeck(40.0, 60.0, 5e-3, PLANT.damping),
    mechanics.SwingingLoad(2.0, centre_distance=0.4, moment_of_inertia=0.02, damping=0.05),
    controllers.ValveInversion(LAW, machine.VALVE_LAG),
    observers.ValveLag(KALMAN, machine.VALVE_LAG),
    controllers.VelocityCompensation(LAW, velocity_gain=0.5),
    mechanics.Viscous(PLANT.damping),
    machine.BACKSTEPPING._replace(model=THIS_MACHINE),
    machine.TERMINAL._replace(model=THIS_MACHINE, observer=machine.OBSERVER),
    Loop(
        Simulation(),
        plant=PLANT,
        valve=VALVE,
        supply=SUPPLY,
        load=machine.LOADS["sine"],
        reference=machine.REFERENCES["sine"],
        controller=LAW,
    ),
)
EXAMPLES: dict[type, Block] = {type(block): block for block in BLOCKS}


def example(cls: type[Example], *args: Any, **changes: Any) -> Example:
    """A block of a class: the example of it with other values, or what its defaults make of them.

    Args:
        cls: a class of blocks, or a loop's.
        args: values of its first fields.
        changes: values of others, by their names.
    """
    if cls not in EXAMPLES:
        return cast("Example", cls(*args, **changes))
    given = dict(zip(cls._fields, args, strict=False))
    if twice := given.keys() & changes:
        raise TypeError(f"{cls.__name__} got {', '.join(sorted(twice))} twice")
    return cast("Example", EXAMPLES[cls]._replace(**given, **changes))
