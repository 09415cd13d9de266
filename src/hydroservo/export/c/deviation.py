"""How far single precision is from double, measured by running the C."""

from collections.abc import Mapping

from hydroservo.export.c.compiler import CompilerError, compiled, ran
from hydroservo.outputs import temporary_folder


def measured_deviation(prefix: str, texts: Mapping[str, str]) -> str:
    """What the replay of an export in single precision prints.

    Args:
        prefix: of the export.
        texts: its files by name.

    Raises:
        CompilerError: there is no C compiler, or its programs do not run here.
    """
    with temporary_folder() as folder:
        for file, text in texts.items():
            (folder / file).write_text(text, encoding="utf-8")
        program = compiled(folder, [f"{prefix}_replay.c", f"{prefix}.c"], "replay")
        said = ran(folder, [str(program)]).stdout.strip()
    if not said:
        raise CompilerError("the program that the C compiler makes prints nothing here")
    return said
