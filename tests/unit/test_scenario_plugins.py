"""A user's own blocks."""

import copy
import pickle
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from hydroservo import ParameterError, ScenarioError, replace, simulate
from hydroservo.control.wiring import believed
from hydroservo.core.block import Block
from hydroservo.runs.provenance import block_tables
from hydroservo.scenario import load_plugin, load_scenario, registry
from hydroservo.scenario.registry import plugin_classes
from tests.support.bases import on_base
from tests.support.equality import assert_same_block

pytestmark = pytest.mark.usefixtures("forgotten")

BLOCK = """
from typing import Annotated, NamedTuple
from hydroservo.core.block import Field
from hydroservo.control.controllers import Saturation
from hydroservo.machine.plants.design_model import THIS_MACHINE, DesignModel

class {name}State(NamedTuple):
    u: Annotated[float, Field("V", "command")]

class {name}(NamedTuple):
    gain: Annotated[float, Field("V s/m", "gain", above=0)] = 10
    needed: Annotated[float, Field("m", "no default")] = {default}
    model: DesignModel = THIS_MACHINE

    def init(self) -> {name}State:
        return {name}State(0.0)

    def step(self, state, measured, demand, period):
        return {name}State(self.gain * (demand.value - measured.velocity))
"""

unpickled = pickle.loads


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / f"{name.lower()}.py"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_plugin_s_controller_is_loaded_and_runs(tmp_path: Path) -> None:
    plugin = written(tmp_path, "Mine", BLOCK.format(name="Mine", default="0.0"))
    scenario = tmp_path / "my.toml"
    scenario.write_text(
        on_base(
            'plant.mass = 7\ncontroller = {type = "Mine", gain = "20 V s/m"}\nsimulation.duration = "10 ms"'
        )
    )
    with pytest.raises(ScenarioError, match=r"'Mine' is not a type here; .*Backstepping, .*PI"):
        load_scenario(scenario)  # no code is run by a scenario
    loop = load_scenario(scenario, plugins=[plugin])
    assert type(loop.controller).__name__ == "Mine"
    assert loop.controller.gain == 20.0
    assert_same_block(loop.controller.model, believed(loop))
    assert loop.controller.model.plant.mass == 7.0
    assert not simulate(loop, compiled=False)["diverged"]
    default = load_scenario(scenario, {"controller.type": "PI", "controller.proportional_gain": 1})
    assert type(load_scenario(scenario, {"controller.gain": 5}).controller) is type(loop.controller)
    assert type(default.controller).__name__ == "PI"


def test_a_whole_default_becomes_a_float(tmp_path: Path) -> None:
    plugin = written(tmp_path, "Whole", BLOCK.format(name="Whole", default="0.0"))
    loop = load_scenario("paper/sine-pi", {"controller.type": "Whole"}, [plugin])
    assert repr(loop.controller.gain) == "10.0"


def test_a_plugin_is_executed_once_until_it_changes(tmp_path: Path) -> None:
    plugin = written(tmp_path, "Once", BLOCK.format(name="Once", default="0.0"))
    (first,) = (cls for cls in load_plugin(plugin) if cls.__name__ == "Once")
    assert first in load_plugin(plugin)
    plugin.write_text(BLOCK.format(name="Once", default="1.0"), encoding="utf-8")
    assert first not in load_plugin(plugin)
    assert first not in plugin_classes()


