"""What the methods of a loop's blocks return, held against their roles."""

from functools import cache
from types import FunctionType
from typing import Any, get_type_hints

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, is_block, leaves
from hydroservo.core.errors import LoopError, short
from hydroservo.core.roles import (
    Controller,
    Differentiator,
    Filter,
    Observer,
    Plant,
    PositionSensor,
    PressureSensor,
    VelocityEstimator,
)
from hydroservo.core.roles.saying import is_role

STATES: dict[Any, tuple[str, ...]] = {  # the numbers that others read in the state of a role
    Controller: ("u",),
    Observer: ("d1", "d2", "s1", "s2", "velocity", "hydraulic_force"),
    Differentiator: ("rate",),
    Filter: ("value",),
    Plant: ("velocity", "position"),
    PositionSensor: ("value",),
    VelocityEstimator: ("value",),
    PressureSensor: ("value",),
}


def with_checked_returns(loop: Loop) -> Loop:
    """A loop for plain Python whose blocks raise a LoopError once a method returns what its role does not."""
    parts: dict[str, Any] = {
        name: CheckedReturns(getattr(loop, name), role, name) for name, role in roles().items()
    }
    return loop._replace(**parts)


@cache
def roles() -> dict[str, type]:
    """The role of each block of a loop, by its name there."""
    return {name: kind for name, kind in get_type_hints(Loop).items() if is_role(kind)}


@cache
def returned(role: type, name: str) -> Any:
    """What a method of a role returns."""
    return get_type_hints(getattr(role, name))["return"]


class CheckedReturns:
    """A block whose methods return what its role says, or raise a LoopError.

    Attributes:
        block: the block.
        role: its role.
        place: its name in the loop.
    """

    def __init__(self, block: Block, role: type, place: str) -> None:
        self.block, self.role, self.place = block, role, place

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.block, name)
        if not isinstance(vars(self.role).get(name), FunctionType):
            return found

        def call(*arguments: Any) -> Any:
            result = found(*arguments)
            problem = self.problem(name, arguments, result)
            if problem:
                cls = type(self.block).__name__
                raise LoopError(
                    f"the {self.place} {cls}: {name} returns {short(result)}{problem}{method_place(found)}"
                )
            return result

        return call

    def problem(self, name: str, arguments: tuple[Any, ...], result: Any) -> str:
        """How a result is not what a method is to return; "" where it is."""
        wanted = returned(self.role, name)
        if name == "init" and not is_block(result):
            return "; it must return the first state, a NamedTuple of floats"
        if name == "init":
            lost = [one for one in STATES.get(self.role, ()) if one not in result._fields]
            return f"; it must have {lost[0]}" if lost else missing(result)
        if name in ("step", "deriv") and type(result) is not type(arguments[0]):
            state = type(arguments[0]).__name__
            return f"; it must return a {state}, as init does: a {name} returns its state's type"
        if hasattr(wanted, "_fields") and not set(wanted._fields) <= set(getattr(result, "_fields", ())):
            return f"; it must return a {wanted.__name__}"
        if wanted is float and not a_number(result):
            return "; it must return a float"
        return missing(result)


def missing(result: Any) -> str:
    """Which number of a record is none."""
    empty = [path for path, value in leaves(result) if not a_number(value)] if is_block(result) else []
    return f", whose {empty[0]} is not a number" if empty else ""


def a_number(value: Any) -> bool:
    """Whether something may pass for a number in plain Python."""
    return value is not None and not isinstance(value, str | tuple | list | dict)


def method_place(method: Any) -> str:
    """The file and line of a method, in brackets."""
    code = getattr(method, "__code__", None)
    return f" ({code.co_filename}, line {code.co_firstlineno})" if code is not None else ""
