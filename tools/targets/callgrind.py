"""Instructions that a step takes on this machine, counted by valgrind."""

import re
from pathlib import Path

from hydroservo.export.unit import CModule
from tools.targets.compilers import ToolError
from tools.targets.host import program
from tools.targets.sources import Rows

TOTAL = re.compile(r"^summary: (\d+)$", re.MULTILINE)


def instructions(unit: CModule, inputs: Rows, folder: Path) -> int:
    """Of a step and all that it calls, mean over these inputs, gcc -O2; the same for the same compiler.

    Raises:
        ToolError: nothing was counted.
    """
    counted = folder / "callgrind.out"
    options = ["--tool=callgrind", f"--toggle-collect={unit.prefix}_step", f"--callgrind-out-file={counted}"]
    program(unit, folder).run(inputs, under=["valgrind", *options])
    found = TOTAL.search(counted.read_text(encoding="utf-8"))
    if found is None or int(found[1]) == 0:
        raise ToolError(f"callgrind did not see {unit.prefix}_step")
    return round(int(found[1]) / len(inputs))
