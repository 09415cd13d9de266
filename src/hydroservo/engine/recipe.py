"""What a kernel is made from: equal recipes give equal machine code, and a digest of one names it on disk.

The digest covers all that the code depends on: the shape of the blocks, the loaded code of each method that
a kernel can call and of every function that those call, each global that they use, the engine's own text, the
versions of the compilers and the processor.

A kernel can call a method if its name stands after a dot in the engine's text, or among the names and strings
of another method or function in the digest; those with names such as ``__call__`` always. What else a class
has (what designs, checks or describes it) does not matter.
"""

import builtins
import dis
import hashlib
import os
import re
import sys
import sysconfig
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np
from llvmlite import __version__ as llvmlite_version
from llvmlite import binding

from hydroservo import language
from hydroservo.core import ops

PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))
BELOW = {"llvmlite", "numpy", "builtins"}
ENGINE = Path(__file__).parent
LANGUAGE, OPS = Path(language.__file__).parent, Path(ops.__file__).parent
MADE = {"__new__", "__repr__", "__getnewargs__", "_make", "_replace", "_asdict"}  # by NamedTuple
NAME = re.compile(r"\.\s*([^\W\d]\w*)")
LOADS = ("LOAD_ATTR", "LOAD_METHOD")


class UnknownContentError(Exception):
    """Code depends on something whose content cannot be told; the message says on what, and where."""

    def __init__(self, what: str, where: str = "") -> None:
        self.what, self.where = what, where
        super().__init__(f"{where} uses {what}" if where else what)


