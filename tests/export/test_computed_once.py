"""Powers and their like whose arguments are known when a law is exported: numbers with names in C."""

import re
from pathlib import Path

import numpy as np
import pytest

from hydroservo import Loop, ops
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part, Precision
from hydroservo.scenario import load_scenario
from tests.support.export.small_laws import NAMED, assert_same, law
from tests.support.needs import needs

OF_PARAMETERS = """\
root = ops.power(self.gain, 0.5) + ops.sin(self.gain)
return LawState(root * y.velocity, 0.0)"""
OF_LITERALS = "return LawState(ops.power(SLOPE, 0.5) * y.velocity, 0.0)"
CHANGING = """\
u = 1.0
for i in range(3):
    u = u + ops.power(u, 0.5) * self.gain
return LawState(u * y.velocity, s.beside + ops.power(s.beside, self.gain))"""


def text_of(loop: Loop, *, inlined: bool, precision: Precision = Precision.DOUBLE) -> str:
    return exported_unit(loop, Part.CONTROLLER, **NAMED, inlined=inlined, precision=precision).source


def test_what_is_made_of_parameters_in_the_source_is_a_number_there(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, OF_PARAMETERS)
    text = text_of(loop, inlined=True)
    assert (
        f"/* ops.power(self.gain, 0.5) */\n#define LAW_OWN_LAW_STEP_POWER {ops.power(3.0, 0.5)!r}\n" in text
    )
    assert f"/* ops.sin(self.gain) */\n#define LAW_OWN_LAW_STEP_SIN {ops.sin(3.0)!r}\n" in text
    assert not re.search(r"ops_power|ops_sin", text)
    assert_same(loop, tmp_path, inlined=True)


def test_parameters_that_can_change_are_read_at_every_sample(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, OF_PARAMETERS)
    assert "ops_power(self->gain, 0.5)" in text_of(loop, inlined=False)
    assert_same(loop, tmp_path)


@pytest.mark.parametrize("inlined", [False, True])
def test_what_is_made_of_literals_and_constants_is_a_number_always(tmp_path: Path, inlined: bool) -> None:
    needs("gcc")
    loop = law(tmp_path, OF_LITERALS)
    text = text_of(loop, inlined=inlined)
    assert f"/* ops.power(SLOPE, 0.5) */\n#define LAW_OWN_LAW_STEP_POWER {ops.power(2.5, 0.5)!r}\n" in text
    assert_same(loop, tmp_path, inlined=inlined)


def test_what_changes_is_no_constant(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, CHANGING)
    text = text_of(loop, inlined=True)
    assert text.count(" = u + (ops_power(u, 0.5)") == 1
    assert "#define LAW_OWN_LAW_STEP" not in text
    assert_same(loop, tmp_path, inlined=True)


def test_a_method_that_is_called_with_two_numbers_gives_both(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, "return LawState(self.rooted(2.0) * y.velocity, self.rooted(3.0))")
    text = text_of(loop, inlined=True)
    assert f"{ops.power(2.0, 0.5)!r}" in text
    assert f"{ops.power(3.0, 0.5)!r}" in text
    assert_same(loop, tmp_path, inlined=True)


def test_in_single_precision_it_is_the_nearest_number(tmp_path: Path) -> None:
    text = text_of(law(tmp_path, OF_PARAMETERS), inlined=True, precision=Precision.SINGLE)
    nearest = str(np.float32(ops.power(3.0, 0.5)))
    assert f"#define LAW_OWN_LAW_STEP_POWER {nearest}f\n" in text


def test_a_number_that_single_precision_does_not_hold_is_computed(tmp_path: Path) -> None:
    needs("gcc")
    loop = law(tmp_path, "return LawState(ops.power(self.gain, -2.0) * y.velocity, 0.0)", gain=1e-40)
    assert "#define LAW_OWN_LAW_STEP" not in text_of(loop, inlined=True)
    assert_same(loop, tmp_path, inlined=True)


def test_a_valve_inversion_computes_no_power_of_its_parameters() -> None:
    unit = exported_unit(load_scenario("rig/1khz-tsmc-sine"), Part.CONTROLLER, **NAMED, inlined=True)
    assert "power(" not in unit.source.partition("law_valve_inversion_step(")[2].partition("\n}")[0]
    assert "/* self.kept(dt) */" in unit.source
    assert "/* lag.kept(self.reach * dt) */" in unit.source
    assert "controller.reach" in [one.path for one in unit.parameters]  # though no number of the C is it


def test_the_same_export_gives_the_same_names() -> None:
    loop = load_scenario("axis/position-lq")
    assert len({text_of(loop, inlined=True) for _ in range(5)}) == 1


@pytest.mark.parametrize("sign", ["&", "|"])
def test_truth_values_that_bits_join_are_no_obstacle(tmp_path: Path, sign: str) -> None:
    needs("gcc")
    body = f"""\
both = (self.gain > 0.0) {sign} (y.velocity > 0.0)
return LawState(ops.where(both, ops.power(self.gain, 0.5), y.velocity), 0.0)"""
    for inlined in (False, True):
        assert_same(law(tmp_path, body), tmp_path, inlined=inlined)