def test_a_missing_default_must_be_given(tmp_path: Path) -> None:
    text = BLOCK.format(name="Needy", default="X").replace(" = X", "").replace(" = 10", "")
    plugin = written(tmp_path, "Needy", text)
    changes = {"controller.type": "Needy", "controller.gain": 1}
    with pytest.raises(
        ScenarioError, match=r"controller: needed is missing; it must be a finite number \[m\]"
    ):
        load_scenario("paper/sine-pi", changes, [plugin])
    assert load_scenario("paper/sine-pi", {**changes, "controller.needed": "1 mm"}).controller.needed == 1e-3


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (
            '"V s/m"',
            '"V s/mm"',
            "line 11: Odd.gain has the unit V s/mm, which is not SI: declare it in 'V s/m'; scen",
        ),
        (
            "] = 10",
            "] = -10",
            r"line 11: Odd.gain has the default -10: must be a finite number above 0 [V s/m]",
        ),
        (
            "] = 10",
            '] = "10 V s/m"',
            "line 11: Odd.gain has the default '10 V s/m': must be a finite number above",
        ),
        (
            "    model:",
            '    mode: str = "fast"\n    model:',
            "line 13: Odd.mode is text: a block's parameter is a float, an int, a bool or a block",
        ),
        (
            "    model:",
            "    limit: Saturation = Saturation(-1.0)\n    model:",
            "line 13: Odd.limit.limit has the default -1.0: must be a finite number above 0 [V]",
        ),
    ],
)
def test_a_class_that_cannot_stand_is_at_fault_and_not_the_scenario(
    tmp_path: Path, old: str, new: str, problem: str
) -> None:
    text = BLOCK.format(name="Odd", default="0.0")
    assert old in text
    plugin = written(tmp_path, "Odd", text.replace(old, new))
    with pytest.raises(ScenarioError) as caught:
        load_scenario("paper/sine-pi", {"controller.type": "Odd"}, [plugin])
    assert str(caught.value).startswith(f"{plugin}: {problem}")


def test_text_in_a_block_is_refused_from_python_too(tmp_path: Path) -> None:
    text = BLOCK.format(name="Wordy", default="0.0").replace(
        "    model:", '    mode: str = "fast"\n    model:'
    )
    law = load_plugin(written(tmp_path, "Wordy", text))[-1]()
    loop = replace(load_scenario("paper/sine-pi"), {"controller": law})
    with pytest.raises(
        ParameterError, match=r"^controller\.mode = 'fast': is text: a block's parameter is a float"
    ):
        simulate(loop)


def test_a_switch_must_be_true_or_false(tmp_path: Path) -> None:
    text = BLOCK.format(name="Switched", default="0.0\n    on: bool = False")
    plugin = written(tmp_path, "Switched", text)
    changes = {"controller.type": "Switched"}
    with pytest.raises(ScenarioError, match=r"controller\.on: 1 must be true or false"):
        load_scenario("paper/sine-pi", {**changes, "controller.on": 1}, [plugin])
    assert load_scenario("paper/sine-pi", {**changes, "controller.on": True}).controller.on is True


def test_a_name_of_two_classes_is_refused(tmp_path: Path) -> None:
    plugin = written(tmp_path, "two", BLOCK.format(name="Backstepping", default="0.0"))
    with pytest.raises(ScenarioError, match="names two classes"):
        load_scenario("paper/sine-backstepping", plugins=[plugin])


def test_a_class_that_lacks_a_method(tmp_path: Path) -> None:
    text = BLOCK.format(name="Lame", default="0.0").replace("def step(self, state, ", "def step(self, ")
    text += BLOCK.format(name="Halt", default="0.0").replace("def step", "def stop")
    plugin = written(tmp_path, "Lame", text)
    with pytest.raises(
        ScenarioError, match=r"'Lame' cannot be a Controller: its method step must be step\(self, s"
    ):
        load_scenario("paper/sine-pi", {"controller.type": "Lame"}, [plugin])
    with pytest.raises(
        ScenarioError, match=r"'Halt' cannot be a Controller: it has no method step\(self, s, y, r"
    ):
        load_scenario("paper/sine-pi", {"controller.type": "Halt"})


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x = 1\ndef f(:\n", r"line 2: SyntaxError"),
        ("x = 1\n\nimport no_such_module_anywhere\n", r"line 3: ModuleNotFoundError: No module named"),
        ("def f():\n    return 1/0\n\nf()\n", r"line 2: ZeroDivisionError"),
        ("raise SystemExit(3)", r"line 1: SystemExit: 3"),
        ("raise ValueError('two\\nlines')", r"line 1: ValueError: two\\nlines"),
        ("x = 1", "defines no block"),
        ("", "defines no block"),
        ("\0", "ValueError|SyntaxError"),
        ("from typing import NamedTuple\nclass A(NamedTuple):\n    x: 'Nowhere' = 1\n", "NameError"),
        ("(" * 100_000, "Error"),
    ],
)
def test_errors_in_a_plugin(tmp_path: Path, text: str, problem: str) -> None:
    plugin = written(tmp_path, "bad", text)
    with pytest.raises(ScenarioError, match=problem) as caught:
        load_plugin(plugin)
    assert str(caught.value).startswith(str(plugin))
    assert len(str(caught.value).splitlines()) == 1


