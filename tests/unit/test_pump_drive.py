"""The pump between the ports."""

import math

import pytest

from hydroservo import Loop, ParameterError, replace, simulate
from hydroservo.control.controlled import Force
from hydroservo.control.controllers import PI, TSMC
from hydroservo.control.references import Step
from hydroservo.control.wiring import wired
from hydroservo.core.roles import valveless
from hydroservo.core.signals import Feed, Pressures
from hydroservo.machine.drives import Hoses, PumpDrive, PumpDriveState, ValveOnSupply
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import IdealSupply
from hydroservo.machine.valves import NoEdges, NoValve
from hydroservo.runs.cautions.loop import demand_caution
from hydroservo.testing.examples import example
from tests.support.axes import commanded_axis, step, viscous

PUMP = example(PumpDrive)
LINE = Pressures(8e5, 1e5)
LOOP = example(Loop, plant=example(Cylinder), valve=NoValve(), supply=IdealSupply(8e5), drive=PUMP)


def feed(command: float) -> Feed:
    return Feed(command, NoEdges(), 0.0, LINE)


def test_it_delivers_what_it_displaces_less_what_leaks() -> None:
    """Both ports above the replenishing line's pressure: nothing but the pump moves oil."""
    flows = PUMP.flows(PumpDriveState(100.0), feed(0.0), 40e5, 10e5)
    through = PUMP.displacement * 100.0 - PUMP.leakage * 30e5
    assert flows.a == pytest.approx(through - PUMP.case_leakage * 39e5, rel=1e-12)
    assert flows.b == pytest.approx(through + PUMP.case_leakage * 9e5, rel=1e-12)
    assert flows.supply == 0.0
    assert flows.tank == pytest.approx(PUMP.case_leakage * 48e5, rel=1e-12)


def test_its_speed_settles_where_the_motor_holds_the_load() -> None:
    """(K + B) w = K k u - D (p_A - p_B)."""
    rise, u = 30e5, 4.0
    speed = (PUMP.speed_gain * PUMP.command_gain * u - PUMP.displacement * rise) / (
        PUMP.speed_gain + PUMP.viscous
    )
    rate = PUMP.deriv(PumpDriveState(speed), feed(u), 10e5 + rise, 10e5)
    assert rate.speed == pytest.approx(0.0, abs=1e-9)


def test_speed_and_torque_are_limited() -> None:
    assert PUMP.torque(PumpDriveState(299.0), feed(1e3)) == pytest.approx(PUMP.speed_gain)
    assert PUMP.torque(PumpDriveState(-200.0), feed(1e3)) == PUMP.max_torque
    assert PUMP.torque(PumpDriveState(200.0), feed(-1e3)) == -PUMP.max_torque


def test_a_port_that_runs_dry_is_replenished_and_one_under_pressure_is_relieved() -> None:
    still = PumpDriveState(0.0)
    dry = PUMP._replace(leakage=0.0, case_leakage=0.0).flows(still, feed(0.0), 20e5, 1e5)
    assert dry.b == pytest.approx(-PUMP.check_valve.conductance * 7e5)
    assert dry.supply == -dry.b
    over = 8e5 + PUMP.relief.cracking_pressure + 10e5
    relieved = PUMP._replace(leakage=0.0, case_leakage=0.0).flows(still, feed(0.0), over, 20e5)
    assert relieved.a == pytest.approx(-PUMP.relief.flow(over - 8e5))
    assert relieved.supply == relieved.a


def test_its_power_is_that_of_the_shaft_and_of_the_line() -> None:
    state = PumpDriveState(100.0)
    flows = PUMP.flows(state, feed(4.0), 20e5, 5e5)
    torque = PUMP.speed_gain * (PUMP.command_gain * 4.0 - 100.0)
    assert (
        PUMP.power(state, feed(4.0), flows, 0.0, 0.0)
        == 8e5 * flows.supply + min(torque, PUMP.max_torque) * 100.0
    )
    assert PUMP.power(state, feed(0.0), flows._replace(supply=0.0), 0.0, 0.0) == -PUMP.max_torque * 100.0


def test_a_cylinder_described_by_its_load_pressure_gets_the_mean_of_both_flows() -> None:
    flows = PUMP.flows(PumpDriveState(100.0), feed(0.0), 40e5, 10e5)
    assert PUMP.load_flow(PumpDriveState(100.0), feed(0.0), 30e5) == pytest.approx(0.5 * (flows.a + flows.b))


def from_datasheet(**changes: float) -> PumpDrive:
    given = {
        "displacement": 2.5e-6,
        "max_speed": 314.0,
        "max_command": 10.0,
        "rated_speed": 157.0,
        "rated_pressure": 210e5,
        "volumetric_efficiency": 0.94,
        "case_leakage": 1e-13,
    }
    rest = {"speed_gain": 1.0, "max_torque": 60.0, "inertia": 0.004}
    return PumpDrive.from_datasheet(
        **(given | rest | changes), check_valve=PUMP.check_valve, relief=PUMP.relief
    )


