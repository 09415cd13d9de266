"""Roles are said by blocks, and what a file's class says is held against what it has."""

import pickle
from pathlib import Path
from typing import NamedTuple

import pytest

from hydroservo import ScenarioError
from hydroservo.control.controllers import PI
from hydroservo.core.hooks import HOOKS
from hydroservo.core.roles import Block, Controller, Load, Observer, PositionSensor, Reference, role
from hydroservo.language.source import changed_class
from hydroservo.machine.loads import Sine
from hydroservo.scenario import load_plugin, load_scenario
from hydroservo.scenario.registry import names_in_role
from hydroservo.scenario.role_checks import ROLES, declared_roles, possible_roles, role_problem
from hydroservo.testing.examples import example
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.usefixtures("forgotten")

unpickled = pickle.loads


class Silent(NamedTuple):
    def init(self) -> Block: ...
    def step(self, s: Block, y: Block, r: Block, dt: float) -> Block: ...


@role(Load, Reference)
class Both(NamedTuple):
    def force(self, t: float) -> float: ...
    def next_jump(self, t: float) -> float: ...
    def at(self, t: float) -> Block: ...


def test_each_role_is_played() -> None:
    assert [one for one in ROLES if not names_in_role(one)] == []


def test_a_class_takes_the_role_that_it_says_and_no_other() -> None:
    assert PI.role is Controller
    assert declared_roles(PI) == possible_roles(PI) == (Controller,)
    assert role_problem(PI, Controller) is None
    assert role_problem(PI, Observer) == "it says that its role is Controller"
    assert role_problem(Sine, Reference) == "it says that its role is Load"


def test_a_class_that_says_none_takes_each_role_whose_methods_it_has() -> None:
    assert {Controller, PositionSensor} <= set(possible_roles(Silent))
    assert Load not in possible_roles(Silent)
    assert role_problem(Silent, Load) == "it has no method force(self, t)"


def test_a_class_may_play_two_roles() -> None:
    assert declared_roles(Both) == possible_roles(Both) == (Load, Reference)
    assert role_problem(Both, Reference) is None
    assert role_problem(Both, Controller) == "it says that its role is Load and Reference"


def test_a_role_is_no_field_and_changes_nothing_else() -> None:
    assert "role" not in PI._fields
    assert_same_block(unpickled(pickle.dumps(example(PI))), example(PI))
    assert changed_class(PI) == ""


def test_what_says_its_role_by_hand_must_say_one() -> None:
    class Odd(NamedTuple):
        """A block that sets it itself."""

    Odd.role = "Controller"  # type: ignore[attr-defined]
    with pytest.raises(
        ValueError, match=r"says that its role is 'Controller', which hydroservo.core.roles does not have"
    ):
        declared_roles(Odd)


CLASS = """\
from typing import NamedTuple

from hydroservo.core.roles import Controller, Load, role


@role({role})
class Mine(NamedTuple):
    def init(self):
        return None

    def {step}:
        return s
{more}"""
STEP = "step(self, s, y, r, dt)"


def written(folder: Path, role: str = "Controller", step: str = STEP, more: str = "") -> Path:
    path = folder / "mine.py"
    path.write_text(CLASS.format(role=role, step=step, more=more), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"role": "Load"}, "says that its role is Load: it has no method force(self, t)"),
        (
            {"step": "step(self, s, y, r)"},
            "says that its role is Controller: its method step must be step(self, s, y, r, dt)",
        ),
        (
            {"step": "stop(self, s, y, r, dt)"},
            "says that its role is Controller: it has no method step(self, s, y, r, dt)",
        ),
        (
            {"more": "\n    def designed(self, period):\n        return self\n"},
            "says that its role is Controller: its method designed must be designed(self, model, period)",
        ),
    ],
)
def test_a_class_without_what_its_role_asks_for_is_refused_where_it_is_loaded(
    tmp_path: Path, changes: dict[str, str], problem: str
) -> None:
    path = written(tmp_path, **changes)
    with pytest.raises(ScenarioError) as caught:
        load_plugin(path)
    assert str(caught.value) == f"{path}: line 7: Mine {problem}"


def test_a_class_in_a_place_of_another_role_is_refused_with_both(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario("paper/sine-pi", {"load.type": "Mine"}, [written(tmp_path)])
    assert str(caught.value).endswith("'Mine' cannot be a Load: it says that its role is Controller")


def test_a_role_may_be_a_line_of_the_class(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    text = CLASS.format(role="Controller", step=STEP, more="")
    path.write_text(text.replace("@role(Controller)\n", "").replace("):\n", "):\n    role = Controller\n", 1))
    (mine,) = load_plugin(path)
    assert declared_roles(mine) == (Controller,)


def test_what_a_block_may_have_besides_stands_in_its_role() -> None:
    for hook in HOOKS:
        if hook.role is not None:
            assert f"``{hook.name}" in str(hook.role.__doc__), hook


@pytest.mark.parametrize(
    ("old", "new", "line", "problem"),
    [
        (
            "@role(Controller)",
            "@role",
            6,
            "role is given Mine; it takes roles, in parentheses, such as @role(Con",
        ),
        ("@role(Controller)", "@role()", 6, "role is given nothing; it takes roles, in parentheses, such as"),
        (
            "@role(Controller)",
            "@role('Controller')",
            6,
            "role is given 'Controller'; it takes roles, in paren",
        ),
        (
            "@role(Controller)",
            "@role(NamedTuple)",
            6,
            "role is given NamedTuple; it takes roles, in parenthe",
        ),
        (
            *("@role(Controller)", "@role(Load)\n@role(Controller)"),
            *(6, "Mine declares its role twice; put several in one @role(..., ...)"),
        ),
        ("(NamedTuple):", ":", 6, "Mine is not a NamedTuple; write class Mine(NamedTuple):"),
    ],
)
def test_a_role_that_is_said_wrong_is_one_line(
    tmp_path: Path, old: str, new: str, line: int, problem: str
) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load_plugin(path)
    assert str(caught.value).startswith(f"{path}: line {line}: {problem}")


def test_a_type_that_nothing_has_may_be_a_users_own(tmp_path: Path) -> None:
    changes = {"controller.type": "Mine"}
    with pytest.raises(
        ScenarioError,
        match=r"'Mine' is not a type here; a class of your own needs its file: --plugin FILE, .* PI, ",
    ):
        load_scenario("paper/sine-pi", changes)
    with pytest.raises(ScenarioError, match=r"did you mean PI\?; a class of your own needs its file"):
        load_scenario("paper/sine-pi", {"controller.type": "PII"})
    path = written(tmp_path)
    text = path.read_text(encoding="utf-8").replace("@role(Controller)\nclass Mine(NamedTuple)", "class Mine")
    path.write_text(f"{text}\n\nclass Other(NamedTuple):\n    x: float = 1.0\n", encoding="utf-8")
    with pytest.raises(
        ScenarioError, match=r"; the plugin's class Mine is not a NamedTuple; write class Mine\(Na"
    ):
        load_scenario("paper/sine-pi", changes, [path])
