"""What the package shows: names that exist, a quick import, one version."""

import ast
import importlib
import pkgutil
import subprocess
import sys
import tomllib
from importlib.metadata import version
from inspect import ismodule
from pathlib import Path

import pytest

import hydroservo

ROOT = Path(__file__).parents[2]
HEAVY = {"jinja2", "matplotlib", "numba", "pandas", "pint", "pydantic", "rich", "scipy", "typer", "xarray"}
MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(hydroservo.__path__, "hydroservo.")
    if not any(part.startswith("_") for part in module.name.split("."))
)


def bound_names(module_file: str) -> dict[str, str]:
    """The names that a module binds at its top level, each with the module it is imported from, if any.

    Those that it binds for type checkers alone count too; to others it gives them when asked.
    """
    names: dict[str, str] = {}
    nodes = ast.parse(Path(module_file).read_text(encoding="utf-8")).body
    nodes += [inner for node in nodes if isinstance(node, ast.If) for inner in node.body]
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                names[name] = ""
            case ast.Assign(targets=targets):
                names |= {target.id: "" for target in targets if isinstance(target, ast.Name)}
            case ast.AnnAssign(target=ast.Name(id=name)):
                names[name] = ""
            case ast.ImportFrom(module=str(module), names=aliases):
                names |= {alias.asname or alias.name: module for alias in aliases}
    return names


@pytest.mark.parametrize("name", ["hydroservo", *MODULES])
def test_exports_are_what_a_module_defines(name: str) -> None:
    module = importlib.import_module(name)
    exported = list(getattr(module, "__all__", []))
    names = bound_names(str(module.__file__))
    assert len(exported) == len(set(exported))
    assert set(exported) <= names.keys()
    if name == "hydroservo":
        assert set(exported) == names.keys() - {
            "_HOMES",
            "__all__",
            "__getattr__",
            "__dir__",
            "_show_in_notebooks",
            "TYPE_CHECKING",
        }
    elif not {bound for bound, source in names.items() if not source} - {"__all__"}:
        assert set(exported) == names.keys() - {"__all__"}  # it only gathers what its modules offer


def test_exported_members() -> None:
    """Everything that is offered is there and says what it is, and nothing else is public."""
    offered = {name: getattr(hydroservo, name) for name in hydroservo.__all__}
    silent = [name for name, one in offered.items() if callable(one) or ismodule(one) if not one.__doc__]
    assert not silent
    public = {
        name for name, one in vars(hydroservo).items() if not name.startswith("_") and not ismodule(one)
    }
    assert public - {"TYPE_CHECKING"} <= set(offered)
    assert dir(hydroservo) == sorted(offered)
    assert sorted(offered, key=str.lower) == sorted(hydroservo.__all__, key=str.lower)


def test_types_are_those_of_what_is_offered() -> None:
    """What type checkers read is what Python imports."""
    names = bound_names(str(hydroservo.__file__))
    read = {name: home.removeprefix("hydroservo").lstrip(".") for name, home in names.items() if home}
    assert read == hydroservo._HOMES


@pytest.mark.parametrize("package", ["controllers", "observers", "plants", "valves", "sensors", "ops"])
def test_packages_of_blocks_are_there(package: str) -> None:
    code = f"import hydroservo as hs; print(hs.{package}.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"hydroservo.{package}\n"


def test_all_packages_of_blocks_are_offered() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contract = next(one for one in settings["tool"]["importlinter"]["contracts"] if "device" in one["name"])
    devices = {name.removeprefix("hydroservo.") for name in contract["forbidden_modules"]} - {"loop"}
    assert devices <= set(hydroservo.__all__)


def libraries_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_import_is_light() -> None:
    names = ", ".join(hydroservo.__all__)
    assert not HEAVY & libraries_after(f"from hydroservo import {names}")


@pytest.mark.parametrize("module", ["hydroservo", "hydroservo.cli"])
def test_what_a_command_imports_before_it_hears_interrupts_is_lighter_still(module: str) -> None:
    loaded = libraries_after(f"import {module}") - libraries_after("pass")
    assert not (HEAVY | {"numpy", "typing"}) & loaded


def test_each_name_is_there_whatever_was_imported_before() -> None:
    names = ", ".join(hydroservo.__all__)
    code = f"import hydroservo.cli.app; from hydroservo import {names}"
    code += f"; print(*(one.__name__ for one in [{names}] if isinstance(one, type(hydroservo))))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    packages = {f"hydroservo.{name}" for name, home in hydroservo._HOMES.items() if not home}
    assert set(done.stdout.split()) == packages


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        _ = hydroservo.nonsense
    with pytest.raises(ImportError, match="cannot import name 'nonsense'"):
        exec("from hydroservo import nonsense")


def test_one_version() -> None:
    assert hydroservo.__version__ == version("hydroservo")
    citation = ROOT / "CITATION.cff"
    assert f"\nversion: {hydroservo.__version__}\n" in citation.read_text(encoding="utf-8")
