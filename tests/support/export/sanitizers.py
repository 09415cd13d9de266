"""Exported C run with every check of undefined behaviour that the compilers have."""

from pathlib import Path

from hydroservo.export.unit import CModule
from tools.targets.host import Program, program

CHECKS = {
    "gcc": "address,undefined,float-cast-overflow",
    "clang": "address,undefined,float-cast-overflow,implicit-conversion,local-bounds",
}


def watched(unit: CModule, folder: Path, compiler: str) -> Program:
    """A program that stops at the first operation that C does not define, or access outside an object."""
    checks = [f"-fsanitize={CHECKS[compiler]}", "-fno-sanitize-recover=all"]
    return program(unit, folder, compiler, ["-O1", "-g", *checks])
