"""FMUs that others wrote, built from their source: of the Reference FMUs of the Modelica Association.

The C files and descriptions beside this one are theirs, unchanged, of release v0.0.39 of
https://github.com/modelica/Reference-FMUs; LICENSE.txt is their licence.
"""

import zipfile
from pathlib import Path

import fmpy

from hydroservo.export.c.compiler import compiled

__all__ = ["VERSIONS", "reference_fmu"]

HERE = Path(__file__).parent
VERSIONS = {"StateSpace": 3, "Feedthrough": 2}  # of FMI, by model


def reference_fmu(model: str, folder: Path) -> Path:
    """Build an FMU for this machine, and return its file.

    Args:
        model: its name.
        folder: an empty one, in which the FMU is made.
    """
    version = VERSIONS[model]
    library = folder / f"{model}{fmpy.sharedLibraryExtension}"
    headers = Path(fmpy.__file__).parent / "c-code"
    sources = (HERE / model / "model.c", HERE / f"src/fmi{version}Functions.c", HERE / "src/cosimulation.c")
    words = [
        "-std=gnu11",
        "-shared",
        "-fPIC",
        "-DDISABLE_PREFIX",
        f"-DFMI{version}_OVERRIDE_FUNCTION_PREFIX",
        f"-DFMI_VERSION={version}",
        *(f"-I{place}" for place in (HERE / model, HERE / "include", headers)),
        *map(str, sources),
    ]
    compiled(folder, words, library.name)
    path = folder / f"{model}.fmu"
    place = fmpy.platform_tuple if version == 3 else fmpy.platform
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(HERE / model / f"FMI{version}.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{place}/{library.name}")
        archive.write(HERE / "LICENSE.txt", "documentation/licenses/license.txt")
    return path
