"""The text of blocks with other operations in place of numbers': with symbols, or with numbers and slopes.

A block's methods are plain Python that calls only each other, nested blocks and :mod:`hydroservo.core.ops`.
So the same code, with other functions under the name ``ops``, computes with whatever these take. The classes
themselves stay as they are: each has a twin, a class derived from it whose methods see the twins of all that
theirs see.
"""

from collections.abc import Callable
from types import CodeType, FunctionType, ModuleType, SimpleNamespace
from typing import Any

from hydroservo.core import ops
from hydroservo.core.block import is_block

MADE = {"__new__", "__repr__", "__getnewargs__", "_make", "_replace", "_asdict"}  # by NamedTuple


class Twins:
    """Makes the twins of blocks, classes and functions, each once."""

    def __init__(self, operations: SimpleNamespace, number: Callable[[Any], Any]) -> None:
        self.made: dict[Any, Any] = {}
        self.ops, self.number = operations, number

    def of(self, value: Any) -> Any:
        """The twin of anything that a method may name or hold; itself where it has none."""
        if value is ops:
            return self.ops
        if isinstance(value, FunctionType) and value.__module__.startswith(f"{ops.__name__}."):
            return getattr(self.ops, value.__name__)
        if isinstance(value, FunctionType):
            return self.once(value, self.of_function)
        if isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
            return self.once(value, self.of_class)
        if is_block(value):
            return self.of(type(value))(*map(self.of, value))
        return value

    def once(self, value: Any, make: Callable[[Any], Any]) -> Any:
        if value not in self.made:
            self.made[value] = value  # what meets itself on the way
            make(value)
        return self.made[value]

    def of_function(self, function: FunctionType) -> None:
        seen = dict(function.__globals__)
        twin = FunctionType(
            function.__code__, seen, function.__name__, function.__defaults__, function.__closure__
        )
        twin.__kwdefaults__ = function.__kwdefaults__
        self.made[function] = twin
        for name in code_names(function.__code__):
            if name in seen and not (isinstance(seen[name], ModuleType) and seen[name] is not ops):
                seen[name] = self.of(seen[name])
        seen["float"] = self.number

    def of_class(self, cls: type) -> None:
        twin = type(cls.__name__, (cls,), {"__slots__": (), "__module__": cls.__module__})
        self.made[cls] = twin
        for name, member in vars(cls).items():
            if type(member) is FunctionType and name not in MADE:
                setattr(twin, name, self.of(member))


def code_names(code: CodeType) -> set[str]:
    """All names in a function's code, and in those inside it."""
    inner = (code_names(one) for one in code.co_consts if isinstance(one, CodeType))
    return set(code.co_names).union(*inner)
