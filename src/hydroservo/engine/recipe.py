"""What a kernel is made from: equal recipes give equal machine code, and a digest of one names it on disk.

The digest covers all that the code depends on: the shape of the blocks, the loaded code of their classes
and of every function that it calls, each global that it uses, the engine's own text, the versions of the
compilers and the processor.
"""

import builtins
import dis
import hashlib
import os
import sys
import sysconfig
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

from llvmlite import binding

__all__ = ["Recipe", "UnknownContentError", "classes", "methods_of"]

PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
COMPILERS = ("numba", "llvmlite", "numpy")
ENGINE = Path(__file__).parent
MADE = {"__new__", "__repr__", "__getnewargs__", "_make", "_replace", "_asdict"}  # by NamedTuple
LOADS = ("LOAD_ATTR", "LOAD_METHOD")


class UnknownContentError(Exception):
    """Code depends on something whose content cannot be told."""


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

    def methods(self) -> tuple[FunctionType, ...]:
        """The methods of all classes as they are now; another one makes another kernel."""
        return tuple(method for cls in classes(self.shapes) for _, method in methods_of(cls))


def classes(shapes: Any) -> Iterator[type]:
    """The classes in nested tuples."""
    if isinstance(shapes, type):
        yield shapes
    elif isinstance(shapes, tuple):
        for part in shapes:
            yield from classes(part)


def methods_of(cls: type) -> Iterator[tuple[str, FunctionType]]:
    """The functions that a class defines, but for those that every NamedTuple has."""
    for name, member in vars(cls).items():
        if isinstance(member, FunctionType) and name not in MADE:
            yield name, member


def engine_text() -> str:
    """A digest of the engine's sources, as they are when it is loaded."""
    found = hashlib.sha256()
    for path in sorted(ENGINE.glob("*.py")):
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()


LOADED = engine_text()


@cache
def surroundings() -> str:
    """The engine, the compilers, their settings and the processor."""
    settings = sorted(f"{name}={value}" for name, value in os.environ.items() if name.startswith("NUMBA_"))
    processor = (binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten())
    versions = (sys.version, *(version(name) for name in COMPILERS))
    return repr((LOADED, settings, processor, versions))


@cache
def by_others(module: str) -> bool:
    """True for a module of Python or of a compiler, whose version tells its content."""
    top = module.partition(".")[0]
    if top in COMPILERS or top == "builtins":
        return True
    file = getattr(sys.modules.get(top), "__file__", None)
    if top not in sys.stdlib_module_names or top == "__main__":
        return False
    return file is None or Path(file).is_relative_to(sysconfig.get_path("stdlib"))


class Content:
    """Tells what classes and functions are made of, each once."""

    def __init__(self) -> None:
        self.met: set[int] = set()

    def of(self, value: Any) -> Iterator[str]:
        """Lines that differ where the content differs.

        Raises:
            UnknownContentError: the content of something cannot be told.
        """
        if type(value) in PLAIN:
            yield f"{type(value).__name__} {value!r}"
        elif isinstance(value, tuple | frozenset):
            yield from self.of_type(type(value))
            for item in sorted(value, key=repr) if isinstance(value, frozenset) else value:
                yield from self.of(item)
        elif isinstance(value, CodeType):
            yield from self.of_code(value)
        elif isinstance(value, FunctionType):
            yield from self.once(value, self.of_function)
        elif isinstance(value, type):
            yield from self.of_type(value)
        elif isinstance(value, BuiltinFunctionType) and by_others(value.__module__ or "builtins"):
            yield f"{value.__module__}.{value.__qualname__}"
        else:
            raise UnknownContentError(value)

    def once(self, value: Any, tell: Any) -> Iterator[str]:
        """The name of something, and its content if it was not told before."""
        yield f"{value.__module__}.{value.__qualname__}"
        if not by_others(value.__module__) and id(value) not in self.met:
            self.met.add(id(value))
            yield from tell(value)

    def of_type(self, value: type) -> Iterator[str]:
        if not by_others(value.__module__) and not hasattr(value, "_fields"):
            raise UnknownContentError(value)
        yield from self.once(value, self.of_class)

    def of_class(self, value: type) -> Iterator[str]:
        yield repr(value._fields)  # type: ignore[attr-defined]
        for name, method in methods_of(value):
            yield name
            yield from self.of(method)

    def of_function(self, value: FunctionType) -> Iterator[str]:
        yield from self.of((value.__defaults__, tuple(sorted((value.__kwdefaults__ or {}).items()))))
        yield from self.of_code(value.__code__)
        for cell in value.__closure__ or ():
            yield from self.of(cell.cell_contents)
        for used in globals_of(value.__globals__, value.__code__):
            yield from self.of(used)

    def of_code(self, code: CodeType) -> Iterator[str]:
        yield code.co_code.hex()
        yield getattr(code, "co_exceptiontable", b"").hex()
        yield from self.of((code.co_consts, code.co_names, code.co_varnames, code.co_freevars))


def globals_of(space: dict[str, Any], code: CodeType) -> Iterator[Any]:
    """What a function and those inside it take from outside: globals, and what they name in modules."""
    found: Any = None
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL":
            found = space.get(step.argval, getattr(builtins, step.argval, None))
            followed = isinstance(found, ModuleType)
        elif step.opname in LOADS and isinstance(found, ModuleType | type):
            found = getattr(found, step.argval, None)
            followed = isinstance(found, ModuleType)
        else:
            found, followed = None, True
        if not followed:
            yield found
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from globals_of(space, constant)
