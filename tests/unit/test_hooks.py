"""The table of what a block may have besides its role's methods is what the code asks blocks for."""

import ast
from collections.abc import Iterator
from pathlib import Path

import hydroservo
from hydroservo.core.hooks import HOOKS

SOURCES = Path(hydroservo.__file__).parent
OF_ROLES = {  # which blocks of a role have; asked for to say who does not
    *("flow", "opening", "orifice", "simplified", "init", "step", "values")
}
OF_NUMBERS = {  # of some machines; maps, circuits, environments and the page use them where a type has them
    *("stroke", "supply_pressure", "leakage", "internal_leakage", "external_leakage", "friction", "coulomb"),
    *("volume_a", "total_volume", "effective_bulk_modulus", "hysteresis", "area_gradient"),
    *("extra_lap_pa", "extra_lap_at", "extra_lap_pb", "extra_lap_bt"),
    *("start_pressure_a", "start_pressure_b", "resolution", "range_high"),
    *("mechanism", "mass", "time_constant", "natural_frequency"),
    *("carried", "start_position", "return_pressure", "cracking_pressure", "regeneration", "speed_gain"),
}
OF_OTHERS = {  # of Python and of libraries
    *(
        "SIGINT",
        "SIGALRM",
        "setitimer",
        "sched_getaffinity",
        "O_NOFOLLOW",
        "O_NONBLOCK",
        "O_CLOEXEC",
        "O_BINARY",
    ),
    *("lineno", "obj", "co_exceptiontable", "py_func", "PTXSource", "possibilities", "kernel", "finding"),
}
COMPUTED = {  # where an attribute that may be missing is looked for under a name that is computed
    "engine/recipe.py",  # what a function's code names
    *("language/builtin.py", "language/expressions.py", "language/source.py"),  # what its text names
    "scenario/role_checks.py",  # the methods of roles, and the hooks
    "runs/fitting.py",  # the field that a wrapper wraps: controller, sensors
    "testing/declarations.py",  # the properties of roles
}


def lookups() -> Iterator[tuple[str, set[str]]]:
    """File and names, of each attribute that is looked for and may be missing; "" for a computed name."""
    for path in sorted(SOURCES.rglob("*.py")):
        file, tree = path.relative_to(SOURCES).as_posix(), ast.parse(path.read_text(encoding="utf-8"))
        listed: dict[str, set[str]] = {}
        for node in ast.walk(tree):
            match node:
                case (
                    ast.comprehension(target=ast.Name(target), iter=ast.Tuple(elts=names))
                    | ast.For(target=ast.Name(target), iter=ast.Tuple(elts=names))
                ):
                    listed.setdefault(target, set()).update(map(constant, names))
        for node in ast.walk(tree):
            match node:
                case ast.Call(func=ast.Name("hasattr"), args=[_, name]):
                    yield file, listed.get(ast.unparse(name), {constant(name)})
                case ast.Call(func=ast.Name("getattr"), args=[_, name, _]):
                    yield file, listed.get(ast.unparse(name), {constant(name)})


def constant(node: ast.expr) -> str:
    return str(node.value) if isinstance(node, ast.Constant) else ""


def test_the_code_asks_for_what_the_table_has_and_for_nothing_else() -> None:
    asked = {name for _, names in lookups() for name in names if name and not name.startswith("_")}
    assert asked - OF_ROLES - OF_NUMBERS - OF_OTHERS == {hook.name for hook in HOOKS}


def test_what_may_be_missing_is_looked_for_by_name() -> None:
    assert {file for file, names in lookups() if "" in names} == COMPUTED


def test_all_that_is_excused_is_asked_for() -> None:
    asked = {name for _, names in lookups() for name in names}
    assert asked >= OF_ROLES | OF_NUMBERS
