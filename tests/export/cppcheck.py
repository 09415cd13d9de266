"""What cppcheck and its MISRA addon find in exported C."""

from pathlib import Path
from typing import NamedTuple

from benchmarks.targets.sources import write_unit
from benchmarks.targets.tools import output

from hydroservo.export.exported import Exported
from hydroservo.export.misra import DEVIATIONS

__all__ = ["Finding", "findings", "unaccepted"]

TEMPLATE = "{file}:{line}:{id}:{message}"
MISRA = "misra-c2012-"
OPTIONS = ("--std=c99", "--enable=all", "--addon=misra", "--platform=arm32-wchar_t4", "--quiet")


class Finding(NamedTuple):
    """One line of its report; the rule is cppcheck's name, or the number of MISRA's rule."""

    place: str
    rule: str
    message: str


def findings(unit: Exported, folder: Path) -> list[Finding]:
    """All that it says of a unit, but that init and step are not called and math.h is not read."""
    suppressed = ["--suppress=missingIncludeSystem"]
    source = write_unit(unit, folder)
    report = folder / "cppcheck.txt"
    output(["cppcheck", *OPTIONS, *suppressed, f"--template={TEMPLATE}", f"--output-file={report}", source])
    public = {f"'{unit.prefix}_{name}'" for name in ("init", "step")}
    found = []
    for line in report.read_text(encoding="utf-8").splitlines():
        file, number, rule, message = line.split(":", 3)
        if rule == "unusedFunction" and public & set(message.split()):
            continue
        found.append(Finding(f"{Path(file).name}:{number}", rule.removeprefix(MISRA), message))
    return found


def unaccepted(found: list[Finding]) -> list[Finding]:
    """Those that are not in the list of deviations."""
    return [one for one in found if one.rule not in DEVIATIONS]
