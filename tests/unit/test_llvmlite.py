"""What hydroservo takes from llvmlite is public, and a version that breaks it is named."""

import ast
import importlib
from collections.abc import Iterator
from importlib.metadata import requires, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import hydroservo
from hydroservo.engine.machine_code import parse_module
from hydroservo.engine.native import CompileError

SOURCES = sorted(Path(hydroservo.__file__).parent.rglob("*.py"))
(BOUND,) = (one for one in map(Requirement, requires("hydroservo") or ()) if one.name == "llvmlite")


def names() -> Iterator[tuple[str, str, Path]]:
    """Module, name and file of all that hydroservo imports from llvmlite, and takes from there."""
    for path in SOURCES:
        text = path.read_text("utf-8")
        tree = ast.parse(text if "llvmlite" in text else "")
        modules = {}
        for node in ast.walk(tree):
            whole = (name.name for name in node.names) if isinstance(node, ast.Import) else ()
            assert not any(name.startswith("llvmlite") for name in whole), path
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "llvmlite":
                for name in node.names:
                    modules[name.asname or name.name] = f"{node.module}.{name.name}"
                    yield str(node.module), name.name, path
        for node in ast.walk(tree):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id in modules
            ):
                yield modules[node.value.id], node.attr, path


def test_hydroservo_uses_public_names_alone():
    used = {(module, name) for module, name, _ in names()}
    assert len(used) > 2
    private = (one for one in used if any(part.startswith("_") for part in ".".join(one).split(".")))
    assert set(private) <= {("llvmlite", "__version__")}


def test_llvmlite_has_all_that_hydroservo_uses():
    for module, name, path in names():
        where = importlib.import_module(module)
        assert hasattr(where, name), (
            f"llvmlite {version('llvmlite')} has no {module}.{name}, which {path.name} uses"
        )


def test_llvmlite_is_of_the_versions_that_were_tried():
    assert {one.operator for one in BOUND.specifier} == {">=", "<"}
    assert version("llvmlite") in BOUND.specifier, (
        f"llvmlite {version('llvmlite')} is not {BOUND}: where all tests pass with it, raise the bound"
    )


def test_text_that_llvmlite_refuses_is_told_in_one_line():
    with pytest.raises(CompileError) as caught:
        parse_module("define void @f() {\n  unheard_of\n}")
    message = str(caught.value)
    assert message.startswith(f"llvmlite {version('llvmlite')} refuses hydroservo's text (")
    assert "unheard_of" in message
    assert message.endswith(f"hydroservo is tried with {BOUND}")
    assert "\n" not in message