class KernelKey(NamedTuple):
    """The name of a kernel's text and all that it was written for."""

    text: str
    shapes: tuple[Any, ...]  # nested tuples of classes, names and plain values
    strict: bool

    def digest(self) -> str:
        """A name for the machine code, the same in every process."""
        parts = [surroundings(), repr(self.text), str(self.strict), *content_lines(self.shapes)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    def methods(self) -> tuple[FunctionType, ...]:
        """The methods of all classes as they are now; another one makes another kernel."""
        return tuple(method for cls in distinct_classes(self.shapes) for _, method in methods_of(cls))


@cache
def distinct_classes(shapes: Any) -> tuple[type, ...]:
    """The classes in nested tuples, each once; equal tuples have the same."""
    return tuple(dict.fromkeys(nested_classes(shapes)))


def nested_classes(shapes: Any) -> Iterator[type]:
    if isinstance(shapes, type):
        yield shapes
    elif isinstance(shapes, tuple):
        for part in shapes:
            yield from nested_classes(part)


def methods_of(cls: type) -> list[tuple[str, FunctionType]]:
    """The functions that a class defines, but for those that every NamedTuple has."""
    return [
        (name, member)
        for name, member in vars(cls).items()
        if type(member) is FunctionType and name not in MADE
    ]


def engine_text() -> str:
    """A digest of the sources of the engine, the language and ops, as they are when they are loaded."""
    found = hashlib.sha256()
    for path in sorted([*ENGINE.rglob("*.py"), *LANGUAGE.glob("*.py"), *OPS.glob("*.py")]):
        found.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return found.hexdigest()


LOADED = engine_text()
# The names that stand after a dot in the engine's sources, in the text that they write too.
CALLED = frozenset(name for path in ENGINE.glob("*.py") for name in NAME.findall(path.read_text("utf-8")))


def features() -> str:
    """What the processor can, as LLVM calls it; ``HYDROSERVO_CPU_FEATURES`` may leave out some of it."""
    return os.environ.get("HYDROSERVO_CPU_FEATURES") or binding.get_host_cpu_features().flatten()


@cache
def surroundings() -> str:
    """The engine, the compilers and the processor."""
    processor = (binding.get_host_cpu_name(), features())
    versions = (sys.version, llvmlite_version, np.__version__)
    return repr((LOADED, processor, versions))


def defining_module(value: type | FunctionType) -> str:
    """The module that a class or function is really of: ``__module__`` is only what it says of itself."""
    if isinstance(value, FunctionType):
        return str(value.__globals__.get("__name__", ""))
    found: Any = sys.modules.get(str(value.__module__))
    for name in value.__qualname__.split("."):
        found = getattr(found, name, None)
    return str(value.__module__) if found is value else ""


@cache
def is_of_library(module: str) -> bool:
    """True for a module of Python or of a compiler, whose version tells its content."""
    top = module.partition(".")[0]
    if top in BELOW:
        return True
    file = getattr(sys.modules.get(top), "__file__", None)
    if top not in sys.stdlib_module_names or top == "__main__":
        return False
    return file is None or Path(file).is_relative_to(sysconfig.get_path("stdlib"))


def content_lines(value: Any) -> Iterator[str]:
    """Lines that differ where what a kernel makes of classes, functions and plain values differs."""
    content = Content()
    yield from content.of(value)
    yield from content.of_methods()


class Content:
    """Tells what classes and functions are made of, each once; of a class, the methods that can be called."""

    def __init__(self) -> None:
        self.met: dict[int, int] = {}  # the number of each, by its identity
        self.classes: list[type] = []
        self.names = set(CALLED)

    def of(self, value: Any) -> Iterator[str]:
        """Lines that differ where the content differs.

        Raises:
            UnknownContentError: the content of something cannot be told.
        """
        if type(value) in PLAIN:
            if isinstance(value, str):
                self.names.add(value)
            yield f"{type(value).__name__} {value!r}"
        elif isinstance(value, tuple | frozenset):
            yield from self.of_type(type(value))
            for item in sorted(value, key=repr) if isinstance(value, frozenset) else value:
                yield from self.of(item)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "biufc":
            yield f"{value.dtype.str} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
        elif isinstance(value, CodeType):
            yield from self.of_code(value)
        elif isinstance(value, FunctionType):
            yield from self.once(value, self.of_function)
        elif isinstance(value, type):
            yield from self.of_type(value)
        elif isinstance(value, BuiltinFunctionType) and is_of_library(value.__module__ or "builtins"):
            yield f"{value.__module__}.{value.__qualname__}"
        else:
            raise UnknownContentError(f"an object of type {type(value).__qualname__}")

    def once(self, value: Any, tell: Any) -> Iterator[str]:
        """The name of something, and its content, or where that was told before."""
        yield f"{value.__module__}.{value.__qualname__}"
        if is_of_library(defining_module(value)):
            return
        if id(value) in self.met:
            yield f"number {self.met[id(value)]}"
            return
        self.met[id(value)] = len(self.met)
        yield from tell(value)

    def of_type(self, value: type) -> Iterator[str]:
        if issubclass(value, BaseException):  # compiled code only says that one was raised
            yield f"{value.__module__}.{value.__qualname__}"
            return
        if not is_of_library(defining_module(value)) and not hasattr(value, "_fields"):
            raise UnknownContentError(f"the class {value.__qualname__}, which is not a NamedTuple")
        yield from self.once(value, self.of_class)

    def of_class(self, value: type) -> Iterator[str]:
        self.classes.append(value)
        yield repr(value._fields)  # type: ignore[attr-defined]
        for name, default in getattr(value, "_field_defaults", {}).items():
            yield from self.used(value.__qualname__, f"{name}'s default", default)

    def of_methods(self) -> Iterator[str]:
        """Of all classes met, the methods that can be called; each may bring new names and classes."""
        done: set[tuple[type, str]] = set()
        before = -1
        while len(done) > before:
            before = len(done)
            for cls in self.classes:
                for name, method in methods_of(cls):
                    if (cls, name) not in done and (name in self.names or name.startswith("__")):
                        done.add((cls, name))
                        yield f"method {name} of {self.met[id(cls)]}"
                        yield from self.of(method)

    def of_function(self, value: FunctionType) -> Iterator[str]:
        where = f"{value.__qualname__} in {value.__code__.co_filename}"
        defaults = (value.__defaults__, tuple(sorted((value.__kwdefaults__ or {}).items())))
        yield from self.used(where, "a default", defaults)
        yield from self.of_code(value.__code__)
        for name, cell in zip(value.__code__.co_freevars, value.__closure__ or (), strict=True):
            yield from self.used(where, name, cell.cell_contents)
        for name, used in globals_of(value.__globals__, value.__code__):
            yield from self.used(where, name, used)

    def used(self, where: str, name: str, value: Any) -> Iterator[str]:
        """What a function uses under a name."""
        try:
            yield from self.of(value)
        except UnknownContentError as error:
            raise error if error.where else UnknownContentError(f"{name}, {error.what}", where) from None

    def of_code(self, code: CodeType) -> Iterator[str]:
        yield code.co_code.hex()
        yield getattr(code, "co_exceptiontable", b"").hex()
        yield from self.of((code.co_consts, code.co_names, code.co_varnames, code.co_freevars))


def globals_of(space: dict[str, Any], code: CodeType) -> Iterator[tuple[str, Any]]:
    """What a function and those inside it take from outside: globals, and what they name in modules."""
    found: Any = None
    name = ""
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL":
            name = step.argval
            found = space.get(name, getattr(builtins, name, None))
            followed = isinstance(found, ModuleType)
        elif step.opname in LOADS and isinstance(found, ModuleType | type):
            name = f"{name}.{step.argval}"
            found = getattr(found, step.argval, None)
            followed = isinstance(found, ModuleType)
        else:
            found, followed = None, True
        if not followed:
            yield name, found
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from globals_of(space, constant)
