"""What an object calls that it does not hold."""

from fnmatch import fnmatchcase
from pathlib import Path

from tools.targets.compilers import output

ROOTS = {"sqrt", "sqrtf"}
# What a compiler may call for a line of C that calls nothing, and why.
HELPERS = {
    "__aeabi_*": "arithmetic that the processor has no instruction for",
    "memcpy": "assignment of a whole record",
    "memset": "a record's zeros",
}


def undefined(built: Path, nm: str = "nm") -> set[str]:
    """Symbols that the linker has to find elsewhere."""
    return {line.split()[-1] for line in output([nm, "--undefined-only", built]).splitlines()}


def foreign(symbols: set[str]) -> set[str]:
    """Those that are neither roots nor a compiler's helpers."""
    return {name for name in symbols - ROOTS if not any(fnmatchcase(name, known) for known in HELPERS)}
