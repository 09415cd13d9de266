"""What comes back from wherever units are done."""

from collections.abc import Callable
from traceback import format_exc
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from hydroservo._version import __version__
from hydroservo.errors import HydroservoError, system_problem

if TYPE_CHECKING:
    import pyarrow as pa


class Failure(NamedTuple):
    """Why a unit has no table.

    Attributes:
        text: in one line, or the traceback of a defect.
        defect: whether it is nothing that a user can mend.
    """

    text: str
    defect: bool = False


Answer: TypeAlias = "pa.Table | Failure"
Say = Callable[[str], None]  # a line of what a user should know


def answer_to(do: "Callable[[], pa.Table]", version: str) -> Answer:
    """What a unit comes to, here.

    Args:
        do: computes its table.
        version: of hydroservo, where the unit was made.
    """
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
