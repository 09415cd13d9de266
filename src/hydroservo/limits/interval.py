"""What a machine does in a sample period under a command, as a function that CasADi can differentiate."""

import traceback
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, is_block, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.states import filled
from hydroservo.limits.symbols import symbolic
from hydroservo.runs.steady import sized

STAGES = 3  # forces that a step of RK4 asks for: at its beginning, middle and end
NEAR = 1e-3  # of each state's size
EQUAL = 1e-9  # of a rate's largest value: what operations in another order may change

Vector = NDArray[np.float64]


class Interval(NamedTuple):
    """A sample period of a loop's machine, in units in which all numbers are about 1.

    A state is that of the machine, with the command of the sample before where that still acts or limits the
    next one. What is known of an interval are three forces for each step of the integrator, and then the
    demand at the beginning of each.

    Attributes:
        moved: function of state, command and what is known: the state after it, and the squared errors of
            its steps times their share of the run.
        scale: of each number of a state.
        command_scale: of the command [V].
        known: how many numbers are known of an interval.
    """

    moved: Any
    scale: Vector
    command_scale: float
    known: int


class Scales(NamedTuple):
    """What the numbers of a problem are measured by.

    Attributes:
        machine: of each of its states.
        command: [V].
        error: of the controlled signal.
    """

    machine: Vector
    command: float
    error: float


def interval(loop: Loop, scales: Scales, remembers: bool) -> Interval:
    """The sample period of a loop, with the steps of its integrator and as its monitors measure the error.

    Args:
        loop: the loop, ready to run, its substeps a number.
        scales: what its numbers are measured by.
        remembers: whether the command of the sample before is to be part of the state.
    """
    import casadi as ca

    simulation = loop.simulation
    steps, h = simulation.substeps, simulation.period / simulation.substeps
    like = loop.machine(loop.init())
    n = len(values(like))
    rates, output = machine_functions(loop)
    z, w = ca.SX.sym("z", n + remembers), ca.SX.sym("w")
    known = ca.SX.sym("known", (STAGES + 1) * steps)
    x, u = z[:n] * scales.machine, w * scales.command
    last = z[n] * scales.command if remembers else u
    squares = 0.0
    for i, share in enumerate(shares(loop)):
        held = u if share == 1.0 else share * u + (1.0 - share) * last
        start, middle, end = (known[STAGES * i + j] for j in range(STAGES))
        error = (output(x, u, start) - known[STAGES * steps + i]) / scales.error
        squares += error * error * (h / simulation.duration)
        k1 = rates(x, held, start)
        k2 = rates(x + 0.5 * h * k1, held, middle)
        k3 = rates(x + 0.5 * h * k2, held, middle)
        k4 = rates(x + h * k3, held, end)
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    after = ca.vertcat(x / scales.machine, w) if remembers else x / scales.machine
    moved = ca.Function("moved", [z, w, known], [after, squares], {"cse": True})
    scale = np.append(scales.machine, scales.command) if remembers else scales.machine
    return Interval(moved, scale, scales.command, known.numel())


def shares(loop: Loop) -> list[float]:
    """For each step of a sample period: 1 where the sample's own command is held, 0 where the last one is."""
    simulation, hold = loop.simulation, loop.hold
    t = simulation.period
    held = hold.held(hold.step(hold.init(), 0.0, t), 1.0)
    return [hold.at(held, t + i * t / simulation.substeps) for i in range(simulation.substeps)]


def machine_functions(loop: Loop) -> tuple[Any, Any]:
    """The machine's rates and the controlled signal, as CasADi's functions of state, command and force."""
    import casadi as ca

    like = loop.machine(loop.init())
    x, u, force = ca.SX.sym("x", len(values(like))), ca.SX.sym("u"), ca.SX.sym("force")
    try:
        twin = symbolic(loop)
        symbols: Any = iter(ca.vertsplit(x))
        state = filled(symbolic(like), symbols)
        rates = ca.vertcat(*values(twin.rates(state, u, force)))
        signal = twin.controls.of(twin.seen(state, force), u)
    except Exception as error:  # whatever CasADi, or a user's block, stumbles over
        raise untranslated(error) from None
    found = ca.Function("rates", [x, u, force], [rates]), ca.Function("signal", [x, u, force], [signal])
    check_rates(loop, like, found[0])
    return found


def untranslated(error: Exception) -> ParameterError:
    """What to say of a block whose text symbols cannot pass."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    blocks = [frame for frame in frames if is_block(frame.f_locals.get("self"))]
    methods = [frame.f_code.co_qualname for frame in blocks]
    where = methods[-1] if methods else "a method"
    first = str(error).splitlines()[0] if str(error) else type(error).__name__
    return ParameterError("machine", where, f"cannot be written with symbols, as a limit needs: {first}")


def check_rates(loop: Loop, like: Block, rates: Any) -> None:
    """Refuse expressions that do not compute what the machine's text does, near its start."""
    first, size = np.array(values(like)), np.array([one for _, one in sized(like)])
    trials = [(first + share * size, command) for share in (0.0, NEAR, -NEAR) for command in (1.0, -1.0)]
    ours = np.array([values(loop.rates(filled(like, iter(x.tolist())), u, 0.0)) for x, u in trials])
    theirs = np.array([np.array(rates(x, u, 0.0)).ravel() for x, u in trials])
    if not (np.abs(theirs - ours) <= EQUAL * np.abs(ours).max(axis=0)).all():
        problem = "has other rates when written with symbols"
        raise ParameterError("machine", type(loop.plant).__name__, problem)
