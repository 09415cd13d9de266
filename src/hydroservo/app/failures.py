"""What goes wrong, and at which field a page shows it."""

from typing import Any

from hydroservo.errors import HydroservoError, ParameterError, ScenarioError, clipped, defect, short

__all__ = ["Stopped", "failure"]


LONGEST = 200  # characters of a path


class Stopped(Exception):  # noqa: N818, for it is no error
    """The page asked for an end."""


def failure(error: Exception) -> dict[str, Any]:
    """An error as a page shows it: the dotted path of a field, "" for none, and what is wrong."""
    if isinstance(error, ScenarioError):
        return {"path": clipped(error.key, LONGEST), "problem": error.problem}
    if isinstance(error, ParameterError):
        return {"path": error.path, "problem": f"{short(error.value)}: {error.allowed}"}
    if isinstance(error, HydroservoError):
        return {"path": "", "problem": str(error)}
    return {"path": "", "problem": defect(error)}
