"""Which block classes a scenario may name, and in which role."""

import copyreg
import importlib.util
import inspect
import linecache
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any

from hydroservo.control import controlled, controllers, error_dynamics, holds, monitors, observers, references
from hydroservo.core.errors import HydroservoError, ScenarioError, nearest, one_of
from hydroservo.core.field import declared_fields
from hydroservo.core.inputs import read_text
from hydroservo.machine import (
    drives,
    integrators,
    loads,
    mechanics,
    oils,
    plants,
    sensors,
    starts,
    supplies,
    valves,
)
from hydroservo.scenario.fmus import allow_fmu
from hydroservo.scenario.role_checks import (
    a_role,
    check_declared_roles,
    class_line,
    line_reached,
    role_problem,
)
from hydroservo.scenario.tables import TableEntry

Maker = Callable[..., Any]  # a block's class, or a classmethod of it whose arguments are declared as fields

OWN = "a class of your own needs its file: --plugin FILE, in Python plugins=[FILE]"

PACKAGES = (
    controlled,
    controllers,
    drives,
    error_dynamics,
    holds,
    integrators,
    loads,
    mechanics,
    monitors,
    observers,
    oils,
    plants,
    references,
    sensors,
    starts,
    supplies,
    valves,
)
LARGEST = 1 << 20  # bytes
MODULE = "hydroservo_plugin_"  # how the name of a plugin's module begins

loaded_modules: dict[Path, ModuleType] = {}


@cache
def makers(cls: type) -> dict[str, Maker]:
    """What makes blocks of a class, by the name that ``type`` gives it: the class, and its constructors."""
    constructors = (
        name for name, value in vars(cls).items() if isinstance(value, classmethod) and name[0] != "_"
    )
    return {cls.__name__: cls} | {f"{cls.__name__}.{name}": getattr(cls, name) for name in constructors}


@cache
def defaults(maker: Maker) -> Mapping[str, Any]:
    """The default of each argument, in order; None where there is none."""
    names = [*inspect.signature(maker).parameters]
    if is_block_class(maker):
        known = maker._field_defaults  # type: ignore[attr-defined]
    else:
        values = maker.__defaults__ or ()
        known = dict(zip(names[len(names) - len(values) :], values, strict=True))
    return {name: known.get(name) for name in names}


def maker_in_role(role: type, entry: TableEntry) -> Maker:
    """What a ``type`` names, among what makes blocks of a role."""
    wanted = entry.value if isinstance(entry.value, str) else ""
    named = [*shipped_makers().get(wanted, ()), *(cls for cls in plugin_classes() if wanted in makers(cls))]
    fitting = [cls for cls in named if role_problem(cls, role) is None]
    if len(fitting) > 1:
        places = " and ".join(cls.__module__ for cls in fitting)
        raise entry.error(f"names two classes, of {places}; rename that of the plugin")
    if fitting:
        return makers(fitting[0])[wanted]
    if named:
        raise entry.error(f"cannot be {a_role(role)}: {role_problem(named[0], role)}")
    raise entry.error(no_type(wanted, names_in_role(role)))


def no_type(wanted: str, names: Sequence[str]) -> str:
    """What is wrong with a name that no type has, and what it may be meant for; then all names there are."""
    if not wanted:
        return one_of(wanted, names)
    if wanted in plugin_other_classes():
        mend = f"; the plugin's class {wanted} is not a NamedTuple; write class {wanted}(NamedTuple):"
    else:
        mend = f"{nearest(wanted, names)}; {OWN}"
    return f"is not a type here{mend}; it must be one of {', '.join(names)}"


def names_in_role(role: type) -> list[str]:
    return [*makers_in_role(role)]


def makers_in_role(role: type) -> dict[str, Maker]:
    """What makes blocks of a role, by the names that ``type`` may have, in their order."""
    fitting = (cls for cls in known_classes() if role_problem(cls, role) is None)
    found = {name: maker for cls in fitting for name, maker in makers(cls).items()}
    return {name: found[name] for name in sorted(found)}


def known_classes() -> tuple[type, ...]:
    return (*shipped_classes(), *plugin_classes())


@cache
def shipped_makers() -> dict[str, list[type]]:
    """The shipped classes that a name makes blocks of."""
    found: dict[str, list[type]] = {}
    for cls in shipped_classes():
        for name in makers(cls):
            found.setdefault(name, []).append(cls)
    return found


@cache
def shipped_classes() -> tuple[type, ...]:
    """The classes of blocks and states that hydroservo has."""
    exported = (getattr(package, name) for package in PACKAGES for name in package.__all__)
    return tuple(value for value in exported if is_block_class(value))


