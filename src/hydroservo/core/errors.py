"""What goes wrong in ways a user can mend, and what a user should know; each message is one line."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any


class HydroservoError(Exception):
    """The base of all errors that hydroservo raises for its user to mend."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class HydroservoWarning(UserWarning):
    """A result that is there, and what its user should know of it."""


class ParameterError(HydroservoError):
    """A parameter of a block is not what it must be."""

    def __init__(self, path: str, value: object, allowed: str) -> None:
        self.path, self.value, self.allowed = path, value, allowed
        super().__init__(f"{path} = {short(value)}: {allowed}")

    def __reduce__(self) -> tuple[Any, ...]:  # so that it comes back whole from a worker process
        return type(self), (self.path, self.value, self.allowed)


class ScenarioError(HydroservoError):
    """A scenario, or a file it names, does not say what it must."""

    def __init__(self, file: str, key: str, problem: str) -> None:
        self.file, self.key, self.problem = file, key, problem
        parts = (clipped(file), clipped(key), clipped(problem, 1000))
        super().__init__(": ".join(part for part in parts if part))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.file, self.key, self.problem)


class LoopError(HydroservoError):
    """Blocks that do not fit together, or a block that does not behave as one."""


def require(library: str, extra: str, what: str) -> None:
    """Refuse what needs a library that is not there, and say how to install it.

    Raises:
        HydroservoError: it is not there.
    """
    from importlib.util import find_spec

    if find_spec(library) is None:
        raise HydroservoError(f"{what} needs {library}: pip install 'hydroservo[{extra}]'")


def system_problem(error: OSError) -> str:
    """What the system would not do, and with which file."""
    parts = (error.filename, error.strerror or str(error))
    return one_line(": ".join(str(part) for part in parts if part))


def defect(error: Exception) -> str:
    """An error that nothing foresees, in a line."""
    notes = "".join(f"; {note}" for note in getattr(error, "__notes__", ()))
    return one_line(f"a defect of hydroservo: {type(error).__name__}: {error}{notes}")


def short(value: object) -> str:
    """A value as it may stand in a one-line message."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits, tables in tables in tables
        return f"a huge {type(value).__name__}"
    if "\n" in text:  # the many lines that a loop or a dataset shows of itself
        name = type(value).__name__
        return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"
    return clipped(text, 60)


def clipped(text: str, most: int = 400) -> str:
    """Text of at most so many characters."""
    return text if len(text) <= most else f"{text[: most - 3]}..."


def one_line(text: str) -> str:
    """Text with line breaks and other characters that cannot be printed written as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


LONGEST = 64  # characters; hardly a right name is longer, and matching takes the square of it


def nearest(wrong: str, right: Iterable[str]) -> str:
    """A question to end a message with: "; did you mean PI?", or nothing where no name is near."""
    if len(wrong) > LONGEST:
        return ""
    names = {name.lower(): name for name in right}
    near = get_close_matches(wrong.lower(), names, n=1)
    return f"; did you mean {names[near[0]]}?" if near else ""


def one_of(wrong: str, right: Iterable[str]) -> str:
    """What a name must be, and the nearest one."""
    names = list(right)
    return f"must be one of {', '.join(names)}{nearest(wrong, names)}"
