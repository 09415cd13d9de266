"""FMI's own headers, and licences, from the packages that ship them."""

from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from hydroservo.errors import HydroservoError

UNPREFIXED = "#define fmi2FullName(name) name\n"
PREFIXED = """\
#ifdef FMI2_FUNCTION_PREFIX
#define FMU_JOINED_TEXT(prefix, name) prefix##name
#define FMU_JOINED(prefix, name) FMU_JOINED_TEXT(prefix, name)
#define fmi2FullName(name) FMU_JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define fmi2FullName(name) name
#endif
"""


def headers(names: Sequence[str]) -> dict[str, str]:
    """FMI's headers by name.

    The package fmpy took the prefix out of that of FMI 2.0, as it builds shared libraries alone; here it is
    back, as the standard has it, so that several FMUs can be linked into one program.
    """
    folder = Path(str(package("fmpy").locate_file("fmpy/c-code")))
    return {name: (folder / name).read_text("utf-8").replace(UNPREFIXED, PREFIXED) for name in names}


def licence(name: str) -> str:
    """The licence text that an installed package ships.

    Raises:
        HydroservoError: the package is missing, or its licence.
    """
    for file in package(name).files or ():
        if file.name in ("LICENSE", "LICENSE.txt"):
            return file.read_text("utf-8")
    raise HydroservoError(f"the package {name} came without its licence; install it again")


def package(name: str) -> metadata.Distribution:
    """An installed package.

    Raises:
        HydroservoError: it is missing.
    """
    try:
        return metadata.distribution(name)
    except metadata.PackageNotFoundError:
        raise HydroservoError(f"an FMU needs the package {name}: pip install '.[fmu]' in a clone") from None
