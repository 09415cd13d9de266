"""What a user should know of a result is said, as an attribute and as a warning."""

import numpy as np
import pytest
import xarray as xr

from hydroservo import HydroservoWarning, Loop, Simulation, simulate, simulate_batch
from hydroservo.controllers import PI
from hydroservo.loads import Constant
from hydroservo.oils import AeratedOil
from hydroservo.plants import Cylinder
from hydroservo.references import Square
from hydroservo.runs.cautions import pressure_caution, quietly, warnings_of, with_warning
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
