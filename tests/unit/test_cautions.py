"""What a user should know of a result is said, as an attribute and as a warning."""

import numpy as np
import pytest
import xarray as xr

from hydroservo import HydroservoWarning, Loop, Simulation, simulate, simulate_batch
from hydroservo.control.controllers import PI, RateLimit, Saturation
from hydroservo.control.references import PointToPoint, Ramp, Sine, Square, Step
from hydroservo.core.block import Block
from hydroservo.machine.loads import Constant
from hydroservo.machine.oils import AeratedOil
from hydroservo.machine.plants import Cylinder
from hydroservo.machine.supplies import IdealSupply, PumpSupply, ReliefValve
from hydroservo.machine.valves import StaticValve
from hydroservo.runs.cautions import quietly, warnings_of, with_warning
from hydroservo.runs.cautions.loop import late_caution, own_cautions, size_cautions
from hydroservo.runs.cautions.run import pressure_caution
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example

TORN = example(
    Loop,
    Simulation(0.1, 1e-3, 40),
    plant=example(Cylinder, start_pressure_a=20e5, start_pressure_b=20e5),
    load=Constant(-6000.0),
    reference=example(Square, 0.1),
    controller=PI(3.0, 100.0),
)


def test_a_pressure_below_absolute_zero_is_said() -> None:
    with pytest.warns(HydroservoWarning, match=r"fell to -\d+(\.\d+)? bar, below absolute zero"):
        data = simulate(TORN)
    lowest = min(data["plant.pressure_a"].min(), data["plant.pressure_b"].min())
    assert float(data["pressure_min"]) <= lowest < -101325.0
    assert "below absolute zero" in data.attrs["warning"]


def test_a_batch_says_in_how_many_runs() -> None:
    with pytest.warns(HydroservoWarning, match="in 1 of 2 runs, below absolute zero"):
        table = simulate_batch(TORN, {"load.amplitude": np.array([-6000.0, 0.0])})
    assert table["pressure_min"].values[0] < -101325.0 < table["pressure_min"].values[1]


def test_oil_that_tears_open_stays_above_it() -> None:
    data = simulate(TORN._replace(plant=TORN.plant._replace(oil=AeratedOil())))
    assert float(data["pressure_min"]) > -101325.0
    assert "absolute zero" not in data.attrs.get("warning", "")


def test_a_plant_without_chambers_has_no_such_pressure() -> None:
    data = simulate(example(Loop, Simulation(0.01, 1e-3, 4), controller=example(PI)), record=[])
    assert "pressure_min" not in data
    assert pressure_caution(data) == ""


def test_lines_are_added_once_each() -> None:
    data = xr.Dataset(attrs={"warning": "old", "seed": 1})
    assert with_warning(data, ["a", "", "old", "b", "a"]).attrs == {"warning": "old\na\nb", "seed": 1}
    assert with_warning(xr.Dataset(), [""]).attrs == {}
    assert data.attrs["warning"] == "old"


def test_each_line_is_a_warning_of_the_line_that_called() -> None:
    with pytest.warns(HydroservoWarning) as caught:
        simulate(TORN._replace(simulation=Simulation(0.1, 1e-3, 20)))
    assert [str(one.message).split()[1] for one in caught] == ["steps", "pressure"]
    assert {one.filename for one in caught} == {__file__}


def test_a_result_has_its_warnings_even_where_none_is_said() -> None:
    loop = TORN._replace(simulation=Simulation(0.1, 1e-3, 20))
    assert [line.split()[1] for line in warnings_of(quietly(simulate)(loop))] == ["steps", "pressure"]


SHORT = Simulation(0.01, 1e-3, 4)
EARLY = (
    "the valve is wide open at 2.00 V (valve.max_opening/valve.gain), and the command goes to 10.0 V "
    "({}.saturation.limit): what is beyond 2.00 V does nothing"
)