def load_plugin(path: str | Path) -> tuple[type, ...]:
    """Execute a Python file and make its NamedTuple classes nameable in a scenario's ``type``.

    A file whose name ends in .fmu is no Python: scenarios may name it after this call, and its native code
    then runs.

    The same text is executed once. Only this call runs a user's code; no scenario file can. The file's blocks
    can be pickled: a pickle names the file, and loading it executes the file where that was not done yet, if
    its text is still the same. As with any pickle, load only what you trust.

    Returns:
        The classes that the file defines; none of an FMU.

    Raises:
        ScenarioError: the file cannot be read or executed, or defines no NamedTuple class, or a class without
            what the role that it says asks for; with its line.
    """
    name = str(path)
    if Path(path).suffix.lower() == ".fmu":
        allow_fmu(Path(path))
        return ()
    text = read_text(Path(path), LARGEST, name)
    place = Path(path).resolve()
    module_name = module_name_for(text)
    same = next((module for module in loaded_modules.values() if module.__name__ == module_name), None)
    if same is not None:
        loaded_modules[place] = same
    else:
        module = execute_plugin(text, place, module_name, name)
        if not blocks_defined_in(module):
            raise ScenarioError(name, "", "defines no block: a class with NamedTuple as its base")
        loaded_modules[place] = module
        for cls in blocks_defined_in(module):
            copyreg.pickle(cls, partial(reduce_plugin_block, str(place)))
    return blocks_defined_in(loaded_modules[place])


def plugin_classes() -> tuple[type, ...]:
    return tuple(
        dict.fromkeys(cls for module in loaded_modules.values() for cls in blocks_defined_in(module))
    )


def plugin_other_classes() -> set[str]:
    """The names of the classes of all plugins that are no NamedTuples, and so no blocks."""
    values = [
        value
        for module in loaded_modules.values()
        for value in vars(module).values()
        if isinstance(value, type)
    ]
    return {value.__name__ for value in values if is_of_plugin(value) and not is_block_class(value)}


def module_name_for(text: str) -> str:
    """The name of the module that a file's text makes: by its content, wherever it lies."""
    return f"{MODULE}{sha256(text.encode()).hexdigest()[:12]}"


def reduce_plugin_block(place: str, block: Any) -> tuple[Any, ...]:
    """What pickle keeps of a plugin's block: how to make it again in another process."""
    return restore_plugin_block, (place, type(block).__module__, type(block).__qualname__, tuple(block))


def restore_plugin_block(place: str, module_name: str, class_name: str, values: tuple[Any, ...]) -> Any:
    """A plugin's block from its pickle; executes the plugin's file unless this process has already."""
    if module_name not in sys.modules:
        if module_name_for(read_text(Path(place), LARGEST, place)) != module_name:
            raise ScenarioError(place, "", f"has changed since a {class_name} of it was pickled")
        load_plugin(place)
    return getattr(sys.modules[module_name], class_name)._make(values)


def is_block_class(value: object) -> bool:
    """True for a NamedTuple class."""
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


def is_of_plugin(maker: Any) -> bool:
    """True for a class that a plugin defines, and for a constructor of it."""
    return str(maker.__module__).startswith(MODULE)


def blocks_defined_in(module: ModuleType) -> tuple[type, ...]:
    values = vars(module).values()
    return tuple(v for v in values if is_block_class(v) and v.__module__ == module.__name__)


def execute_plugin(text: str, place: Path, module_name: str, name: str) -> ModuleType:
    """The module that a file's text makes; in sys.modules, where its annotations are resolved.

    The text is kept where Python looks for that of files: what runs can be read when the file has moved.
    """
    spec = importlib.util.spec_from_file_location(module_name, place)
    if spec is None:
        raise ScenarioError(name, "", "is not a Python file: its name must end in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    linecache.cache[str(place)] = (len(text), None, text.splitlines(keepends=True), str(place))
    try:
        exec(compile(text, str(place), "exec"), module.__dict__)  # what the caller asked for
        for cls in blocks_defined_in(module):
            declared_fields(cls)  # resolves its annotations
            try:
                check_declared_roles(cls)
            except ValueError as error:
                raise ScenarioError(name, f"line {class_line(cls)}", str(error)) from None
    except ScenarioError:
        del sys.modules[module_name]
        raise
    except (Exception, SystemExit) as error:
        del sys.modules[module_name]
        line = line_reached(error, str(place))
        if isinstance(error, SyntaxError) and error.filename == str(place):
            line = error.lineno or 0
        raise ScenarioError(name, f"line {line}" if line else "", error_text(error)) from None
    return module


def error_text(error: BaseException) -> str:
    """What an error says, with its kind where that is Python's."""
    if isinstance(error, HydroservoError):
        return str(error)
    return f"{type(error).__name__}: {error.msg if isinstance(error, SyntaxError) else error}"
