"""The arithmetic that a step takes, counted in the export's terms, and by the C itself while it runs."""

from pathlib import Path

import pytest

from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Operations, Part
from hydroservo.export.vectors import make_vectors
from tests.support.export.counting import COMPILER, operations_done
from tests.support.export.small_laws import NAMED, law
from tests.support.needs import needs
from tests.support.tiers import mostly
from tools.targets.controllers import controllers
from tools.targets.instructions import PAGE, compared, instructions_shown

# Every law: its command is no number, and neither of the two numbers of its state infinite.
GUARD = Operations(comparisons=3)
LONG = """u = 0.0
if r.value > 1e9:
    for _ in range(-(2**62), 2**62):
        u = u + y.velocity
return LawState(u, 0.0)"""
COUNTED = {
    "return LawState(self.gain * (r.value - y.velocity), s.u)": Operations(1, 1),
    "e = r.value\nu = e / 3.0 if e > 0.0 else e + e * e\nreturn LawState(u, 0.0)": Operations(1, 1, 0, 0, 1),
    "u = 0.0\nfor _ in range(7):\n    u = u + y.velocity * u\nreturn LawState(u, 0.0)": Operations(7, 7),
    "u = 0.0\nfor _ in range(9, 2, -3):\n    u = u + y.velocity\nreturn LawState(u, 0.0)": Operations(3),
    "unread = r.value * r.value\nreturn LawState(y.velocity, 0.0)": Operations(),
    "return LawState(-ops.absolute(y.velocity), 0.0)": Operations(),
    "return LawState(ops.power(2.0, 3.0), ops.sqrt(y.velocity))": Operations(roots=1, comparisons=1),
    "return LawState(ops.minimum(y.velocity, 1.0), ops.floor(r.value))": Operations(3, comparisons=3),
}


@pytest.mark.parametrize(("body", "expected"), COUNTED.items())
def test_a_step_takes_what_its_text_says(body: str, expected: Operations, tmp_path: Path) -> None:
    unit = exported_unit(law(tmp_path, body), Part.CONTROLLER, **NAMED)
    assert unit.operations == expected.plus(GUARD)


def test_a_power_is_a_function_with_operations_of_its_own(tmp_path: Path) -> None:
    body = "x = ops.signed_power(y.velocity, 0.6)\nreturn LawState(x, ops.sin(r.value))"
    found = exported_unit(law(tmp_path, body), Part.CONTROLLER, **NAMED).operations
    assert found is not None
    assert found.functions == 2
    assert found.total == sum(found) - 2 > 60


def test_a_loop_that_its_numbers_end_has_no_most(tmp_path: Path) -> None:
    body = "u = y.velocity\nwhile u > 1.0:\n    u = 0.5 * u\nreturn LawState(u, 0.0)"
    assert exported_unit(law(tmp_path, body), Part.CONTROLLER, **NAMED).operations is None


@pytest.mark.slow  # each compiles
@pytest.mark.parametrize(
    "name",
    mostly(
        pytest.mark.nightly,
        ["PI", "TSMC implicit", "industrial axis", "laws/lq-sine", "laws/mpc-sine"],
        ["PI"],
    ),
)
def test_no_step_of_the_c_takes_more_and_some_take_nearly_as_much(name: str, tmp_path: Path) -> None:
    """Where a condition is short or a choice is made, a step takes less than at most."""
    needs(COMPILER)
    loop = controllers()[name]
    unit = exported_unit(loop, Part.CONTROLLER, prefix="unit", title=name)
    done = operations_done(unit, make_vectors(loop, Part.CONTROLLER, unit).inputs, tmp_path)
    assert unit.operations is not None
    most = max(one.total for one in done)
    assert 0.94 * unit.operations.total <= most <= unit.operations.total


@pytest.mark.nightly  # it exports every combination of blocks
def test_operations_rank_controllers_as_instructions_do() -> None:
    found = compared(controllers(), instructions_shown(PAGE.read_text("utf-8")))
    assert len(found.names) == len(controllers())
    assert len(found.ranks) == 6
    assert min(found.ranks) > 0.97
