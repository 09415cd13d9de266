"""An FMU put to use: which of its variables stand for which signals, and with which parameters."""

import copyreg
import json
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.core.errors import HydroservoError
from hydroservo.cosimulation.fmu import Fmu, read_fmu

Parameter = tuple[float | bool | str, ...]  # one value, or those of an array


class Wire(NamedTuple):
    """A signal of the loop and the variable that stands for it.

    Attributes:
        signal: such as "position".
        variable: the name of the FMU's variable.
        element: which of an array's, from 0.
        factor: SI units per unit of the variable.
    """

    signal: str
    variable: str
    element: int
    factor: float


class Foreign(NamedTuple):
    """An FMU, its wires and its parameters.

    Attributes:
        fmu: what is known of the file.
        inputs: what it is given at each communication.
        outputs: what it answers.
        parameters: what is set before its initialization, by name, in its own units.
    """

    fmu: Fmu
    inputs: tuple[Wire, ...]
    outputs: tuple[Wire, ...]
    parameters: tuple[tuple[str, Parameter], ...]

    @property
    def name(self) -> str:
        """What messages call it."""
        return self.fmu.path.name

    def digest(self) -> str:
        """Differs where content, wires or parameters do."""
        text = json.dumps([self.fmu.digest, self.inputs, self.outputs, self.parameters])
        return sha256(text.encode()).hexdigest()[:12]


def fmu_block_class(base: type, foreign: Foreign) -> type[Any]:
    """A class of blocks that have this FMU as their ``foreign``.

    Its module's name holds the digest, as that of a plug-in's does: results and hashes tell it from others.
    """
    return cached_block_class(base, str(foreign.fmu.path), foreign.fmu.digest, *foreign[1:])


@cache
def cached_block_class(base: type, path: str, content: str, *use: Any) -> type[Any]:
    """The one class of an FMU put to use in one way.

    Args:
        base: the class of blocks without an FMU.
        path: of the file.
        content: the digest of what is in it.
        use: the wires and the parameters.

    Raises:
        HydroservoError: the file is not there, or not what it was.
    """
    fmu = read_fmu(Path(path))
    if fmu.digest != content:
        raise HydroservoError(f"{path}: has changed since it was read")
    foreign = Foreign(fmu, *use)
    members = {"foreign": foreign, "__slots__": (), "__doc__": base.__doc__}
    cls = type("FMU", (base,), {**members, "__module__": f"fmu_{foreign.digest()}"})
    copyreg.pickle(cls, partial(reduce_fmu_block, (base, path, content, *use)))
    return cls


def reduce_fmu_block(use: tuple[Any, ...], block: Any) -> tuple[Any, ...]:
    """What pickle keeps of a block: how to make it again in another process."""
    return restore_fmu_block, (use, tuple(block))


def restore_fmu_block(use: tuple[Any, ...], values: tuple[Any, ...]) -> Any:
    """A block from its pickle; as with any pickle, load only what you trust."""
    return cached_block_class(*use)._make(values)
