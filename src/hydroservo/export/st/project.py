"""The folder that an export in Structured Text is."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import ParameterError
from hydroservo.core.outputs import check_outputs, staged, write_text
from hydroservo.export.layout import INDENT, ST, split_statement
from hydroservo.export.st.exchange import plcopen_xml, twincat_files
from hydroservo.export.st.names import BEYOND, literal_of, parts_of, unused_name
from hydroservo.export.st.pou import Declaration, Pou, block_comment
from hydroservo.export.st.primitives import text_function, with_callees
from hydroservo.export.st.source import REALS, STModule
from hydroservo.export.st.writer import block_name
from hydroservo.export.texts import OURS, check_ours, render
from hydroservo.export.unit import TOLERANCE, CModule, Part, Proof
from hydroservo.export.vectors import Vectors

MISSING = 2 * BEYOND  # the exponent that stands for not-a-number in test vectors
SAMPLE = "samples"  # the replay's variable


def replay_of(module: STModule, unit: CModule, vectors: Vectors) -> list[Pou]:
    """What runs a unit through test vectors, a sample at each call, and counts the numbers that differ."""
    real, p, count = REALS[unit.real], unit.prefix, len(vectors.expected)
    columns = zip((*module.inputs, *module.states), (*vectors.inputs.T, *vectors.expected.T), strict=True)
    tables = [Column(f"column_{i}", p, real, place, numbers) for i, (place, numbers) in enumerate(columns, 1)]
    inputs, states = tables[: len(module.inputs)], tables[len(module.inputs) :]
    body = [f"IF {SAMPLE} >= {count} THEN", f"{INDENT}RETURN;", "END_IF;"]
    arguments = ", ".join(f"{one.place} := {one.number}" for one in inputs)
    if unit.part is Part.DEMAND:  # whose first call is the start, which vectors begin after
        body += [f"IF {SAMPLE} = 0 THEN", f"{INDENT}unit();", "END_IF;"]
    body += split_statement(f"unit({arguments});", "", ST)
    for one in states:
        compared = f"unit.state.{one.place}, {one.number}, {one.tolerance}"
        body += split_statement(f"IF {p}_differs({compared}) THEN", "", ST)
        body += [f"{INDENT}mismatches := mismatches + 1;", "END_IF;"]
    body += [f"{SAMPLE} := {SAMPLE} + 1;", f"done := {SAMPLE} >= {count};"]
    sections = {
        "VAR_OUTPUT": [
            Declaration("done", "BOOL", "all samples have been replayed"),
            Declaration(SAMPLE, "DINT", "replayed so far"),
            Declaration("mismatches", "DINT", "numbers that differ from the simulation; 0 where all is well"),
        ],
        "VAR": [Declaration("unit", block_name(p))],
        "VAR CONSTANT": [declaration for one in tables for declaration in one.declarations()],
    }
    about = f"Replays {count} samples through {block_name(p)}, one at each call.\n\n{vectors.made}"
    return [*vector_functions(module, p, real), Pou(f"{block_name(p)}_replay", "", about, sections, body)]


class Column(NamedTuple):
    """The numbers of one signal in test vectors: a constant array, or two of mantissas and exponents."""

    name: str
    prefix: str
    real: str
    place: str
    numbers: NDArray[np.float64]

    @property
    def number(self) -> str:
        """The number of the sample at hand."""
        here = f"{self.name}[{SAMPLE}]"
        return here if self.is_plain() else f"{self.prefix}_expected({here}, {self.name}_exponent[{SAMPLE}])"

    @property
    def tolerance(self) -> str:
        """How far a number may be off: not at all, or in single precision as far as in C."""
        sizes = np.abs(self.numbers[np.isfinite(self.numbers)])
        most = float(TOLERANCE) * float(sizes.max(initial=0.0))
        return "0.0" if self.real == "LREAL" else literal_of(most, self.real) or "0.0"

    def is_plain(self) -> bool:
        """True where each number has a literal."""
        return all(literal_of(one, self.real) for one in self.numbers.tolist())

    def declarations(self) -> list[Declaration]:
        """The array, or both."""
        numbers = self.numbers.tolist()
        if self.is_plain():
            return [self.declaration(self.name, [literal_of(one, self.real) for one in numbers])]
        parts = [("1.0", f"{MISSING}.0") if math.isnan(one) else parts_of(one, self.real) for one in numbers]
        names = (self.name, f"{self.name}_exponent")
        return [
            self.declaration(name, [*of]) for name, of in zip(names, zip(*parts, strict=True), strict=True)
        ]

    def declaration(self, name: str, literals: Sequence[str]) -> Declaration:
        return Declaration(name, self.real, self.place, literals, length=len(literals))


def vector_functions(module: STModule, prefix: str, real: str) -> list[Pou]:
    """What reads a number of a test vector, what compares one, and what they call."""
    known = {pou.name for pou in module.functions}
    helpers = [text_function(name, prefix, real) for name in with_callees(["nan"])]
    expected, differs = f"{prefix}_expected", f"{prefix}_differs"
    parts = [Declaration("mantissa", real), Declaration("exponent", real)]
    compared = [Declaration(name, real) for name in ("x", "y", "tolerance")]
    return [
        *(pou for pou in helpers if pou.name not in known),
        Pou(
            expected,
            real,
            f"A number of a test vector; an exponent of {MISSING} stands for not-a-number.",
            {"VAR_INPUT": parts},
            [
                f"IF exponent = {MISSING}.0 THEN",
                f"{INDENT}{expected} := {prefix}_nan(FALSE);",
                "ELSE",
                f"{INDENT}{expected} := {prefix}_number(mantissa, exponent);",
                "END_IF;",
            ],
        ),
        Pou(
            differs,
            "BOOL",
            "TRUE for two numbers farther apart than a tolerance; 0.0 and -0.0 count as equal.",
            {"VAR_INPUT": compared},
            [
                "IF (x <> x) OR (y <> y) THEN",
                f"{INDENT}{differs} := (x = x) OR (y = y);",
                "ELSE",
                f"{INDENT}{differs} := (x <> y) AND NOT (ABS(x - y) <= tolerance);",
                "END_IF;",
            ],
        ),
    ]


TWINCAT = "twincat"  # the folder of its files


def checked_st_prefix(prefix: str) -> str:
    """The prefix, if names in Structured Text may begin with it.

    Raises:
        ParameterError: they may not.
    """
    allowed = unused_name(prefix, set())
    if allowed != prefix:
        raise ParameterError("prefix", prefix, f"is not a name in Structured Text; {allowed} is one")
    return prefix


def write_st_project(
    unit: CModule, module: STModule, vectors: Vectors, folder: Path, proof: Proof
) -> list[Path]:
    """Write an export in Structured Text to a folder, and leave other files in it alone.

    Returns:
        The paths written.

    Raises:
        HydroservoError: a file cannot be written, or one of another origin is there under its name.
    """
    texts = st_project(unit, module, vectors, proof)
    check_st_project(folder, list(texts))
    for path in (folder / TWINCAT).glob("*.Tc*"):  # a project takes all files of this folder
        if f"{TWINCAT}/{path.name}" not in texts:
            check_ours(path)
            path.unlink()
    with staged(folder) as stage:
        for name, text in texts.items():
            (stage / name).parent.mkdir(exist_ok=True)
            write_text(stage / name, text)
    return [folder / name for name in texts]


def check_st_project(folder: Path, names: Sequence[str] = ("README.md",)) -> None:
    """Refuse a folder that cannot be written to, or that has a file of another origin."""
    check_outputs([folder / name for name in names])
    for name in names:
        check_ours(folder / name)


def st_project(unit: CModule, module: STModule, vectors: Vectors, proof: Proof) -> dict[str, str]:
    """The texts of :func:`write_st_project` by file name."""
    p, replay, mark = unit.prefix, replay_of(module, unit, vectors), f"{OURS} {unit.version}"
    head = f"The replay of {p}.st.\n\n{mark} from a scenario with hash {unit.hash}."
    types, pous = module.structures, module.pous
    objects = twincat_files(mark, unit.hash, types, [*pous, *replay])
    known = {
        "x": unit,
        "block": module.block.name,
        "mark": mark,
        "proof": proof,
        "samples": len(vectors.expected),
        "inputs": list(zip(module.inputs, unit.inputs, strict=True)),
        "controls": module.block.sections["VAR_INPUT"][len(module.inputs) + 1 :],
        "outputs": module.outputs,
        "states": list(zip(module.states, unit.states, strict=True)),
        "names": module.parameters,
        "parameters_type": module.parameters_type,
        "functions": len(pous) - 1,
        "structures": len(types),
        "lines": module.text.count("\n"),
        "reads_command": "applied_command" in module.inputs,
        "quantises": any(one.about.startswith("DAC:") for one in types),
    }
    return {
        f"{p}.st": module.text,
        f"{p}_replay.st": "\n".join([block_comment(head), *(pou.text for pou in replay)]),
        f"{p}.xml": plcopen_xml(p, mark, types, pous),
        f"{p}_replay.xml": plcopen_xml(f"{p}_replay", mark, [], replay),
        **{f"{TWINCAT}/{name}": text for name, text in objects.items()},
        "README.md": render("st_readme.md", known),
    }
