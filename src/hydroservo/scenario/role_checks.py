"""Whether a user's class has what its role asks for, and whether what it says of its arguments can stand."""

import ast
import inspect
import textwrap
import traceback
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, get_args, get_type_hints

from hydroservo.core import roles
from hydroservo.core.block import is_block
from hydroservo.core.errors import ParameterError, ScenarioError, short
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.hooks import HOOKS
from hydroservo.core.validation import TEXT, checked_number, in_range
from hydroservo.scenario.units import check_si

ROLES: tuple[type, ...] = tuple(
    value
    for name, value in vars(roles).items()
    if getattr(value, "_is_protocol", False) and name in roles.__all__
)


def declared_roles(cls: type) -> tuple[type, ...]:
    """The roles that a class says it plays; none where it says nothing."""
    said = vars(cls).get("role", ()) if "role" not in getattr(cls, "_fields", ()) else ()
    several = said if isinstance(said, tuple) else (said,)
    for one in several:
        if one not in ROLES:
            name = getattr(one, "__name__", repr(one))
            raise ValueError(
                f"{cls.__name__} says that its role is {name}, which hydroservo.core.roles does not have"
            )
    return several


def possible_roles(cls: type) -> tuple[type, ...]:
    """The roles that a class can play: those it says, or, where it says none, all whose methods it has."""
    return declared_roles(cls) or tuple(role for role in ROLES if missing_method(cls, role) is None)


def role_problem(cls: type, role: type) -> str | None:
    """Why a class cannot take a role; None if it can.

    One that says its role has that alone; one that does not may take any role whose methods it has.
    """
    said = declared_roles(cls)
    if said and role not in said:
        return f"it says that its role is {' and '.join(one.__name__ for one in said)}"
    return missing_method(cls, role)


def check_declared_roles(cls: type) -> None:
    """Refuse a class that has not what the roles that it says ask for, or a hook that cannot be called."""
    for role in declared_roles(cls):
        problem = missing_method(cls, role) or wrong_hook(cls, role)
        if problem is not None:
            raise ValueError(f"{cls.__name__} says that its role is {role.__name__}: {problem}")


def a_role(role: type) -> str:
    """A role in a sentence, such as "an Observer"."""
    return f"{'an' if role.__name__[0] in 'AEIOU' else 'a'} {role.__name__}"


@cache
def missing_method(cls: type, role: type) -> str | None:
    """Which method of a role a class has not, or not with as many arguments; None if it has all."""
    for name, wanted in role_methods(role).items():
        method = getattr(cls, name, None)
        if not isinstance(method, FunctionType):
            return f"it has no method {name}{signature_text(wanted)}"
        if not takes_count(method, len(wanted)):
            return f"its method {name} must be {name}{signature_text(wanted)}"
    return None


def wrong_hook(cls: type, role: type) -> str | None:
    """Which of the methods that a class may have besides takes other arguments than it is called with."""
    for hook in HOOKS:
        method = getattr(cls, hook.name, None)
        if hook.role in (None, role) and hook.arguments is not None and isinstance(method, FunctionType):
            wanted = ("self", *hook.arguments)
            if not takes_count(method, len(wanted)):
                return f"its method {hook.name} must be {hook.name}{signature_text(wanted)}"
    return None


@cache
def role_methods(role: type) -> dict[str, tuple[str, ...]]:
    """The methods of a role, with the names of their arguments, self among them."""
    return {
        name: tuple(inspect.signature(value).parameters)
        for name, value in vars(role).items()
        if isinstance(value, FunctionType) and not name.startswith("_")
    }


def signature_text(arguments: Sequence[str]) -> str:
    return f"({', '.join(arguments)})"


def takes_count(method: FunctionType, count: int) -> bool:
    """Whether a function can be called with so many arguments by position."""
    try:
        inspect.signature(method).bind(*[None] * count)
    except TypeError:
        return False
    return True


@cache
def check_maker(maker: Any) -> None:
    """Refuse an argument that is text, is not declared in SI, or has a default that is not allowed."""
    cls = maker if isinstance(maker, type) else maker.__self__
    fields, kinds = declared_fields(maker), argument_types(maker)
    for name, parameter in inspect.signature(maker).parameters.items():
        problem = argument_problem(name, fields.get(name), kinds.get(name), parameter.default)
        if problem:
            line = class_line(cls, name if maker is cls else maker.__name__)
            raise ScenarioError(relative_source_file(cls), f"line {line}", f"{cls.__name__}.{problem}")


def argument_problem(name: str, field: Field | None, kind: Any, default: Any) -> str:
    """What is wrong with an argument, with its name; "" for nothing."""
    if kind is str:
        return f"{name} {TEXT}"
    for unit in (field.unit, field.over) if field else ():
        try:
            check_si(unit)
        except ValueError as error:
            return f"{name} has the unit {unit}, which {error}"
    try:
        if is_block(default):
            in_range(default, name)
        elif kind in (float, int, bool) and default is not inspect.Parameter.empty:
            checked_number(default, name, field or Field("", name), kind)
    except ParameterError as error:
        return f"{error.path} has the default {short(error.value)}: {error.allowed}"
    return ""


def relative_source_file(cls: type) -> str:
    """The file of a class, from the current folder where it is in that."""
    file = Path(source_file(cls))
    return str(file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file)


@cache
def argument_types(maker: Any) -> dict[str, Any]:
    """The type of each argument, without its Field."""
    found = get_type_hints(maker, include_extras=True)
    return {
        name: get_args(hint)[0] if hasattr(hint, "__metadata__") else hint for name, hint in found.items()
    }


def class_line(cls: type, member: str = "") -> int:
    """The line of a class, or of a field or method of it, in its file; 0 where the text is not there."""
    try:
        lines, first = inspect.getsourcelines(cls)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, TypeError, SyntaxError):
        return 0
    defined = next(node for node in tree.body if isinstance(node, ast.ClassDef))
    named = {member_name(node): node.lineno for node in defined.body}
    return first - 1 + (named.get(member, 0) or defined.lineno)


def member_name(node: ast.stmt) -> str | None:
    """The name of a field or method; None of anything else."""
    if isinstance(node, ast.AnnAssign):
        return ast.unparse(node.target)
    return node.name if isinstance(node, ast.FunctionDef) else None


def line_reached(error: BaseException, file: str) -> int:
    """The last line of a file that an error went through; 0 for none."""
    frames = traceback.extract_tb(error.__traceback__)
    return next((frame.lineno or 0 for frame in reversed(frames) if frame.filename == file), 0)


def source_file(cls: type) -> str:
    """The file of a class; "" where there is none."""
    try:
        return inspect.getsourcefile(cls) or ""
    except (OSError, TypeError):
        return ""
