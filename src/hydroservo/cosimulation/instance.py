"""One instance of an FMU, from its initialization on."""

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from math import prod
from pathlib import Path
from threading import Lock
from typing import Any, TypeVar

from hydroservo.core.errors import LoopError
from hydroservo.cosimulation.fmu import FmuVariable, Foreign, Parameter, Wire, unpacked_folder

LOADING = Lock()  # FMPy changes the process's folder while it loads a library
FMI2_SETTERS = {
    "Real": "setReal",
    "Integer": "setInteger",
    "Enumeration": "setInteger",
    "Boolean": "setBoolean",
    "String": "setString",
}
STATUS = dict(enumerate(("ok", "warning", "discard", "error", "fatal", "pending")))
Answer = TypeVar("Answer")
running: set[str] = set()  # digests of the FMUs that have an instance in this process


class Instance:
    """An FMU that takes inputs, steps and answers. Close it, or use it in a ``with``.

    It starts with inputs at t = 0 by signal, in SI units; errors call it by its role in the loop.
    """

    def __init__(self, foreign: Foreign, role: str, start: Mapping[str, float]) -> None:
        self.foreign, self.role, self.said = foreign, role, ""
        self.time, self.fatal = 0.0, False
        self.named = foreign.fmu.variables
        self.given = dict(foreign.parameters)
        self.slave: Any = None
        if foreign.fmu.single and foreign.fmu.digest in running:
            raise self.error("can have one instance in a process, and has one already")
        running.add(foreign.fmu.digest)
        try:
            with LOADING:
                self.load()
            self.initialize(start)
        except LoopError:
            self.close()
            raise
        except Exception as error:  # FMPy raises plain ones
            problem = self.refused("cannot start", error)
            self.close()
            raise problem from None

    def __enter__(self) -> "Instance":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the instance, but one that is lost for good, of which FMI allows no call any more."""
        slave, self.slave = self.slave, None
        running.discard(self.foreign.fmu.digest)
        if slave is not None and slave.component is not None and not self.fatal:
            slave.freeInstance()

    def load(self) -> None:
        """Load the library, and make an instance that is not initialized yet."""
        from fmpy import calloc, fmi2, fmi3, free

        fmu, before = self.foreign.fmu, Path.cwd()
        folder = unpacked_folder(fmu.path, fmu.digest)
        kind = fmi2.FMU2Slave if fmu.version == 2 else fmi3.FMU3Slave
        try:
            self.slave = kind(
                guid=fmu.token,
                unzipDirectory=str(folder),
                modelIdentifier=fmu.identifier,
                instanceName=f"hydroservo_{self.role}",
                libraryPath=str(folder / fmu.binary),
            )
        finally:
            os.chdir(before)
        if fmu.version == 2:
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda *said: self.hear(said[-1]))
            callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
            callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
            self.slave.instantiate(callbacks=callbacks)
        else:
            self.slave.instantiate(logMessage=lambda *said: self.hear(said[-1]))

    def hear(self, text: bytes | None) -> None:
        """Keep the last message."""
        self.said = (text or b"").decode(errors="replace").strip()

    def initialize(self, start: Mapping[str, float]) -> None:
        """Parameters, then inputs, then the step mode."""
        slave = self.slave
        sizes = [name for name in self.given if self.named[name].causality == "structuralParameter"]
        if sizes:
            slave.enterConfigurationMode()
            self.set_parameters(sizes)
            slave.exitConfigurationMode()
        self.set_parameters(name for name in self.given if name not in sizes)
        if self.foreign.fmu.version == 2:
            slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        self.arrays = {name: self.values(self.named[name]) for name in self.names(self.foreign.inputs)}
        self.put(start)
        slave.exitInitializationMode()

    def set_parameters(self, names: Iterable[str]) -> None:
        for name in names:
            variable, values = self.named[name], list(self.given[name])
            self.check_size(variable, values)
            if self.foreign.fmu.version == 2:
                setter = FMI2_SETTERS[variable.kind]
            else:
                setter = "setInt64" if variable.kind == "Enumeration" else f"set{variable.kind}"
            getattr(self.slave, setter)([variable.reference], values)

    def check_size(self, variable: FmuVariable, values: Parameter | list[Any]) -> None:
        """Refuse too few or too many values for an array."""
        size = self.size(variable)
        if len(values) != size:
            raise self.error(f"takes {size} numbers for {variable.name}, and {len(values)} are given")

    def size(self, variable: FmuVariable) -> int:
        """How many numbers a variable holds, with the sizes that are given."""
        whole = (one for one in self.named.values() if one.kind.startswith(("UInt", "Int")))
        by_reference = {one.reference: one for one in whole}

        def length(size: int) -> int:
            if size >= 0:
                return size
            name = by_reference[-1 - size].name
            return int(self.given[name][0]) if name in self.given else by_reference[-1 - size].start

        return prod(map(length, variable.sizes))

    @staticmethod
    def names(wires: tuple[Wire, ...]) -> list[str]:
        return list(dict.fromkeys(wire.variable for wire in wires))

    def values(self, variable: FmuVariable) -> list[float]:
        """The numbers of a variable."""
        reference = [variable.reference]
        if self.foreign.fmu.version == 2:
            return list(self.slave.getReal(reference))
        get = self.slave.getFloat32 if variable.kind == "Float32" else self.slave.getFloat64
        return list(get(reference, nValues=self.size(variable)))

    def put(self, signals: Mapping[str, float]) -> None:
        """Give the FMU its inputs, in SI units by signal."""
        for wire in self.foreign.inputs:
            array = self.arrays[wire.variable]
            self.check_element(wire, array)
            array[wire.element] = signals[wire.signal] / wire.factor
        for name, array in self.arrays.items():
            variable = self.named[name]
            if self.foreign.fmu.version == 2:
                self.slave.setReal([variable.reference], array)
            else:
                set_ = self.slave.setFloat32 if variable.kind == "Float32" else self.slave.setFloat64
                set_([variable.reference], array)

    def give(self, signals: Mapping[str, float]) -> None:
        """Give inputs, in SI units by signal."""
        self.called(partial(self.put, signals))

    def outputs(self) -> dict[str, float]:
        """What the FMU answers, in SI units by signal."""
        return self.called(self.read)

    def called(self, call: Callable[[], Answer]) -> Answer:
        """What a call of the FMU returns."""
        try:
            return call()
        except LoopError:
            raise
        except Exception as error:  # FMPy's, or of the library
            raise self.refused("stopped", error) from None

    def exchange(self, signals: Mapping[str, float]) -> dict[str, float]:
        """Give inputs and take what the FMU answers to them, in SI units by signal."""
        self.give(signals)
        return self.outputs()

    def read(self) -> dict[str, float]:
        """The outputs, in SI units by signal."""
        found = {name: self.values(self.named[name]) for name in self.names(self.foreign.outputs)}
        for wire in self.foreign.outputs:
            self.check_element(wire, found[wire.variable])
        wires = self.foreign.outputs
        return {wire.signal: found[wire.variable][wire.element] * wire.factor for wire in wires}

    def check_element(self, wire: Wire, array: list[float]) -> None:
        """Refuse a wire to an element beyond an array's end."""
        if wire.element >= len(array):
            asked = f"{wire.variable}[{wire.element + 1}]"
            raise self.error(f"has no {asked}: there are {len(array)} numbers in {wire.variable}")

    def step(self, time: float, size: float) -> None:
        """One communication step of a size [s], from a time [s]."""
        self.time = time
        answer = self.called(partial(self.slave.doStep, time, size))
        if answer is not None and (answer[1] or answer[2]):
            why = "asks to end the simulation" if answer[1] else "returns before the step's end"
            raise self.error(f"stopped at t = {self.time:.9g} s: it {why}")

    def refused(self, what: str, error: Exception) -> LoopError:
        """An error of a call, with the FMU's last message."""
        from fmpy.fmi1 import FMICallException

        cause = str(error)
        if isinstance(error, FMICallException):
            cause = f"{error.function} returns {STATUS.get(error.status, error.status)}"
            self.fatal = STATUS.get(error.status) == "fatal"
        said = f", and says: {self.said}" if self.said else ""
        when = f" at t = {self.time:.9g} s" if what == "stopped" else ""
        return self.error(f"{what}{when}: {cause}{said}")

    def error(self, problem: str) -> LoopError:
        return LoopError(f"the {self.role}'s FMU {self.foreign.name} {problem}")
