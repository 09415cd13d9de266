"""What the package shows: names that exist, a quick import, one version."""

import ast
import importlib
import pkgutil
import re
import subprocess
import sys
from importlib.metadata import version
from inspect import ismodule
from pathlib import Path
from pkgutil import resolve_name

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
    """The names that a module binds at its top level, each with the module it is imported from, if any."""
    names: dict[str, str] = {}
    for node in ast.parse(Path(module_file).read_text(encoding="utf-8")).body:
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


def test_exports_are_what_a_package_defines() -> None:
    """Modules need not say what they offer: the API page does, and their packages."""
    for name in MODULES:
        module = importlib.import_module(name)
        exported = list(getattr(module, "__all__", []))
        names = bound_names(str(module.__file__))
        assert hasattr(module, "__path__") or not exported, name
        assert len(exported) == len(set(exported)), name
        assert set(exported) <= names.keys(), name
        if exported and not {bound for bound, source in names.items() if not source} - {"__all__"}:
            assert set(exported) == names.keys() - {"__all__"}, name  # it only gathers what its modules offer


def test_what_the_api_page_names_says_what_it_is() -> None:
    page = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\.\. auto(?:function|class):: (\S+)", page, re.MULTILINE))
    for module, members in re.findall(r"^\.\. automodule:: (\S+)\n   :members:(.*)$", page, re.MULTILINE):
        listed = members.replace(" ", "").split(",") if members.strip() else None
        named |= {f"{module}.{name}" for name in listed or importlib.import_module(module).__all__}
    assert len(named) > 100
    assert not [name for name in named if not (resolve_name(name).__doc__ or "").strip()]


def test_exported_members() -> None:
    """Everything that is offered is there and says what it is, and nothing else is public."""
    offered = {name: getattr(hydroservo, name) for name in hydroservo.__all__}
    silent = [name for name, one in offered.items() if callable(one) or ismodule(one) if not one.__doc__]
    assert not silent
    public = {
        name for name, one in vars(hydroservo).items() if not name.startswith("_") and not ismodule(one)
    }
    assert public <= set(offered)
    assert dir(hydroservo) == sorted(offered)
    assert sorted(offered, key=str.lower) == sorted(hydroservo.__all__, key=str.lower)


@pytest.mark.parametrize("package", ["controllers", "observers", "plants", "valves", "sensors", "ops"])
def test_packages_of_blocks_are_there(package: str) -> None:
    code = f"import hydroservo as hs; print(hs.{package}.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith(f".{package}\n")


def test_all_packages_of_blocks_are_offered() -> None:
    floors = [ROOT / "src/hydroservo" / floor for floor in ("machine", "control")]
    packages = {path.parent.name for floor in floors for path in floor.glob("*/__init__.py")}
    assert packages - {"synthesis", "theory"} <= set(hydroservo.__all__)


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
    code = f"import hydroservo.cli.commands; from hydroservo import {names}"
    code += f"; print(*(one.__name__ for one in [{names}] if isinstance(one, type(hydroservo))))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    above = {"hydroservo", "hydroservo.core", "hydroservo.machine", "hydroservo.control"}
    packages = {f"{home}.{name}" for name, home in hydroservo._HOMES.items() if home in above}
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
