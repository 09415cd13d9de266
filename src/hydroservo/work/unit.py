"""A unit of work: something that is done once, addressed by what it is."""

import json
import math
from collections.abc import Callable, Generator, Mapping
from hashlib import sha256
from traceback import format_exc
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError, ParameterError, system_problem

if TYPE_CHECKING:
    import pyarrow as pa

DIGITS = 24  # of an address, 96 bits: among a billion units no two are alike

UnitAnswer: TypeAlias = "pa.Table | Failure"
UnitAnswers: TypeAlias = "Generator[tuple[WorkUnit, UnitAnswer]]"
Say = Callable[[str], None]  # a line of what a user should know


class WorkUnit(NamedTuple):
    """Something to be done once."""

    key: str  # its address, as :func:`unit_address` makes it of all that its table depends on
    # computes its table; ``functools.partial`` of a function of a module with plain data, so that another
    # process can, or another machine
    do: "Callable[[], pa.Table]"
    name: str  # what progress and errors call it


def unit_address(what: Mapping[str, Any]) -> str:
    """Hexadecimal digits that name what a unit is: of the SHA-256 of its canonical JSON.

    Keys are sorted, and floats have all their digits: 1.0 is not 1, 0.1 + 0.2 not 0.3.
    """
    text = json.dumps(exact_json(what, ""), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return sha256(text.encode()).hexdigest()[:DIGITS]


def exact_json(value: Any, path: str) -> Any:
    """A value as JSON holds it exactly."""
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise ParameterError(
                    path or "what", key, "must be a string, like all keys of what is addressed"
                )
        return {key: exact_json(one, f"{path}.{key}" if path else key) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [exact_json(one, f"{path}[{i}]") for i, one in enumerate(value)]
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    raise ParameterError(
        path, value, "must be a string, a finite number, True, False, None, or groups of them"
    )


class Failure(NamedTuple):
    """Why a unit has no table."""

    text: str  # in one line, or the traceback of a defect
    defect: bool = False  # whether it is nothing that a user can mend


def answer_to(do: "Callable[[], pa.Table]", version: str) -> UnitAnswer:
    """What a unit comes to, here."""
    if version != __version__:
        return Failure(f"a worker has version {__version__} of hydroservo, and this is version {version}")
    try:
        return do()
    except HydroservoError as error:
        return Failure(str(error))
    except OSError as error:
        return Failure(system_problem(error))
    except Exception:  # whatever it is, it goes back to whoever asked
        return Failure(format_exc(), defect=True)
