"""Laws of a plug-in whose methods give what no law may."""

import linecache
import random
import sys
from pathlib import Path
from typing import Any

from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.scenario import load_scenario, registry

VALUES = (
    "None",
    "'text'",
    "float('nan')",
    "float('inf')",
    "[1.0]",
    "(1.0, 2.0)",
    "1j",
    "10**400",
    "object()",
    "True",
    "State(None)",
    "State('text')",
    "State(10**400)",
    "State(1j)",
    "State([0.0])",
    "State(State(0.0))",
    "State(0.0)",
    "State(1)",
    "State(float('nan'))",
    "State(0.0, 1.0)",
    "State()",
    "1 / 0",
    "self.nope",
    "y",
    "r",
    "self",
    "State",
    "int('x')",
    "{}['x']",
    "lambda: 0.0",
    "State(y.velocity)",
    "State(y.nope)",
    "(_ for _ in ())",
    "__import__('numpy').zeros(3)",
    "State(__import__('numpy').float32(1))",
)
RIGHT = {
    "unit": '"V"',
    "kind": "float",
    "default": "2.0",
    "check": "return None",
    "caution": "''",
    "init": "return State(0.0)",
    "step": "return State(self.gain * (r.value - y.velocity))",
}
LAW = '''from typing import Annotated, NamedTuple

from hydroservo import Field, ParameterError
from hydroservo.core.roles import Controller, role


class State(NamedTuple):
    u: Annotated[float, Field({unit}, "command")]


@role(Controller)
class Law(NamedTuple):
    """u = k e."""

    gain: Annotated[{kind}, Field("V s/m", "gain", above=0)] = {default}

    def check(self):
        {check}

    def caution(self):
        return {caution}

    def init(self):
        {init}

    def step(self, s, y, r, dt):
        {step}
'''
SHORT = {
    "simulation.duration": "3 ms",
    "simulation.period": "1 ms",
    "simulation.substeps": 1,
    "simulation.record_period": "1 ms",
}
CHANGES = {**SHORT, "controller.type": "Law"}


def drawn_plugin(draw: random.Random) -> str:
    """The text of a law of which a method, or more, gives something else."""
    parts = dict(RIGHT)
    for name in draw.sample(list(parts), draw.choice((1, 1, 2))):
        value = draw.choice(VALUES)
        statement = draw.choice(
            (f"return {value}", f"raise ValueError({value!r})", "raise ParameterError('a', 1, 'b')")
        )
        values = {
            "unit": draw.choice(("'mV'", "'nope'", "1", "''")),
            "kind": draw.choice(("int", "bool", "str", "list", "object", "'X'")),
            "default": value.replace("self", "0").replace("y", "0") if "State" not in value else "-1.0",
            "caution": value,
        }
        parts[name] = values.get(name, statement)
    return LAW.format(**parts)


def run_plugin(path: Path) -> None:
    """Run a law of a file for three samples, and forget it."""
    modules = set(sys.modules)
    try:
        loop: Any = load_scenario("paper/sine-pi", CHANGES, plugins=[path])
        quietly(simulate)(loop, record=[], compiled=False)
    finally:
        registry.loaded_modules.clear()
        linecache.cache.pop(str(path.resolve()), None)
        for name in set(sys.modules) - modules:
            if name.startswith(registry.MODULE):
                del sys.modules[name]
