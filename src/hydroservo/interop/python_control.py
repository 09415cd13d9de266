"""To and from python-control, the control systems library."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo._version import __version__
from hydroservo.control import controlled
from hydroservo.control.controlled.this_signal import ThisSignal
from hydroservo.control.controllers import Saturation, state_space
from hydroservo.control.loop import Loop
from hydroservo.core.block import leaves, values
from hydroservo.core.errors import ParameterError, one_of, require
from hydroservo.linear.linearization import Linearization, Quantity
from hydroservo.linear.linearize import linearization_at, seen_quantities
from hydroservo.linear.operating_point import machine_point
from hydroservo.linear.system import machine_rows
from hydroservo.runs.arguments import checked_loop
from hydroservo.scenario.scenario_files import nest_changes

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

STATES = len(state_space.StateWeights._fields)
DEMANDS = {  # inputs of a law by their names in python-control
    "reference_value": "demand",
    "reference_rate": "demand_rate",
    "reference_second_rate": "demand_second_rate",
}
SIGNALS: dict[str, Any] = {
    "velocity": controlled.Velocity(),
    "hydraulic_force": controlled.HydraulicForce(),
    "position": controlled.Position(),
    "pressure_a": controlled.PressureA(),
    "pressure_b": controlled.PressureB(),
    "force": controlled.Force(),
    "applied_command": controlled.Command(),
}
PLACES = ("first", "second", "third")
SAME = 1e-9  # of a sample period


def control_library() -> Any:
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
    model = linearization_at(point, "machine")
    n, there = len(model.states), set(model.outputs)
    kept = [i for i, one in enumerate(seen_quantities(point)) if one in there]

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


def to_law(system: Any, loop: Loop, *, limit: float = 10.0) -> state_space.StateSpace:
    """A sampled linear law of python-control as a law that a loop runs, tunes and exports.

    Its inputs are told by their names: ``reference_value``, ``reference_rate``, ``reference_second_rate``,
    ``velocity``, ``hydraulic_force``, ``position``, ``pressure_a``, ``pressure_b``, ``force``,
    ``applied_command``, as :func:`~hydroservo.interop.to_statespace` has them, and ``controlled`` for what
    the loop controls. A single input of another name is the error, the demand less what is controlled. Its
    output is the command, with the sign that it has: a state feedback u = -K x has the gain -K::

        law = control.ss([], [], [], [[-k]], loop.simulation.period, inputs=["velocity", "hydraulic_force"])
        hs.simulate(hs.replace(loop, {"controller": to_law(law, loop)}))

    Args:
        system: a ``control.StateSpace`` or ``control.TransferFunction`` of one output, with at most eight
            states and three measured inputs, sampled as the loop is.
        loop: the loop for which it is.
        limit: largest command [V].

    Raises:
        ParameterError: it is none of these, or a number of it is not finite.
        HydroservoError: python-control is not installed.
    """
    loop = checked_loop(loop)
    if not limit > 0.0:
        raise ParameterError("limit", limit, "must be above 0 V")
    system = check_system(system, loop.simulation.period)
    a, b, c, d = (np.asarray(one, dtype=np.float64) for one in (system.A, system.B, system.C, system.D))
    names = [str(name) for name in system.input_labels]
    signals = SIGNALS | {"controlled": loop.controls}
    known = [*DEMANDS, *signals]
    if len(names) == 1 and names[0] not in known:
        names, b, d = ["reference_value", "controlled"], np.hstack([b, -b]), np.hstack([d, -d])
    wrong = [name for name in names if name not in known]
    if wrong:
        raise ParameterError("system", wrong[0], f"is not an input of a law; it {one_of(wrong[0], known)}")
    measured = [i for i, name in enumerate(names) if name in signals]
    if len(measured) > len(PLACES):
        asked = ", ".join(names[i] for i in measured)
        raise ParameterError("system", asked, f"are {len(measured)} measured signals; at most 3 are allowed")
    parts: dict[str, Any] = {
        DEMANDS[name]: state_space.Weights(state_weights(b[:, i]), float(d[0, i]))
        for i, name in enumerate(names)
        if name in DEMANDS
    }
    for place, i in zip(PLACES, measured, strict=False):
        parts[place] = state_space.MeasuredInput(signals[names[i]], state_weights(b[:, i]), float(d[0, i]))
    rows = state_space.StateWeightsOfEach(*map(state_weights, a))
    return state_space.StateSpace(rows, state_weights(c[0]), **parts, saturation=Saturation(limit))


def to_scenario(law: state_space.StateSpace, base: str) -> str:
    """The text of a scenario that builds on another one, with a law in place of that one's.

    Args:
        law: what :func:`to_law` made.
        base: the other scenario: a built-in one's name, or a path as seen from where the text will stand.

    Raises:
        ParameterError: the law is none.
    """
    import tomli_w

    if not isinstance(law, state_space.StateSpace):
        raise ParameterError("law", law, "must be what to_law returned")
    signals = {place: getattr(law, place).signal for place in PLACES}
    types = {
        f"{place}.signal.type": type(signal).__name__
        for place, signal in signals.items()
        if not isinstance(signal, ThisSignal)
    }
    numbers = {path: value for path, value in leaves(law) if value != 0.0}
    table = nest_changes({"type": type(law).__name__, **types, **numbers})
    said = f"# A law of python-control, written by hydroservo {__version__}; SI units."
    return f"{said}\n{tomli_w.dumps({'base': base, 'controller': table})}"


def check_system(system: Any, period: float) -> Any:
    """A law in state space that a loop with this sample period can run."""
    control = control_library()
    if isinstance(system, control.TransferFunction):
        system = control.ss(system)
    if not isinstance(system, control.StateSpace):
        raise ParameterError("system", system, "must be a control.StateSpace or a control.TransferFunction")
    if system.dt is None or system.dt is True or not abs(system.dt - period) <= SAME * period:
        problem = f"must be sampled as the loop is, every {period:g} s; use control.sample_system"
        raise ParameterError("system", f"dt = {system.dt}", problem)
    if system.noutputs != 1:
        raise ParameterError("system", f"{system.noutputs} outputs", "must have one output, the command")
    if system.nstates > STATES:
        problem = f"must have at most {STATES}; use control.balred"
        raise ParameterError("system", f"{system.nstates} states", problem)
    if not all(np.isfinite(one).all() for one in (system.A, system.B, system.C, system.D)):
        raise ParameterError("system", "A, B, C, D", "must be finite numbers")
    return system


def state_weights(numbers: Matrix) -> state_space.StateWeights:
    """Of up to eight states."""
    return state_space.StateWeights(*numbers.tolist())
