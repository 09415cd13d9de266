"""To and from python-control, the control systems library."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import values
from hydroservo.core.errors import ParameterError, require
from hydroservo.linear.linearization import Linearization, Quantity
from hydroservo.linear.linearize import linearized, seen_of
from hydroservo.linear.operating_point import machine_point
from hydroservo.linear.parts import machine_rows
from hydroservo.runs.arguments import checked_loop

Vector = NDArray[np.float64]


def control_library() -> Any:
    """python-control."""
    require("control", "control", "this")
    import control

    return control


def to_statespace(model: Linearization) -> Any:
    """A linear model as a ``control.StateSpace``, with the names of its states, inputs and outputs.

    Dots in names become underscores there, for python-control keeps dots for signals of subsystems, and
    ``load.force`` becomes ``external_force``. What a machine gives and a controller takes has one name, so
    that ``control.interconnect`` finds the loop by itself. The time step is the sample period, or 0.

    Args:
        model: what :func:`~hydroservo.linearize` returned.

    Raises:
        ParameterError: it is something else.
        HydroservoError: python-control is not installed.
    """
    if not isinstance(model, Linearization):
        raise ParameterError("model", model, "must be what linearize returned")
    matrices = (model.A, model.B, model.C, model.D)
    own = {"name": model.unit, "remove_useless_states": False, **signal_names(model)}
    return control_library().ss(*matrices, model.period, **own)


def from_statespace(system: Any, unit: str = "loop") -> Linearization:
    """A ``control.StateSpace`` as a linear model, for its poles, gains and responses in the same words.

    Args:
        system: the system; its time step is a number.
        unit: what it is called.

    Raises:
        ParameterError: it is none, or its time step is not said.
        HydroservoError: python-control is not installed.
    """
    if not isinstance(system, control_library().StateSpace):
        raise ParameterError("system", system, "must be a control.StateSpace")
    if system.dt is None or system.dt is True:
        raise ParameterError("system", f"dt = {system.dt}", "must have a time step in seconds, or 0")
    states, inputs, outputs = (
        tuple(Quantity(name, "") for name in names)
        for names in (system.state_labels, system.input_labels, system.output_labels)
    )
    a, b, c, d = (np.asarray(one, dtype=np.float64) for one in (system.A, system.B, system.C, system.D))
    return Linearization(unit, states, inputs, outputs, a, b, c, d, float(system.dt))


def to_nlsys(loop: Loop, *, command: float | None = None, force: float | None = None) -> Any:
    """A loop's machine, not linearised, as a ``control.NonlinearIOSystem`` in continuous time.

    Its states, inputs and outputs are those of ``to_statespace(linearize(loop))``, in SI units. Its
    parameters
    ``state``, ``command`` and ``force`` are the point from which a simulation may start.

    Args:
        loop: the loop.
        command: u [V] of that point; None for that of a steady start, or 0.
        force: on the rod [N] there; None for that of the load at t = 0.

    Raises:
        ParameterError: there is no such point.
        HydroservoError: python-control is not installed.

    Source: the text of the loop's blocks, interpreted.
    Fails to be fast: a call of Python for each rate.
    """
    point = machine_point(checked_loop(loop), command, force)
    model = linearized(point, "machine")
    n, there = len(model.states), set(model.outputs)
    kept = [i for i, one in enumerate(seen_of(point)) if one in there]

    def rows(x: Vector, u: Vector) -> Vector:
        return np.array(machine_rows(point, [*x.tolist(), *np.asarray(u, dtype=np.float64).tolist()]))

    def rates(_t: float, x: Vector, u: Vector, _params: Any) -> Vector:
        return rows(x, u)[:n]

    def seen(_t: float, x: Vector, u: Vector, _params: Any) -> Vector:
        return rows(x, u)[n:][kept]

    return control_library().nlsys(
        rates,
        seen,
        **signal_names(model),
        params={"state": values(point.machine), "command": point.command, "force": point.force},
        name="machine",
    )


def signal_names(model: Linearization) -> dict[str, list[str]]:
    """States, inputs and outputs by names that python-control takes."""
    whats = ("states", "inputs", "outputs")
    return {what: [control_name(one.name) for one in getattr(model, what)] for what in whats}


def control_name(name: str) -> str:
    """A name that python-control takes: dots are its own."""
    return "external_force" if name == "load.force" else name.replace(".", "_")
