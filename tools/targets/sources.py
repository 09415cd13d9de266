"""C around an exported unit: over rows of inputs on this machine, and to be measured on a board."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from hydroservo.export.unit import CModule

Rows = NDArray[Any]  # of doubles or of floats
FOLDER = Path(__file__).parent / "c"


def width(unit: CModule) -> int:
    """How many numbers a step is given."""
    return sum(len(argument.signals) for argument in unit.arguments)


def write_unit(unit: CModule, folder: Path) -> Path:
    """Writes header and source; returns the source's path."""
    (folder / f"{unit.prefix}.h").write_text(unit.header, encoding="utf-8")
    source = folder / f"{unit.prefix}.c"
    source.write_text(unit.source, encoding="utf-8")
    return source


def write_program(unit: CModule, folder: Path) -> tuple[Path, Path]:
    """Writes the loop over rows, and a main around it that reads them from a file."""
    places = [f"{argument.name}.{signal.place}" for argument in unit.arguments for signal in argument.signals]
    init, step = calls(unit, "&given", "&")
    values = {"unit": unit, "inputs": width(unit), "places": places, "init": init, "step": step}
    return written("rows.c", folder, values), written("program.c", folder, values)


def write_measure(unit: CModule, inputs: Rows, folder: Path) -> Path:
    """Writes a main that steps through these inputs; they are finite, and written into it bit for bit."""
    prefix = unit.prefix
    init, step = calls(unit, f"&{prefix}_defaults", "&rows[i].")
    names = ["state", *([] if unit.inlined else ["parameters"]), *(one.name for one in unit.arguments)]
    constants = ["", *(["const "] * len(names))]
    declared = ", ".join(
        f"{const}{prefix}_{name} *{name}" for const, name in zip(constants, names, strict=False)
    )
    values = {
        "unit": unit,
        "rows": [row_text(unit, row.tolist()) for row in inputs],
        "init": init,
        "step": step,
        "declared": declared,
        "result": unit.real if unit.command else "void",
    }
    return written("measure.c", folder, values)


def calls(unit: CModule, parameters: str, argument: str) -> tuple[str, str]:
    """What init and step are called with; an argument's text goes before its name."""
    init = ["&state"] if unit.inlined else ["&state", parameters]
    step = [*init, *(f"{argument}{one.name}" for one in unit.arguments)]
    return ", ".join(init), ", ".join(step)


def row_text(unit: CModule, row: Sequence[float]) -> str:
    """The records of one row as an initialiser."""
    values = iter(row)
    records = []
    for argument in unit.arguments:
        fields = [f".{signal.place} = {next(values).hex()}" for signal in argument.signals]
        records.append(f".{argument.name} = {{{', '.join(fields)}}}")
    return ", ".join(records)


def written(name: str, folder: Path, values: Mapping[str, object]) -> Path:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(  # noqa: S701 - it writes C
        loader=FileSystemLoader(FOLDER),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    path = folder / name
    path.write_text(environment.get_template(f"{name}.jinja").render(values), encoding="utf-8")
    return path
