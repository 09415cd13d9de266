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


@pytest.mark.parametrize("name", ["hydroservo", *MODULES])
def test_exports_are_what_a_module_defines(name: str) -> None:
    module = importlib.import_module(name)
    exported = list(getattr(module, "__all__", []))
    names = bound_names(str(module.__file__))
    assert len(exported) == len(set(exported))
    assert set(exported) <= names.keys()
    if not {bound for bound, source in names.items() if not source} - {"__all__"}:
        assert set(exported) == names.keys() - {"__all__"}  # it only gathers what its modules offer


def test_import_is_light() -> None:
    code = "import sys, hydroservo; print(*{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not HEAVY & set(done.stdout.split())


def test_one_version() -> None:
    assert hydroservo.__version__ == version("hydroservo")
    citation = Path(__file__).parents[2] / "CITATION.cff"
    assert f"\nversion: {hydroservo.__version__}\n" in citation.read_text(encoding="utf-8")
