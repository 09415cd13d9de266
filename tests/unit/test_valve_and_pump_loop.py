"""Second-order spool, four edges and pump in one loop."""

import numpy as np
import pytest
import xarray as xr

from hydroservo import Loop, Simulation, simulate
from hydroservo.control.references import Step
from hydroservo.machine.supplies import PumpSupply
from hydroservo.machine.valves import FourEdges, SecondOrderValve
from hydroservo.testing.examples import example

LOOP = example(
    Loop,
    simulation=Simulation(duration=0.02, period=1e-4, substeps=4, record_period=1e-4),
    valve=example(SecondOrderValve, orifice=example(FourEdges)),
    supply=example(PumpSupply),
    reference=example(Step, time=0.0),
)


@pytest.fixture(scope="module")
def strict() -> xr.Dataset:
    return simulate(LOOP, strict=True)


def test_compiled_equals_interpreted(strict: xr.Dataset) -> None:
    assert strict.identical(simulate(LOOP, compiled=False))


def test_the_supply_gives_way_while_the_valve_is_open(strict: xr.Dataset) -> None:
    pressure = strict["supply.pressure"]
    assert pressure[0] == example(PumpSupply).init().pressure
    assert pressure.min() < example(PumpSupply).relief.cracking_pressure
    assert np.abs(strict["valve.speed"]).max() <= example(SecondOrderValve).slew_limit
