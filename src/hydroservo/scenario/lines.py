"""File and line of a class and of its members."""

import ast
import inspect
import textwrap
import traceback


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
