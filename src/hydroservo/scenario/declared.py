"""Whether what a user's class says of its own arguments can stand: their units, kinds and defaults."""

import ast
import inspect
import textwrap
import traceback
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_type_hints

from hydroservo.block import is_block
from hydroservo.errors import ParameterError, ScenarioError, short
from hydroservo.field import Field, declared_fields
from hydroservo.scenario.units import check_si
from hydroservo.validation import TEXT, in_range, number


@cache
def check_maker(maker: Any) -> None:
    """Refuse an argument declared in another unit than SI's, as text, or with a default that is not allowed.

    Args:
        maker: a block's class, or a classmethod of it whose arguments are declared as fields.
    """
    cls = maker if isinstance(maker, type) else maker.__self__
    fields, kinds = declared_fields(maker), hints(maker)
    for name, parameter in inspect.signature(maker).parameters.items():
        problem = problem_of(name, fields.get(name), kinds.get(name), parameter.default)
        if problem:
            line = line_of(cls, name if maker is cls else maker.__name__)
            raise ScenarioError(shown_file(cls), f"line {line}", f"{cls.__name__}.{problem}")


def problem_of(name: str, field: Field | None, kind: Any, default: Any) -> str:
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
            number(default, name, field or Field("", name), kind)
    except ParameterError as error:
        return f"{error.path} has the default {short(error.value)}: {error.allowed}"
    return ""


def shown_file(cls: type) -> str:
    """The file of a class, from the current folder where it is in that."""
    file = Path(file_of(cls))
    return str(file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file)


@cache
def hints(maker: Any) -> dict[str, Any]:
    """The type of each argument, without its Field."""
    found = get_type_hints(maker, include_extras=True)
    return {
        name: get_args(hint)[0] if hasattr(hint, "__metadata__") else hint for name, hint in found.items()
    }


def line_of(cls: type, member: str = "") -> int:
    """The line of a class, or of a field or method of it, in its file; 0 where the text is not there."""
    try:
        lines, first = inspect.getsourcelines(cls)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, TypeError, SyntaxError):
        return 0
    defined = next(node for node in tree.body if isinstance(node, ast.ClassDef))
    named = {name_of(node): node.lineno for node in defined.body}
    return first - 1 + (named.get(member, 0) or defined.lineno)


def name_of(node: ast.stmt) -> str | None:
    """The name of a field or method; None of anything else."""
    if isinstance(node, ast.AnnAssign):
        return ast.unparse(node.target)
    return node.name if isinstance(node, ast.FunctionDef) else None


def line_reached(error: BaseException, cls: type) -> int:
    """The last line of a class's file that an error went through; 0 for none."""
    frames = traceback.extract_tb(error.__traceback__)
    return next((one.lineno or 0 for one in reversed(frames) if one.filename == file_of(cls)), 0)


def file_of(cls: type) -> str:
    """The file of a class; "" where there is none."""
    try:
        return inspect.getsourcefile(cls) or ""
    except (OSError, TypeError):
        return ""