def test_a_valve_that_is_wide_open_early_in_the_command_s_range_is_said() -> None:
    valve = example(StaticValve, gain=5e-4, max_opening=1e-3)
    loop = example(Loop, SHORT, valve=valve, controller=PI(1.0))
    wrapped = loop._replace(controller=RateLimit(PI(1.0), 100.0))
    for one, path in ((loop, "controller"), (wrapped, "controller.controller")):
        assert warnings_of(quietly(simulate)(one, compiled=False)) == [EARLY.format(path)]
    table = quietly(simulate_batch)(loop, {"plant.mass": np.array([5.0, 6.0])})
    assert warnings_of(table) == [EARLY.format("controller")]


def test_a_valve_that_takes_half_of_the_command_s_range_is_none_to_speak_of() -> None:
    valve = example(StaticValve, gain=5e-4, max_opening=1e-3)
    for law in (PI(1.0, saturation=Saturation(4.0)), PI(1.0, saturation=Saturation(2.0))):
        assert not warnings_of(
            quietly(simulate)(example(Loop, SHORT, valve=valve, controller=law), compiled=False)
        )


def test_a_relief_valve_that_passes_too_little_for_its_pump_is_said() -> None:
    """It takes what a motor that no load disturbs delivers, 5 L/min, at 500 bar beyond cracking."""
    pump = example(
        PumpSupply,
        displacement=1e-6,
        demanded_speed=5e-3 / 60.0 / 1e-6,
        speed_gain=1e9,
        viscous=0.0,
        leakage=0.0,
        max_torque=1e3,
        relief=ReliefValve(200e5, 5e-3 / 60.0 / 500e5),
        return_pressure=0.0,
    )
    said = "supply: the pressure rises to 700 bar with the valve shut, far beyond the 200 bar of relief.crac"
    assert own_cautions(example(Loop, SHORT, supply=pump))[0].startswith(said)
    large = pump._replace(relief=ReliefValve(200e5, 5e-3 / 60.0 / 99e5))
    weak = pump._replace(max_torque=20.0)
    for one in (large, weak):
        assert own_cautions(example(Loop, SHORT, supply=one)) == []


def test_what_a_nested_block_says_is_said_by_runs() -> None:
    pump = example(PumpSupply, relief=example(ReliefValve, gradient=1e-12))
    loop = example(Loop, Simulation(0.01, 1e-3), supply=pump)
    (said,) = own_cautions(loop)
    assert said in warnings_of(quietly(simulate)(loop, compiled=False))


@pytest.mark.parametrize(
    "demand", [Step(0.0, 0.1, 3.0), Ramp(0.0, 0.1, 1.0, 3.0), PointToPoint(0.0, 0.1, 1.0, 1.0, 1.0, 3.0)]
)
def test_a_demand_that_begins_after_the_run_is_said(demand: Block) -> None:
    loop = example(Loop, SHORT, reference=demand, controller=PI(1.0))
    said = ["nothing is asked for: reference.time is 3 s, and the run ends at 0.01 s"]
    assert warnings_of(quietly(simulate)(loop, compiled=False)) == said
    held = demand._replace(final=demand.initial)
    for within in (demand._replace(time=0.0), demand._replace(time=9e-3), held, example(Sine)):
        assert late_caution(loop._replace(reference=within)) == ""
    assert late_caution(loop._replace(reference=demand._replace(time=0.01))) != ""


def test_a_bore_in_metres_is_said() -> None:
    wide = load_scenario("axis/position", {"plant.bore": 63, "uncertainty.scale": 0})
    assert [line.split(" is ")[0] for line in size_cautions(wide)] == ["plant.area_a", "plant.area_b"]


def test_a_pressure_in_bar_without_its_unit_is_said_by_runs() -> None:
    loop = example(Loop, Simulation(0.01, 1e-4, 4), supply=IdealSupply(200.0, 0.0))
    said = (
        "supply.supply_pressure is 0.00200 bar, and machines have 0.100 bar to 5000 bar: is its unit right? "
        "A number without one is in SI units"
    )
    assert said in warnings_of(quietly(simulate)(loop, compiled=False))


def test_the_machines_that_ship_have_usual_sizes() -> None:
    for name in (name for name in scenarios() if not name.startswith("laws/")):
        assert size_cautions(load_scenario(name)) == [], name
