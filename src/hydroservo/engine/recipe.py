"""What a kernel is made from: equal recipes give equal machine code, and a digest of one names it on disk.

The digest covers all that the code depends on: the shape of the blocks, this package's sources, the text
of users' own classes with every global that they use, the versions of the compilers and the processor.
"""

import builtins
import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

from llvmlite import binding

__all__ = ["Recipe", "UnknownContentError"]

PACKAGE = "hydroservo"
PLAIN = (bool, int, float, complex, str, bytes, type(None))
COMPILERS = ("numba", "llvmlite", "numpy")


class UnknownContentError(Exception):
    """Code that depends on something whose content cannot be told."""


class Recipe(NamedTuple):
    """The name of a kernel's text and all that it was written for."""

    text: str
    shapes: tuple[Any, ...]  # nested tuples of classes, names and plain values
    strict: bool

    def digest(self) -> str | None:
        """A name for the machine code, the same in every process; None where there cannot be one."""
        try:
            parts = [surroundings(), repr(self.text), str(self.strict), *Content().of(self.shapes)]
        except UnknownContentError:
            return None
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


@cache
def surroundings() -> str:
    """This package's sources, the compilers, their settings and the processor."""
    root = Path(__file__).parent.parent
    sources = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        sources.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes() + b"\0")
    settings = sorted(f"{name}={value}" for name, value in os.environ.items() if name.startswith("NUMBA_"))
    processor = (binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten())
    versions = (sys.version, *(version(name) for name in COMPILERS))
    return repr((sources.hexdigest(), settings, processor, versions))


def by_others(module: str) -> bool:
    """True for a module that is Python's, this package's or a compiler's: a version tells its content."""
    return module.partition(".")[0] in (PACKAGE, *COMPILERS, *sys.stdlib_module_names)


class Content:
    """Tells what classes and functions are made of, each once."""

    def __init__(self) -> None:
        self.met: set[int] = set()

    def of(self, value: Any) -> Iterator[str]:
        """Lines that differ where the content differs.

        Raises:
            UnknownContentError: the content of something cannot be told.
        """
        if isinstance(value, PLAIN):
            yield f"{type(value).__name__} {value!r}"
        elif isinstance(value, tuple | list | frozenset):
            yield f"{type(value).__name__} of {len(value)}"
            for item in sorted(value, key=repr) if isinstance(value, frozenset) else value:
                yield from self.of(item)
        elif isinstance(value, CodeType):
            yield from self.of_code(value)
        elif isinstance(value, type | FunctionType | ModuleType):
            yield from self.of_named(value)
        else:
            raise UnknownContentError(value)

    def of_named(self, value: Any) -> Iterator[str]:
        """A class, function or module: by name if it is Python's or this package's, else by its text."""
        home = value.__name__ if isinstance(value, ModuleType) else value.__module__
        yield f"{home}.{getattr(value, '__qualname__', '')}"
        if by_others(home) or id(value) in self.met:
            return
        self.met.add(id(value))
        if isinstance(value, FunctionType):
            yield from self.of_function(value)
        elif isinstance(value, type):
            yield from self.of_class(value)

    def of_class(self, value: type) -> Iterator[str]:
        yield from self.of(getattr(value, "_fields", ()))
        for name, member in vars(value).items():
            function = getattr(member, "__func__", member)
            if isinstance(function, FunctionType) and function.__module__ == value.__module__:
                yield name
                yield from self.of(function)

    def of_function(self, value: FunctionType) -> Iterator[str]:
        yield from self.of(value.__defaults__)
        yield from self.of_code(value.__code__)
        for cell in value.__closure__ or ():
            yield from self.of(cell.cell_contents)
        yield from self.of_globals(value.__globals__, value.__code__)

    def of_code(self, code: CodeType) -> Iterator[str]:
        yield code.co_code.hex()
        yield from self.of((code.co_consts, code.co_names, code.co_varnames, code.co_freevars))

    def of_globals(self, space: dict[str, Any], code: CodeType) -> Iterator[str]:
        """The globals that a function uses, and what it uses of modules."""
        for name in names(code):
            if name in space:
                yield name
                yield from self.of(space[name])
            elif not hasattr(builtins, name):
                yield from self.of_attributes(space, name)

    def of_attributes(self, space: dict[str, Any], name: str) -> Iterator[str]:
        """What a name may be in the modules that are not by others."""
        for module in space.values():
            if isinstance(module, ModuleType) and not by_others(module.__name__) and name in vars(module):
                yield f"{module.__name__}.{name}"
                yield from self.of(vars(module)[name])


def names(code: CodeType) -> Iterable[str]:
    """The names in a function and in those inside it."""
    found = dict.fromkeys(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            found |= dict.fromkeys(names(constant))
    return found
