"""What the digest of a kernel sees: everything that the code of a block depends on."""

import importlib
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from hydroservo import Loop, Simulation, simulate
from hydroservo.controllers import PI
from hydroservo.controllers.pi import PIState
from hydroservo.engine.recipe import Content, Recipe, UnknownContentError
from hydroservo.signals import Demand, Measurement

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
    """What is told of the class Own, imported afresh from these files; None if it cannot be told."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.syspath_prepend(str(folder))
        for name in ("own", "gains", "pack", "pack.gains", "colorsys"):
            patch.delitem(sys.modules, name, raising=False)
        own = importlib.import_module("own").Own
        try:
            return list(Content().of(own))
        except UnknownContentError:
            return None
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


def test_a_method_exchanged_in_the_process_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    loop, before = Loop(Simulation(0.01, 1e-3)), Recipe("run", (PI,), True).digest()
    own = simulate(loop, strict=True)
    monkeypatch.setattr(PI, "step", silent)
    assert Recipe("run", (PI,), True).digest() != before
    changed = simulate(loop, strict=True)
    assert changed.identical(simulate(loop, compiled=False))
    assert not changed.identical(own)


def test_blocks_of_the_package_are_known() -> None:
    assert Recipe("run", (Loop, PI), True).digest() is not None
