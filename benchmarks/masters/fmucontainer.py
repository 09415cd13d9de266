"""fmucontainer of the FMU Manipulation Toolbox: one FMU made of several."""

import json
import logging
from collections.abc import Sequence
from functools import partial

from benchmarks.masters.fmpy import played
from benchmarks.masters.master import Master
from benchmarks.masters.system import VELOCITY, System
from hydroservo.export.fmu import PARTS
from hydroservo.export.unit import Part

__all__ = ["MASTERS"]


def contained(system: System, sequential: bool) -> Sequence[float]:
    from fmu_manipulation_toolbox.assembly import Assembly

    logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.ERROR)  # every output that nothing reads
    name = f"sequential-{sequential}"
    description = {
        "name": f"{name}.fmu",
        "fmu": [f"{part}.fmu" for part in PARTS],
        "link": [[f"{start}.fmu", port, f"{end}.fmu", port] for start, end, port in system.connections],
        "output": [[f"{Part.MACHINE}.fmu", VELOCITY, VELOCITY]],
        "auto_input": False,
        "auto_output": False,
        "auto_link": False,
        "sequential": sequential,
        "step_size": system.period,
    }
    (system.folder / f"{name}.json").write_text(json.dumps(description), encoding="utf-8")
    Assembly(f"{name}.json", fmu_directory=system.folder).make_fmu(fmi_version=int(system.version))
    return played(system, system.folder / f"{name}.fmu")


PACKAGE = "fmu_manipulation_toolbox"
MASTERS = (
    Master(
        "fmucontainer -sequential",
        PACKAGE,
        "unit by unit as listed: controller, machine, demand",
        partial(contained, sequential=True),
    ),
    Master(
        "fmucontainer",
        PACKAGE,
        "sets the inputs of all, steps all, reads the outputs of all",
        partial(contained, sequential=False),
    ),
)
