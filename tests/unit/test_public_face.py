"""What the package shows: names that exist, a quick import, one version."""

import ast
import importlib
import pkgutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import hydroservo

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
    if not {bound for bound, source in names.items() if not source} - {"__all__"}:
        assert set(exported) == names.keys() - {"__all__"}  # it only gathers what its modules offer


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
    code = f"import hydroservo.simulate, hydroservo.cli.app; from hydroservo import {names}; print([{names}])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "<module" not in done.stdout


def test_modules_are_there_when_asked_for() -> None:
    code = "import hydroservo; print(hydroservo.controllers.PI.__name__, hydroservo.simulate.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "PI simulate\n"


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        _ = hydroservo.nonsense
    with pytest.raises(ImportError, match="cannot import name 'nonsense'"):
        exec("from hydroservo import nonsense")


def test_one_version() -> None:
    assert hydroservo.__version__ == version("hydroservo")
    citation = Path(__file__).parents[2] / "CITATION.cff"
    assert f"\nversion: {hydroservo.__version__}\n" in citation.read_text(encoding="utf-8")
