"""What goes wrong, and at which field a page shows it."""

import re
from collections.abc import Mapping
from typing import Any

from hydroservo.app.form import all_numbers, form_of
from hydroservo.app.source import Home, page_source
from hydroservo.core.errors import HydroservoError, ParameterError, ScenarioError, clipped, defect, short

LONGEST = 200  # characters of a path
OF_BLOCK = re.compile(r"(\w+) = (.*?): (.*)", re.DOTALL)  # what a block says of one of its numbers
NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
RANGE = re.compile(r"must be a finite number.*", re.DOTALL)
EXAMPLE = re.compile(r"such as '[^']*'")


class Stopped(Exception):  # noqa: N818, for it is no error
    """The page asked for an end."""


def failure_on_page(error: Exception) -> dict[str, Any]:
    """An error as a page shows it: the dotted path of a field, "" for none, and what is wrong."""
    if isinstance(error, ScenarioError):
        path, said = clipped(error.key, LONGEST), OF_BLOCK.fullmatch(error.problem)
        if path and said:
            return {"path": f"{path}.{said[1]}", "problem": f"{said[2]}: {said[3]}"}
        return {"path": path, "problem": error.problem}
    if isinstance(error, ParameterError):
        return {"path": error.path, "problem": f"{short(error.value)}: {error.allowed}"}
    if isinstance(error, HydroservoError):
        return {"path": "", "problem": str(error)}
    return {"path": "", "problem": defect(error)}


def failure_at_field(error: Exception, request: Mapping[str, Any], home: Home) -> dict[str, Any]:
    """An error as :func:`failure_on_page` has it, in the unit of the field at which it is shown.

    Args:
        error: of a request.
        request: besides its changes it may have ``before``, those with which the page last had an answer.
        home: of the server.
    """
    found, before = failure_on_page(error), request.get("before")
    asked = "given" in request  # for numbers that are no fields yet
    if asked or not found["path"] or not isinstance(before, Mapping):
        return found
    try:
        form = form_of(page_source({**request, "changes": before}, home).assemble())
    except HydroservoError:
        return found
    entry = next((one for one in all_numbers(form) if one["path"] == found["path"]), None)
    if entry is None:
        return found
    text = request.get("changes", {}).get(found["path"], entry["text"])
    return {**found, "problem": problem_in_own_unit(found["problem"], str(text), entry)}


def problem_in_own_unit(problem: str, text: str, entry: Mapping[str, Any]) -> str:
    """What is wrong with a number, in the unit in which a page shows it.

    Args:
        problem: in SI units.
        text: that was entered.
        entry: of the number, as :func:`~hydroservo.app.form.number_entry` has it before.
    """
    unit, si, text = entry["unit"], entry["si"], text.strip()
    if unit and re.fullmatch(NUMBER, text):
        return f"{text} has no unit: {text} {unit}?"
    example = f"such as '{entry['text'] or f'1.5 {unit}'}'"
    said = EXAMPLE.sub(lambda _: example, RANGE.sub(f"must be {entry['allowed']}", problem))
    value = re.match(f"{NUMBER}: ", said)
    head, tail = (f"{text}: ", said[value.end() :]) if value else ("", said)
    if not si or unit == si:
        return head + tail
    tail = tail.replace(f"does not convert to {si}", f"does not convert to {unit}")
    written = re.compile(rf"({NUMBER}) (?:\[{re.escape(si)}\]|{re.escape(si)}(?![\w^²³/]))")
    return head + written.sub(lambda one: f"{entry['factor'] * float(one[1]):.6g} {unit}", tail)
