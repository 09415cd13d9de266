"""How a class says its role, and what goes with it."""

from collections.abc import Callable
from typing import Any, TypeVar

from hydroservo.core.errors import LoopError

Block = Any  # a NamedTuple with methods; Python's type system has no name for "some NamedTuple"
PACKAGE = "hydroservo.core.roles."
BlockClass = TypeVar("BlockClass", bound=type)


def role(*roles: Any) -> Callable[[BlockClass], BlockClass]:
    """Says which role a block plays, as its class's attribute ``role``; several where it plays several.

    A decorator, for type checkers take a line ``role = Controller`` in a NamedTuple for one more field.
    Whether the class has what the role asks for is found out where a file is loaded as a plug-in, and by the
    contract.

    Raises:
        LoopError: it is given no roles, or stands above what is no NamedTuple, or says a role already.
    """
    for one in roles or (None,):
        if not is_role(one):
            given = "nothing" if one is None else getattr(one, "__name__", repr(one))
            raise LoopError(
                f"role is given {given}; it takes roles, in parentheses, such as @role(Controller)"
            )

    def say(cls: BlockClass) -> BlockClass:
        if not hasattr(cls, "_fields"):
            raise LoopError(f"{cls.__name__} is not a NamedTuple; write class {cls.__name__}(NamedTuple):")
        if "role" in vars(cls) and "role" not in cls._fields:
            raise LoopError(f"{cls.__name__} declares its role twice; put several in one @role(..., ...)")
        cls.role = roles[0] if len(roles) == 1 else roles  # type: ignore[attr-defined]
        return cls

    return say


def is_role(value: object) -> bool:
    """True for a Protocol of this package."""
    return getattr(value, "_is_protocol", False) and getattr(value, "__module__", "").startswith(PACKAGE)


def at_samples(cls: BlockClass) -> BlockClass:
    """Says of a monitor that ``step`` comes at samples alone, after the controller's, with the sample period.

    It stands above the class, beside its role.
    """
    cls.at_samples = True  # type: ignore[attr-defined]
    return cls


def controlling(*signals: type) -> Callable[[BlockClass], BlockClass]:
    """Says of a law which signals a loop with it can control, such as ``@controlling(Velocity)``; none: any.

    It stands above the class, beside its role. A loop that controls another is refused. A law without it goes
    with any signal, or with its field ``controls`` alone where that has a default.
    """

    def say(cls: BlockClass) -> BlockClass:
        cls.signals = signals  # type: ignore[attr-defined]
        return cls

    return say


def valveless(cls: BlockClass) -> BlockClass:
    """Says of a drive that it stands in the valve's place, so that the loop's valve must be a ``NoValve``.

    It stands above the class, beside its role.
    """
    cls.valveless = True  # type: ignore[attr-defined]
    return cls


def without_estimates(cls: BlockClass) -> BlockClass:
    """Says of an observer's state that its d1 and d2 are no estimates, so that no metric judges them."""
    cls.without_estimates = True  # type: ignore[attr-defined]
    return cls
