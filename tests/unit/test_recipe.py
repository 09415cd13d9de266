"""What the digest of a kernel sees: everything that the code of a block depends on."""

import importlib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import pytest

from hydroservo import Loop, Simulation, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.control.controllers.pi import PIState
from hydroservo.control.loop import AUTO
from hydroservo.core.signals import Demand, Measurement
from hydroservo.engine import kernel as engine_kernel
from hydroservo.engine import lanes
from hydroservo.engine.recipe import KernelKey, UnknownContentError, content_lines
from hydroservo.runs.batch import simulate_batch
from hydroservo.scenario import load_scenario, scenarios
from hydroservo.testing.examples import example

BLOCK = """
from typing import NamedTuple
{header}

class Own(NamedTuple):
    gain: float = 1.0

    def step(self, s, y, r, dt):
        return {value}
"""
TUPLE = """
from typing import NamedTuple

class C(NamedTuple):
    a: float

    def total(self):
        return 2.0

T = C(1.0)
"""
# What stands above the class, what its method returns, and a file beside it; a 2.0 becomes a 3.0.
DEPENDENCIES = {
    "a number": ("G = 2.0", "G", {}),
    "an imported number": ("from gains import G", "G", {"gains.py": "G = 2.0"}),
    "a module's number": ("import gains", "gains.G", {"gains.py": "G = 2.0"}),
    "a package's number": (
        "import pack.gains",
        "pack.gains.G",
        {"pack/__init__.py": "", "pack/gains.py": "G = 2.0"},
    ),
    "behind a global of the same name": ("import gains\nG = 1.0", "gains.G", {"gains.py": "G = 2.0"}),
    "with the name of a builtin": ("import gains", "gains.max", {"gains.py": "max = 2.0"}),
    "an imported function": ("from gains import f", "f(1.0)", {"gains.py": "def f(x): return 2.0 * x"}),
    "the default of a field": (
        "from gains import C",
        "C().a",
        {"gains.py": "from typing import NamedTuple\nclass C(NamedTuple):\n    a: float = 2.0"},
    ),
    "an array": ("import numpy as np\nG = np.array([1.0, 2.0])", "G[1]", {}),
    "the default of a function": ("from gains import f", "f()", {"gains.py": "def f(x=2.0): return x"}),
    "the method of a global tuple": ("from gains import T", "T.total()", {"gains.py": TUPLE}),
    "a module with a standard name": ("import colorsys", "colorsys.G", {"colorsys.py": "G = 2.0"}),
    "a member of an enumeration": (
        "from gains import M",
        "M.A.value",
        {"gains.py": "from enum import Enum\nclass M(Enum):\n    A = 2.0"},
    ),
}


