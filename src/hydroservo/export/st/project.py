"""The folder that an export in Structured Text is."""

from collections.abc import Sequence
from pathlib import Path

from hydroservo.core.errors import ParameterError
from hydroservo.core.outputs import check_outputs, staged, write_text
from hydroservo.export.st.exchange import plcopen_xml, twincat_files
from hydroservo.export.st.names import unused_name
from hydroservo.export.st.pou import block_comment
from hydroservo.export.st.replay import replay_of
from hydroservo.export.st.source import STModule
from hydroservo.export.texts import OURS, check_ours, render
from hydroservo.export.unit import CModule, Proof
from hydroservo.export.vectors import Vectors

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

    Args:
        unit: the same in C.
        module: what is exported.
        vectors: its test vectors.
        folder: missing ones are made.
        proof: what was shown of the C.

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
