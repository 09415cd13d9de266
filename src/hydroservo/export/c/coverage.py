"""Which branches of an export's C some samples reach, as gcov counts them."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.export.c.compiler import CompilerError, compiled, counting_compiler, ran
from hydroservo.export.render import rendered
from hydroservo.export.unit import Unit

LONGEST = 20.0  # s that the samples may take
COUNTED = ("-O0", "--coverage")  # without optimization a branch of the text is one of the program


class Branch(NamedTuple):
    """One way on from a condition."""

    line: int  # of PREFIX.c
    way: int
    function: str  # in C


class Coverage:
    """The program that counts, in a folder of its own.

    Args:
        unit: the export.
        folder: for its files.

    Raises:
        CompilerError: there is no C compiler, or it does not count as gcov reads it.
    """

    def __init__(self, unit: Unit, folder: Path) -> None:
        self.unit, self.folder, p = unit, folder, unit.prefix
        if shutil.which("gcov") is None:
            raise CompilerError("gcov, which counts branches, is not found")
        texts = {
            f"{p}.h": unit.header,
            f"{p}.c": unit.source,
            "count-rows.c": rendered("rows.c", {"x": unit}),
        }
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        command = counting_compiler()
        compiled(folder, ["-c", *COUNTED, f"{p}.c"], f"{p}.o", command)
        compiled(folder, ["--coverage", "count-rows.c", f"{p}.o"], "count-rows", command)

    def branches(
        self, rows: NDArray[np.float64], stretches: Sequence[NDArray[np.float64]] = ()
    ) -> dict[Branch, bool]:
        """Each branch of the blocks' methods, and whether it is reached.

        Args:
            rows: samples from ``init`` on.
            stretches: of samples; each goes on where the rows end.
        """
        counts, p = self.folder / f"{self.unit.prefix}.gcda", self.unit.prefix
        counts.unlink(missing_ok=True)
        parts = [rows, *stretches]
        (self.folder / "count-rows.bin").write_bytes(b"".join(part.tobytes() for part in parts))
        done = ran(
            self.folder, ["./count-rows", "count-rows.bin", *(str(len(part)) for part in parts)], LONGEST
        )
        if done.returncode != 0:
            raise CompilerError(f"the program that counts branches ended with {done.returncode}")
        done = ran(self.folder, ["gcov", "--json-format", "--branch-probabilities", "--stdout", f"{p}.gcda"])
        try:
            (file,) = (one for one in json.loads(done.stdout)["files"] if one["file"] == f"{p}.c")
        except (ValueError, KeyError):
            raise CompilerError("gcov cannot read what the C compiler counts") from None
        return {
            Branch(line["line_number"], way, line["function_name"]): branch["count"] > 0
            for line in file["lines"]
            if line.get("function_name") in self.unit.functions
            for way, branch in enumerate(line["branches"])
        }
