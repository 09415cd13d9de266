"""What an object calls that it does not hold."""

import re
from pathlib import Path

from benchmarks.targets.tools import output

__all__ = ["HELPERS", "ROOTS", "foreign", "undefined"]

ROOTS = {"sqrt", "sqrtf"}
# What a compiler may call for a line of C that calls nothing, and why.
HELPERS = {
    r"__aeabi_[dfl]\w+|__aeabi_u?[il]\w+": "arithmetic that the processor has no instruction for (libgcc)",
    r"mem(cpy|set|move)": "assignment of a whole record; any C environment has them",
}


def undefined(built: Path, nm: str = "nm") -> set[str]:
    """Symbols that the linker has to find elsewhere."""
    return {line.split()[-1] for line in output([nm, "--undefined-only", built]).splitlines()}


def foreign(symbols: set[str]) -> set[str]:
    """Those that are neither roots nor a compiler's helpers."""
    known = re.compile("|".join(HELPERS))
    return {name for name in symbols - ROOTS if not known.fullmatch(name)}