def content(folder: Path, files: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> list[str] | None:
    """What is told of the classes Own and Part, imported afresh from these files; None if it cannot be."""
    try:
        return imported(folder, files, monkeypatch)
    except UnknownContentError:
        return None


def imported(folder: Path, files: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The same; raises where it cannot be told."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.syspath_prepend(str(folder))
        for name in ("own", "gains", "pack", "pack.gains", "colorsys"):
            patch.delitem(sys.modules, name, raising=False)
        try:
            module = importlib.import_module("own")
            return list(content_lines((module.Own, getattr(module, "Part", None))))
        finally:
            for name in ("own", "gains", "pack", "pack.gains", "colorsys"):
                sys.modules.pop(name, None)


def files_of(name: str) -> dict[str, str]:
    header, value, beside = DEPENDENCIES[name]
    return {"own.py": BLOCK.format(header=header, value=value), **beside}


@pytest.mark.parametrize("name", DEPENDENCIES)
def test_a_change_is_seen(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = files_of(name)
    after = {file: text.replace("2.0", "3.0") for file, text in before.items()}
    assert before != after
    first = content(tmp_path / "before", before, monkeypatch)
    second = content(tmp_path / "after", after, monkeypatch)
    assert first is None or first != second


@pytest.mark.parametrize("name", ["a number", "an imported function", "a package's number"])
def test_an_unchanged_class_tells_the_same(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = content(tmp_path / "a", files_of(name), monkeypatch)
    assert first is not None
    assert content(tmp_path / "b", files_of(name), monkeypatch) == first


def silent(_self: PI, _s: PIState, _y: Measurement, _r: Demand, _dt: float) -> PIState:
    return PIState(0.0, 0.0, 0.0)


@pytest.mark.slow
def test_a_method_exchanged_in_the_process_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    loop, before = example(Loop, Simulation(0.01, 1e-3)), KernelKey("run", (PI,), True).digest()
    own = simulate(loop, strict=True)
    monkeypatch.setattr(PI, "step", silent)
    assert KernelKey("run", (PI,), True).digest() != before
    changed = simulate(loop, strict=True)
    assert changed.identical(simulate(loop, compiled=False))
    assert not changed.identical(own)


LAW = """
import numpy as np
from hydroservo.core.errors import ParameterError
from typing import NamedTuple

def outer(x):
    def inner(y):
        return {nested} * y
    return inner(x)

class Part(NamedTuple):
    def __call__(self, x):
        return {called} * x

    def by_name(self, x):
        return {named} * x

    def apply(self, x):
        return {applied} * outer(x)

class Own(NamedTuple):
    part: Part = Part()

    def step(self, s, y, r, dt):
        return self.part.apply(1.0) + self.part(2.0) + getattr(self.part, "by_name")(3.0)

    def designed(self, model, period):
        if np.linalg.norm([period]) < {designed}:
            raise ParameterError("period", period, "is too short")
        return self

    def check(self):
        self.part.apart()

    def apart(self):
        return {apart}
"""
NUMBERS = dict.fromkeys(("nested", "called", "named", "applied", "designed", "apart"), 2.0)


@pytest.mark.parametrize(
    ("changed", "matters"),
    [
        ("nested", True),
        ("called", True),
        ("named", True),
        ("applied", True),
        ("designed", False),
        ("apart", False),
    ],
)
def test_what_a_kernel_can_call_is_seen_and_the_rest_does_not_matter(
    changed: str, matters: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = [LAW.format(**NUMBERS), LAW.format(**NUMBERS | {changed: 3.0})]
    first, second = (
        content(tmp_path / str(i), {"own.py": text}, monkeypatch) for i, text in enumerate(texts)
    )
    assert first is not None
    assert (first != second) == matters


class One(NamedTuple):
    """Two methods that differ."""

    def step(self) -> float:
        return 1.0

    def init(self) -> float:
        return 2.0


def test_methods_that_change_places_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    class Other(NamedTuple):
        step, init = One.step, One.init

    before = list(content_lines((One, Other)))
    Other.step, Other.init = One.init, One.step  # type: ignore[method-assign]
    assert list(content_lines((One, Other))) != before


@pytest.mark.parametrize(
    ("header", "value", "says"),
    [
        ("import numpy as np", "np.linspace(0.0, 1.0)", "uses np.linspace, an object of type"),
        ("G = [2.0]", "G[0]", "uses G, an object of type list"),
        ("class C:\n    pass", "C", "uses C, the class C, which is not a NamedTuple"),
    ],
)
def test_the_reason_names_function_file_and_global(
    header: str, value: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(UnknownContentError, match=says) as error:
        imported(tmp_path, {"own.py": BLOCK.format(header=header, value=value)}, monkeypatch)
    assert str(error.value).startswith(f"Own.step in {tmp_path / 'own.py'} uses ")


class RecipeSeenError(Exception):
    """Carries a recipe out of what would compile it."""

    def __init__(self, recipe: KernelKey) -> None:
        self.recipe = recipe


def stopped(recipe: KernelKey, *_: object) -> None:
    raise RecipeSeenError(recipe)


EXAMPLES = Path(__file__).parents[2] / "examples"
PLUGINS = {  # of the examples
    "my": ["my_controller.py"],
    "my_drive": ["my_drive.py"],
    "my_metric": ["my_metric.py"],
    "my_plant": ["my_plant.py"],
}
NEEDS_A_FILE = {"spring_fmu"}  # an FMU that spring_fmu.py builds
EXAMPLE_FILES = [path for path in sorted(EXAMPLES.glob("*.toml")) if path.stem not in NEEDS_A_FILE]
SCENARIOS = [*scenarios(), *map(str, EXAMPLE_FILES)]


@pytest.mark.parametrize("name", SCENARIOS)
def test_each_scenario_has_a_digest(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_kernel, "native_kernel", stopped)
    monkeypatch.setattr(lanes, "native_kernel", stopped)
    loop = load_scenario(name, plugins=[EXAMPLES / file for file in PLUGINS.get(Path(name).stem, [])])
    if loop.simulation.substeps == AUTO:
        loop = replace(loop, {"simulation.substeps": 2})
    with pytest.raises(RecipeSeenError) as run:
        simulate(loop)
    with pytest.raises(RecipeSeenError) as batch:
        simulate_batch(loop, {"simulation.seed": [1.0]})
    assert run.value.recipe.text == "run"
    assert batch.value.recipe.text == "lanes"
    assert len(run.value.recipe.digest()) == len(batch.value.recipe.digest()) == 64


PROPORTIONAL = """
from hydroservo.control.controllers.pi import PIState
from typing import NamedTuple

class Law(NamedTuple):
    def init(self):
        return PIState(0.0, 0.0)

    def step(self, s, y, r, dt):
        return PIState({gain} * (r.value - y.velocity), 0.0)
"""


def test_a_class_that_says_it_is_pythons_own_is_told_all_the_same() -> None:
    """As one is that ``exec`` makes without a name of a module."""
    made = []
    for gain in (10.0, 30.0):
        space: dict[str, object] = {}
        exec(PROPORTIONAL.format(gain=gain), space)
        made.append(space["Law"])
    assert [cls.__module__ for cls in made] == ["builtins", "builtins"]  # type: ignore[attr-defined]
    first, second = (list(content_lines((cls, ("step",)))) for cls in made)
    assert first != second
