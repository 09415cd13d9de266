"""What cppcheck and its MISRA addon find in exported C."""

from pathlib import Path
from typing import NamedTuple

from hydroservo.export.unit import CModule
from tools.targets.compilers import output
from tools.targets.misra import DEVIATIONS
from tools.targets.sources import write_unit

TEMPLATE = "{file}:{line}:{column}:{id}:{message}"
MISRA = "misra-c2012-"
OPTIONS = ("--std=c99", "--enable=all", "--addon=misra", "--platform=arm32-wchar_t4", "--quiet")


class Finding(NamedTuple):
    """One line of its report; the rule is cppcheck's name, or the number of MISRA's rule."""

    place: str
    rule: str
    message: str


def findings(unit: CModule, folder: Path) -> list[Finding]:
    """All that it says of a unit.

    Left out are that nothing calls init and step, that it does not read math.h, and what it mistakes.
    """
    suppressed = ["--suppress=missingIncludeSystem"]
    source = write_unit(unit, folder)
    report = folder / "cppcheck.txt"
    output(["cppcheck", *OPTIONS, *suppressed, f"--template={TEMPLATE}", f"--output-file={report}", source])
    public = {f"'{unit.prefix}_{name}'" for name in ("init", "step")}
    found = []
    for line in report.read_text(encoding="utf-8").splitlines():
        file, number, column, rule, message = line.split(":", 4)
        if rule == "unusedFunction" and public & set(message.split()):
            continue
        if rule == f"{MISRA}12.1" and in_brackets(Path(file), int(number), int(column)):
            continue
        found.append(Finding(f"{Path(file).name}:{number}", rule.removeprefix(MISRA), message))
    return found


def in_brackets(file: Path, line: int, column: int) -> bool:
    """True at the colon of a choice whose first value stands in brackets; cppcheck 2.10 loses these."""
    before = file.read_text(encoding="utf-8").splitlines()[line - 1][:column]
    return before.endswith((") :", "):"))


def unaccepted(found: list[Finding]) -> list[Finding]:
    """Those that are not in the list of deviations."""
    return [one for one in found if one.rule not in DEVIATIONS]