def test_plugins_that_are_no_python_files(tmp_path: Path) -> None:
    (tmp_path / "blob.py").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "block.txt").write_text("x = 1")
    for name, problem in [
        ("none.py", "cannot be read: no such file"),
        ("", "is a directory"),
        ("blob.py", "is UTF-16"),
        ("block.txt", r"must end in \.py"),
    ]:
        with pytest.raises(ScenarioError, match=problem):
            load_plugin(tmp_path / name)


def test_a_valve_that_a_law_with_a_model_cannot_know_is_refused(tmp_path: Path) -> None:
    plugin = written(
        tmp_path,
        "Bare",
        """
from typing import Annotated, NamedTuple
from hydroservo.core.block import Field
from hydroservo.machine.valves import StaticValveState

class Bare(NamedTuple):
    gain: Annotated[float, Field("m/V", "gain", above=0)] = 5e-4

    def init(self):
        return StaticValveState()

    def deriv(self, s, u):
        return s

    def opening(self, s, u):
        return self.gain * u
""",
    )
    with pytest.raises(ScenarioError) as caught:
        load_scenario("paper/sine-tsmc", {"valve": {"type": "Bare"}}, [plugin])
    message = str(caught.value)
    assert "Bare" in message
    assert "a field gain (a float) and a field orifice, metering edges with simplified()" in message


def forget(block: Block) -> None:
    """This process has not loaded the block's plugin."""
    del sys.modules[type(block).__module__]
    registry.loaded_modules.clear()


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    return written(tmp_path, "Mine", BLOCK.format(name="Mine", default="0.0"))


@pytest.mark.slow
def test_a_loop_with_a_plugin_runs_in_a_pool_of_new_processes(mine: Path) -> None:
    changes = {"controller.type": "Mine", "simulation.duration": 1e-3}
    loop = load_scenario("paper/sine-pi", changes, [mine])
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        there = pool.submit(simulate, loop, compiled=False).result()
    assert there.identical(simulate(loop, compiled=False))


def test_a_pickle_executes_the_plugin_where_it_is_not_loaded(mine: Path) -> None:
    controller = load_scenario("paper/sine-pi", {"controller.type": "Mine"}, [mine]).controller
    kept = [pickle.dumps(one) for one in (controller, controller.init())]
    assert_same_block(unpickled(kept[0]), copy.deepcopy(controller))
    assert_same_block(copy.deepcopy(controller), controller)
    assert type(unpickled(kept[0])) is type(controller)
    forget(controller)
    again, state = map(unpickled, kept)
    assert type(again) is not type(controller)
    assert block_tables(again) == block_tables(controller)
    assert again.init() == state
    assert type(again.init()) is type(state)


def test_a_pickle_whose_plugin_is_gone_or_has_changed_says_so(mine: Path) -> None:
    controller = load_scenario("paper/sine-pi", {"controller.type": "Mine"}, [mine]).controller
    kept = pickle.dumps(controller)
    forget(controller)
    mine.write_text(f"{BLOCK.format(name='Mine', default='0.0')}\nraise RuntimeError('executed')\n")
    with pytest.raises(ScenarioError, match=r"mine\.py: has changed since a Mine of it was pickled$"):
        unpickled(kept)
    mine.unlink()
    with pytest.raises(ScenarioError, match=r"mine\.py.*(no such file|No such file)"):
        unpickled(kept)
