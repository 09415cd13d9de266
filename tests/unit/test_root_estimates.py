"""Square roots of vectors from estimates."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import hydroservo as hs
from hydroservo.core.ops import sqrt
from hydroservo.engine import flat, machine_code, native
from hydroservo.engine.llvm.entries import DOUBLES, kernel_text
from hydroservo.engine.machine_code import with_estimated_roots
from hydroservo.engine.native import Native
from hydroservo.engine.recipe import features

LARGEST, SMALLEST = np.finfo(float).max, np.finfo(float).tiny
OWN = [0.0, -0.0, math.inf]
EDGES = [SMALLEST, LARGEST, 1.0, 4.0, 2.0**-1022, 2.0**1023, 1.0 + 2.0**-52, 1.0 - 2.0**-53]
SUBNORMAL = [5e-324, 1e-310, 2e-308]
TO = 4096

wide = pytest.mark.skipif("+avx512dq" not in features(), reason="the processor has no such vectors")


def roots(x: NDArray[np.float64], monkeypatch: pytest.MonkeyPatch) -> NDArray[np.float64]:
    """Roots of 4096 numbers in a loop that is vectorised."""

    def root_of_each(memory):  # type: ignore[no-untyped-def]
        for lane in range(4096):
            memory[lane] = sqrt(memory[lane])
        return 0

    root_of_each.__module__ = flat.__name__  # whose functions may use memory
    found = np.resize(x, TO)
    monkeypatch.setattr(machine_code, "has_slow_roots", lambda: True)
    kernel = Native(machine_code.object_code("root", kernel_text("root", root_of_each, (DOUBLES,)), False))
    kernel(found)
    return found[: x.size]


@wide
def test_a_root_is_within_one_unit_in_the_last_place(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = np.random.default_rng(0)
    for exponent in (-1000.0, -100.0, -3.0, 0.0, 5.0, 100.0, 1000.0):
        x = drawn.uniform(1.0, 4.0, TO) * 2.0**exponent
        exact = np.sqrt(x)
        found = roots(x, monkeypatch)
        assert (np.abs(found - exact) <= np.spacing(exact)).all()
        assert (found != exact).any()  # they are estimates, and no roots of the processor
    x = np.array(EDGES)
    assert (np.abs(roots(x, monkeypatch) - np.sqrt(x)) <= np.spacing(np.sqrt(x))).all()
    x = np.array(SUBNORMAL)
    np.testing.assert_allclose(roots(x, monkeypatch), np.sqrt(x), rtol=1e-14)


@wide
def test_numbers_without_an_estimate_have_their_roots(monkeypatch: pytest.MonkeyPatch) -> None:
    found = roots(np.array([*OWN, -1.0, -math.inf, math.nan]), monkeypatch)
    assert [math.copysign(1.0, one) for one in found[:2]] == [1.0, -1.0]
    assert found[:3].tolist() == OWN
    assert np.isnan(found[3:]).all()


@wide
def test_metrics_are_those_of_the_processors_own_roots(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = hs.load_scenario("axis/position")
    loop = loop._replace(simulation=loop.simulation._replace(duration=0.3))
    monkeypatch.setattr(native, "kernel_on_disk", lambda _, make: make())
    tables = []
    for slow in (False, True):
        monkeypatch.setattr(native, "READY", {})
        monkeypatch.setattr(machine_code, "has_slow_roots", lambda slow=slow: slow)
        tables.append(hs.simulate_batch(loop, {"plant.mechanism.mass": np.linspace(200.0, 300.0, 40)}))
    own, estimated = tables
    assert not own["rms_error"].identical(estimated["rms_error"])
    for name in ("rms_error", "max_error", "control_rms", "pressure_max"):
        np.testing.assert_allclose(estimated[name], own[name], rtol=1e-9)


def test_only_roots_of_eight_doubles_are_exchanged() -> None:
    text = """
declare <8 x double> @llvm.sqrt.v8f64(<8 x double>)
declare <4 x double> @llvm.sqrt.v4f64(<4 x double>)
define <8 x double> @root(<8 x double> %x, <4 x double> %y) {
  %1 = tail call <8 x double> @llvm.sqrt.v8f64(<8 x double> %x)
  %2 = tail call <4 x double> @llvm.sqrt.v4f64(<4 x double> %y)
  ret <8 x double> %1
}
"""
    found = with_estimated_roots(text)
    assert found.count("call <8 x double> @llvm.sqrt") == 0
    assert "@llvm.sqrt.v4f64(<4 x double> %y)" in found
    machine_code.parse_module(found).verify()
