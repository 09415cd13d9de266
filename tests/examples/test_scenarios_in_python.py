"""Each built-in scenario as a Python file that builds its loop from objects: the same loop, the same bits."""

import runpy
from pathlib import Path
from typing import Any

import pytest

from hydroservo import Loop, load_scenario, replace, simulate
from hydroservo.control.monitors.group import Usual
from hydroservo.control.wiring import believed
from hydroservo.core.block import is_block, leaves, model_in
from hydroservo.core.group import group
from hydroservo.engine.flat import block_shape
from hydroservo.machine.plants import DesignModel
from hydroservo.runs.provenance import scenario_hash
from hydroservo.runs.run import runnable_loop
from hydroservo.testing.case import bits
from tests.support.equality import assert_same_block
from tests.support.scenarios import LOOPS
from tests.support.tiers import mostly

NOMINAL = {"uncertainty.scale": 0}


def python_file(loop: Loop) -> str:
    """A Python file that builds a loop, without what follows from its machine or is a default."""
    modules: set[str] = set()
    text = expression(open_again(loop), modules)
    imports = "\n".join(f"import {module}" for module in sorted(modules))
    return f'"""A loop."""\n\n{imports}\n\nloop = {text}\n'


def open_again(block: Any, model: DesignModel | None = None) -> Any:
    """A loop whose law leaves its model open where that is what the machine is taken for."""
    if isinstance(block, Loop) and model_in(block.controller) is not None:
        model = believed(block)
    kept = {}
    for name, value in block._asdict().items():
        follows = isinstance(value, DesignModel) and bits(value) == bits(model)
        if is_block(value) and not follows:
            kept[name] = open_again(value, model)
        elif follows:
            kept[name] = type(block)._field_defaults[name]
    return block._replace(**kept)


def expression(block: Any, modules: set[str]) -> str:
    """The text that makes a block, with the arguments that are not its class's defaults."""
    cls = type(block)
    modules.add(cls.__module__)
    if cls.__module__ == group.__module__:  # a group, which stands in no module
        members = (f"{name!r}: {expression(value, modules)}" for name, value in block._asdict().items())
        return f"{group.__module__}.group({{{', '.join(members)}}})"
    arguments = [
        f"{name}={expression(value, modules) if is_block(value) else repr(value)}"
        for name, value in block._asdict().items()
        if bits(value) != bits(cls._field_defaults.get(name, ...))
    ]
    return f"{cls.__module__}.{cls.__name__}({', '.join(arguments)})"


@pytest.mark.filterwarnings("ignore:nothing is asked for")  # in so short a run
@pytest.mark.parametrize("scale", [{}, NOMINAL], ids=["as it is", "nominal"])
@pytest.mark.parametrize("name", mostly(pytest.mark.slow, LOOPS, ["axis/position", "paper/sine-tsmc"]))
def test_a_loop_made_of_objects_is_the_scenario_s(
    name: str, scale: dict[str, object], tmp_path: Path
) -> None:
    wanted = load_scenario(name, scale)
    file = tmp_path / "loop.py"
    file.write_text(python_file(wanted), encoding="utf-8")
    made = runpy.run_path(str(file))["loop"]
    assert block_shape(runnable_loop(made)) == block_shape(runnable_loop(wanted))
    assert bits(runnable_loop(made)) == bits(runnable_loop(wanted))
    assert scenario_hash(runnable_loop(made)) == scenario_hash(runnable_loop(wanted))
    period = wanted.simulation.period
    short = {"simulation.duration": 20 * period, "simulation.record_period": period}
    results = [simulate(replace(loop, short), compiled=False) for loop in (made, wanted)]
    assert results[0].identical(results[1])


def test_a_nominal_law_leaves_its_model_open() -> None:
    loop = open_again(load_scenario("paper/sine-tsmc", NOMINAL))
    assert not [path for path, _ in leaves(loop) if path.startswith("controller.model.")]
    assert_same_block(loop.metrics, Usual())