def test_a_datasheet_says_what_leaks_and_how_fast_a_command_turns_it() -> None:
    pump = from_datasheet()
    delivered = pump.displacement * 157.0 - (pump.leakage + pump.case_leakage) * 210e5
    assert delivered == pytest.approx(0.94 * 2.5e-6 * 157.0)
    assert pump.command_gain == pytest.approx(31.4)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("volumetric_efficiency", 1.2),
        ("volumetric_efficiency", 0.0),
        ("rated_speed", 0.0),
        ("rated_pressure", 0.0),
        ("max_command", -10.0),
        ("case_leakage", 1e-11),
        ("max_torque", 52.0),
    ],
)
def test_a_datasheet_that_cannot_be_is_refused(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        from_datasheet(**{name: value})


def test_the_motor_must_hold_the_rated_point() -> None:
    """D p_n + B w_n, as of a pump that supplies: 52.5 N m without friction."""
    assert from_datasheet(max_torque=52.6).max_torque == 52.6
    with pytest.raises(ParameterError, match=r"max_torque = 52\.6: must be at least 52\.66 \[N m\]"):
        from_datasheet(max_torque=52.6, viscous=1e-3)


def test_valve_and_drive_must_go_together() -> None:
    wired(LOOP)
    wired(LOOP._replace(drive=example(Hoses, drive=PUMP)))
    with pytest.raises(
        ParameterError, match=r"valve = 'StaticValve': must be NoValve: the drive PumpDrive stands"
    ):
        wired(LOOP._replace(valve=example(Loop).valve))
    for drive in (ValveOnSupply(), example(Hoses)):
        with pytest.raises(ParameterError, match=r"valve = 'NoValve': is none, and the drive \w+ needs one"):
            wired(LOOP._replace(drive=drive))


def test_a_law_that_believes_in_the_machine_is_refused_in_a_line() -> None:
    wired(LOOP._replace(controller=example(PI)))
    with pytest.raises(
        ParameterError, match=r"drive = 'PumpDrive': has no design model: no valve meters the flow"
    ):
        wired(LOOP._replace(controller=example(TSMC)))


def test_what_a_pump_can_hold_does_not_end_at_the_line_that_replenishes_it() -> None:
    """8 bar on a piston of 4.9 cm^2 are 393 N; the valve on them cannot hold the 1 kN that the pump can."""
    asked = LOOP._replace(controls=Force(), reference=example(Step, final=1e3))
    assert demand_caution(asked) == ""
    assert "the demand goes to 1000 N" in demand_caution(asked._replace(drive=ValveOnSupply()))


def test_no_edges_have_no_design_model() -> None:
    assert math.copysign(1.0, NoEdges().flow(1e-3, 40e5, 0.0)) == 1.0
    with pytest.raises(ParameterError, match="have no design model"):
        NoEdges().simplified()


def test_the_decorator_leaves_the_class_as_it_is() -> None:
    assert valveless(PumpDrive) is PumpDrive
    assert replace(LOOP, {"drive.leakage": 0.0}).drive.leakage == 0.0


TWO_PUMPS = {
    "simulation.duration": "1 s",
    "reference": step("0 V", "10 V", "1 ms"),
    "supply.supply_pressure": "8 bar",
    "valve": {"type": "NoValve"},
    "plant": {
        "type": "Cylinder",
        "area_a": "12.566 cm^2",
        "area_b": "8.765 cm^2",
        "stroke": "300 mm",
        "dead_volume_a": "40 cm^3",
        "dead_volume_b": "40 cm^3",
        "start_position": "150 mm",
        "mechanism": {"type": "Mass", "mass": "80 kg"},
        "friction": viscous("2000 N s/m"),
        "oil": {"type": "ConstantOil", "effective_bulk_modulus": "12000 bar"},
    },
    "drive": {
        "type": "PumpDrive",
        "displacement": "4 cm^3/rev",
        "displacement_ratio": 0.69751711,
        "command_gain": "100 rpm/V",
        "max_speed": "1000 rpm",
        "speed_gain": "1e6 N m s/rad",
        "max_torque": "1e6 N m",
        "inertia": "100 kg m^2",
        "case_leakage": "2e-13 m^3/(s Pa)",
        "relief": {"type": "ReliefValve", "cracking_pressure": "250 bar", "gradient": "1 L/(min bar)"},
        "check_valve": {
            "type": "CheckValve",
            "cracking_pressure": "0.3 bar",
            "conductance": "5 L/(min bar)",
            "opening_range": "2 bar",
        },
    },
}


@pytest.mark.parametrize(
    ("command", "load", "velocity", "pressure_a", "pressure_b"),
    [
        (10.0, 3000.0, 52.576e-3, 29.979e5, 7.554e5),
        (10.0, -1500.0, 53.662e-3, 7.520e5, 26.670e5),
        (-10.0, 3000.0, -53.504e-3, 28.293e5, 7.556e5),
        (-10.0, -1500.0, -52.390e-3, 7.514e5, 29.082e5),
    ],
)
def test_two_pumps_leave_no_oil_over(
    command: float, load: float, velocity: float, pressure_a: float, pressure_b: float
) -> None:
    """Held to an integration of the same equations by scipy, with the shaft's speed given."""
    low = 8e5 if load > 0.0 else (12.566e-4 * 8e5 - load) / 8.765e-4
    changes = TWO_PUMPS | {
        "reference.final": command,
        "load": {"type": "Constant", "amplitude": load},
        "plant.start_pressure_a": (load + 8.765e-4 * low) / 12.566e-4,
        "plant.start_pressure_b": low,
    }
    end = simulate(commanded_axis(changes)).isel(time=-1)
    assert float(end["plant.velocity"]) == pytest.approx(velocity, rel=1e-4)
    assert float(end["plant.pressure_a"]) == pytest.approx(pressure_a, rel=1e-3)
    assert float(end["plant.pressure_b"]) == pytest.approx(pressure_b, rel=1e-3)
