"""C held against plain Python on samples that reach what the closed loop does not."""

import re
from pathlib import Path

import pytest

from hydroservo import LoopError
from hydroservo.export.c.project import proof_of
from hydroservo.export.of_loop import exported_unit
from hydroservo.export.unit import Part
from hydroservo.scenario import load_scenario, scenarios
from tests.support.export.branches import searched
from tests.support.export.small_laws import NAMED, law
from tests.support.tiers import mostly

RARE = """\
u = self.gain * y.velocity
if r.second_rate < -1e6:
    u = -u
if s.beside > 200.0 and y.velocity > 0.0:
    u = 2.0 * u
return LawState(u, s.beside + 1.0 if r.value > 0.0 else 0.0)"""
NEVER = """\
u = y.velocity
if self.gain < 0.0:
    u = 1.0
return LawState(u, 0.0)"""


def test_samples_are_found_that_reach_what_the_closed_loop_does_not(tmp_path: Path) -> None:
    loop = law(tmp_path, RARE)
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    found = searched(loop, Part.CONTROLLER, unit, tmp_path)
    assert len(found.branches) > 8
    assert not found.missed
    assert len(found.vectors.inputs) > 1000  # beside counts beyond 200
    assert proof_of(unit, found.vectors).compiler


def test_what_no_sample_reaches_is_named(tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    (line,) = searched(loop, Part.CONTROLLER, unit, tmp_path).missed
    assert unit.source.splitlines()[line - 1].strip() == "if (self->gain < 0.0) {"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (r"u = -u", "u = -u - 1.0", "controller.u"),
        (r"s->beside \+ 1.0", "s->beside + 2.0", "controller.beside"),
    ],
)
def test_c_that_is_wrong_in_a_rare_branch_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    loop = law(tmp_path, RARE)
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    found = searched(loop, Part.CONTROLLER, unit, tmp_path)
    source, count = re.subn(old, new, unit.source)
    assert count == 1
    with pytest.raises(LoopError, match=rf"^nothing is written: the C differs from Python: .*{said}"):
        proof_of(unit._replace(source=source), found.vectors)


@pytest.mark.parametrize(("part", "missed"), [(Part.MACHINE, 0), (Part.LOOP, 1)])
def test_machines_and_loops_are_searched_too(part: Part, missed: int, tmp_path: Path) -> None:
    loop = law(tmp_path, NEVER)
    found = searched(loop, part, exported_unit(loop, part, **NAMED), tmp_path)
    assert sum(not reached for reached in found.branches.values()) == missed  # though their load never jumps


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    mostly(
        pytest.mark.nightly,
        [name for name in scenarios() if not name.endswith("-square")],
        ["paper/sine-tsmc"],
    ),
)
def test_controllers_are_right_in_the_branches_that_are_found(name: str, tmp_path: Path) -> None:
    loop = load_scenario(name)
    unit = exported_unit(loop, Part.CONTROLLER, **NAMED)
    found = searched(loop, Part.CONTROLLER, unit, tmp_path)
    assert proof_of(unit, found.vectors).compiler
    assert sum(found.branches.values()) >= 0.8 * len(found.branches)  # parameters close some of the others
