"""The figures derived from the paper's machine, met by simulation.

The true plant has all six uncertain parameters at nominal + Delta, the valve has no lag, the sample period is
10 us; figures are over the second half of 8 s.

Source of the parameters: doi:10.1007/s42401-021-00087-w, Sec. 4.
"""

import pytest
import xarray as xr

from hydroservo.control.controllers import PI, TSMC, Backstepping
from hydroservo.control.loop import Loop
from hydroservo.control.observers import Explicit, Implicit, TSMObserver
from hydroservo.control.references import Square
from hydroservo.control.wiring import believed
from hydroservo.core.block import replace
from hydroservo.machine.loads import Constant
from hydroservo.machine.plants import DesignModel
from hydroservo.papers.tsmc_eha_2021.lemmas import lemma_2
from hydroservo.papers.tsmc_eha_2021.machine import MODEL
from hydroservo.runs.run import simulate
from hydroservo.testing.examples import example

WIDE = example(TSMObserver, switching_gain_2=1e5)  # the printed D_2 = 100 N/s is short
NOMINAL = example(DesignModel)  # what the laws believe: the machine before its uncertainty

MACHINE = replace(
    example(Loop),
    {
        "plant.damping": 1.2 * 50.0,
        "plant.bulk_modulus": 1.1 * 7.0e8,
        "plant.leakage": 1.3 * 2.5e-11,
        "valve.orifice.discharge_coefficient": 1.1 * 0.62,
        "valve.orifice.area_gradient": 1.1 * 0.024,
        "valve.orifice.density": 1.15 * 850.0,
        "supply.return_pressure": 0.0,
    },
)


def run(loop: Loop) -> xr.Dataset:
    return simulate(loop, record=["plant.velocity"])


@pytest.fixture(scope="module")
def pi() -> xr.Dataset:
    return run(MACHINE._replace(controller=example(PI)))


@pytest.fixture(scope="module")
def tsmc() -> xr.Dataset:
    return run(MACHINE._replace(controller=example(TSMC, model=NOMINAL)))


@pytest.fixture(scope="module")
def implicit() -> xr.Dataset:
    return run(
        MACHINE._replace(
            controller=example(TSMC, model=NOMINAL, observer=WIDE._replace(realisation=Implicit()))
        )
    )


@pytest.fixture(scope="module")
def explicit() -> xr.Dataset:
    return run(
        MACHINE._replace(
            controller=example(TSMC, model=NOMINAL, observer=WIDE._replace(realisation=Explicit()))
        )
    )


@pytest.fixture(scope="module")
def square_tsmc() -> xr.Dataset:
    return run(
        MACHINE._replace(
            controller=example(TSMC, model=NOMINAL), reference=example(Square), load=example(Constant)
        )
    )


def test_controllers_know_the_nominal_machine() -> None:
    assert believed(example(Loop)) == NOMINAL == MODEL != believed(MACHINE)


def test_pi_on_the_sine(pi: xr.Dataset) -> None:
    assert float(pi["steady_rms_error"]) == pytest.approx(0.266e-3, rel=0.01)


def test_backstepping_on_the_sine() -> None:
    data = run(MACHINE._replace(controller=example(Backstepping, model=NOMINAL)))
    assert float(data["steady_rms_error"]) == pytest.approx(18.1e-3, rel=0.01)


def test_tsmc_with_boundary_layers_on_the_sine(tsmc: xr.Dataset) -> None:
    assert float(tsmc["steady_rms_error"]) == pytest.approx(0.240e-3, rel=0.01)


def test_implicit_estimates_follow_the_disturbances(implicit: xr.Dataset) -> None:
    assert float(implicit["disturbance_rms_1"]) == pytest.approx(11.8, rel=0.01)
    assert float(implicit["disturbance_rms_2"]) == pytest.approx(1e4, rel=0.05)
    assert float(implicit["estimate_rms_error_1"]) < 4e-4
    assert float(implicit["estimate_rms_error_2"]) == pytest.approx(2.0, rel=0.25)


def test_implicit_realisation_does_not_chatter(
    pi: xr.Dataset, implicit: xr.Dataset, explicit: xr.Dataset
) -> None:
    smooth = float(pi["control_total_variation"])
    assert 0.5 * smooth < float(implicit["control_total_variation"]) < 2.0 * smooth
    assert float(explicit["control_total_variation"]) > 1e4
    assert float(explicit["estimate_rms_error_1"]) == pytest.approx(30.0, rel=0.1)  # +-D_1 for ever


def test_first_gain_meets_lemma_2(tsmc: xr.Dataset, square_tsmc: xr.Dataset) -> None:
    for data in (tsmc, square_tsmc):
        first, _ = lemma_2(data, example(TSMObserver))
        assert first.holds
        assert first.largest == pytest.approx(16.7, rel=0.01)
        assert first.margin == pytest.approx(30.0 / 16.7, rel=0.01)


def test_second_gain_is_short_by_two_to_three_orders(tsmc: xr.Dataset, square_tsmc: xr.Dataset) -> None:
    for data, largest, short_by in ((tsmc, 1e4, (100.0, 200.0)), (square_tsmc, 1e5, (1000.0, 2000.0))):
        _, second = lemma_2(data, example(TSMObserver))
        assert not second.holds
        assert largest < second.largest < 2.0 * largest
        assert short_by[0] < 1.0 / second.margin < short_by[1]


def test_wide_second_gain_meets_lemma_2_on_the_sine(implicit: xr.Dataset) -> None:
    assert all(condition.holds for condition in lemma_2(implicit, WIDE))


def test_square_demand_leaves_the_stroke(tsmc: xr.Dataset, square_tsmc: xr.Dataset) -> None:
    assert bool(square_tsmc["stroke_left"])
    assert not bool(tsmc["stroke_left"])
