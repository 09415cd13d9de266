"""The optimal control of a machine: a sample period as CasADi's expression, and the problem of many."""

import math
import traceback
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.block import Block, is_block, values
from hydroservo.core.errors import HydroservoError, ParameterError
from hydroservo.core.states import filled
from hydroservo.core.twins import Twins
from hydroservo.limits.command import CommandLimits
from hydroservo.runs.steady import state_sizes

LEAST_ROOT = 1e-30  # below it a root is 0, and its slope too, which is infinite there
STAGES = 3  # forces that a step of RK4 asks for: at its beginning, middle and end
NEAR = 1e-3  # of each state's size
EQUAL = 1e-9  # of a rate's largest value: what operations in another order may change
TOLERANCE = 1e-9  # of the optimality conditions, with squared errors in units of the law's
KINKED, STILL = 1e-2, 1e-7  # what is left of them at a kink, where the squares change no more than this
ITERATIONS = 200

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]


def symbolic(block: Block) -> Any:
    """A block equal to another one, whose methods take CasADi's symbols.

    Where the block's text chooses, both sides are computed and one is taken; at a corner the slope is that of
    one side, and that of a root at 0 is 0.

    Fails where a method asks of a number what is asked of no symbol, as ``if`` does: with CasADi's or
    Python's own error.
    """
    return Twins(symbolic_ops(), lambda value: value if is_symbol(value) else float(value)).of(block)


def symbolic_ops() -> SimpleNamespace:
    """The functions of :mod:`hydroservo.core.ops` by name, for symbols; none that draws numbers."""
    import casadi as ca

    def where(condition: Any, a: Any, b: Any) -> Any:
        return ca.if_else(condition, a, b) if is_symbol(condition) else (a if condition else b)

    def sqrt(x: Any) -> Any:
        there = x > LEAST_ROOT
        return where(there, ca.sqrt(where(there, x, 1.0)), 0.0)

    def sign(x: Any) -> Any:
        return where(x > 0.0, 1.0, where(x < 0.0, -1.0, 0.0))

    def power(x: Any, y: Any) -> Any:
        if not is_symbol(x) and x == math.e:
            return ca.exp(y)
        there = x > LEAST_ROOT
        return where(there, where(there, x, 1.0) ** y, 0.0)

    def clip(x: Any, low: Any, high: Any) -> Any:
        return where(x < low, low, where(x > high, high, x))

    def copysign(magnitude: Any, x: Any) -> Any:
        return where(x < 0.0, -1.0, 1.0) * ca.fabs(magnitude)

    def smooth_root(x: Any, transition: Any) -> Any:
        return x / ca.sqrt(ca.sqrt(x * x + transition * transition))

    return SimpleNamespace(
        where=where,
        sqrt=sqrt,
        sign=sign,
        power=power,
        clip=clip,
        copysign=copysign,
        smooth_root=smooth_root,
        signed_power=lambda x, y: copysign(power(ca.fabs(x), y), x),
        absolute=ca.fabs,
        minimum=lambda a, b: where(a < b, a, b),
        maximum=lambda a, b: where(a > b, a, b),
        sin=ca.sin,
        cos=ca.cos,
        tanh=ca.tanh,
        floor=ca.floor,
    )


def is_symbol(value: Any) -> bool:
    """Whether a value is an expression of CasADi's."""
    import casadi as ca

    return isinstance(value, ca.SX)


class PeriodModel(NamedTuple):
    """A sample period of a loop's machine, in units in which all numbers are about 1.

    A state is that of the machine, with the command of the sample before where that still acts or limits the
    next one. What is known of an interval are three forces for each step of the integrator, and then the
    demand at the beginning of each.
    """

    # function of state, command and what is known: the state after it, and the squared errors of its steps
    # times their share of the run
    moved: Any
    scale: Vector  # of each number of a state
    command_scale: float  # of the command [V]
    known: int  # how many numbers are known of an interval


class ProblemScales(NamedTuple):
    """What the numbers of a problem are measured by."""

    machine: Vector  # of each of its states
    command: float  # [V]
    error: float  # of the controlled signal


def period_model(loop: Loop, scales: ProblemScales, remembers: bool) -> PeriodModel:
    """The sample period of a loop, with the steps of its integrator and as its monitors measure the error."""
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
    for i, share in enumerate(own_command_shares(loop)):
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
    return PeriodModel(moved, scale, scales.command, known.numel())


def own_command_shares(loop: Loop) -> list[float]:
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
    first, size = np.array(values(like)), np.array([one for _, one in state_sizes(like)])
    trials = [(first + share * size, command) for share in (0.0, NEAR, -NEAR) for command in (1.0, -1.0)]
    ours = np.array([values(loop.rates(filled(like, iter(x.tolist())), u, 0.0)) for x, u in trials])
    theirs = np.array([np.array(rates(x, u, 0.0)).ravel() for x, u in trials])
    if not (np.abs(theirs - ours) <= EQUAL * np.abs(ours).max(axis=0)).all():
        problem = "has other rates when written with symbols"
        raise ParameterError("machine", type(loop.plant).__name__, problem)


class Course(NamedTuple):
    """How a machine goes through some samples, in the units of its interval."""

    states: Matrix  # at each sample and at the end, shape (states, samples + 1)
    commands: Vector  # shape (samples,)

    def part(self, first: int, last: int) -> "Course":
        """Samples first to last - 1."""
        return Course(self.states[:, first : last + 1], self.commands[first:last])


class Optimum(NamedTuple):
    """What a search ended with."""

    course: Course  # the best that it found
    squares: float  # the sum of squared errors, each with its share of the run
    iterations: int  # of the solver
    # whether the conditions of a local optimum hold there, or, at a kink of the machine, nothing gets better
    # any more
    converged: bool


def optimum(one: PeriodModel, limits: CommandLimits, known: Matrix, guess: Course, threads: int) -> Optimum:
    """The commands with the least squared error over some samples, from a given state.

    With x_k the state at a sample, u_k its command and p_k what is known of the interval after it::

        minimise sum of l(x_k, u_k, p_k)  subject to  x_(k+1) = f(x_k, u_k, p_k),  |u_k| <= limit

    and |u_k - u_(k-1)| <= rate h where the command's rate is limited. All x_k and u_k are unknown; an
    interior-point method with exact second derivatives finds them together.

    What is known of each interval has shape (numbers, samples). The machine begins in the first state of the
    guess.

    Source: Bock and Plitt, IFAC World Congress, 1984 (multiple shooting); Wachter and Biegler, Mathematical
    Programming 106, 2006 (IPOPT); Andersson et al., Mathematical Programming Computation 11, 2019 (CasADi).
    Fails to tell a local optimum from the least one of all.
    """
    n, samples = len(one.scale), guess.commands.size
    low, high = np.full((n + 1) * samples + n, -np.inf), np.full((n + 1) * samples + n, np.inf)
    low[:n] = high[:n] = guess.states[:, 0]
    bound = limits.limit / one.command_scale
    low[n :: n + 1], high[n :: n + 1] = -bound, bound
    step = [limits.rate * limits.period / one.command_scale] if limits.rated else []
    most = np.tile([0.0] * n + step, samples)
    solver = solver_of(one, limits, samples, threads)
    found = solver(x0=course_vector(guess), p=known.ravel(order="F"), lbx=low, ubx=high, lbg=-most, ubg=most)
    z, said = np.array(found["x"]).ravel(), solver.stats()
    if not np.isfinite(z).all():
        raise HydroservoError(f"the search for the limit failed: {said['return_status']}")
    body = z[: (n + 1) * samples].reshape(samples, n + 1)
    states = np.column_stack([body[:, :n].T, z[(n + 1) * samples :]])
    course = Course(states, np.clip(body[:, n], -bound, bound))
    return Optimum(course, float(found["f"]), int(said["iter_count"]), bool(said["success"]))


def course_vector(course: Course) -> Vector:
    """x_0, u_0, x_1, u_1, ..., x_N."""
    pairs = np.vstack([course.states[:, :-1], course.commands]).T
    return np.concatenate([pairs.ravel(), course.states[:, -1]])


def solver_of(one: PeriodModel, limits: CommandLimits, samples: int, threads: int) -> Any:
    """CasADi's function that solves the problem."""
    import casadi as ca

    n = len(one.scale)
    z, known = ca.MX.sym("z", (n + 1) * samples + n), ca.MX.sym("known", one.known, samples)
    body = ca.reshape(z[: (n + 1) * samples], n + 1, samples)
    states, commands = body[:n, :], body[n, :]
    every = one.moved.map(samples, "thread", min(threads, samples))
    reached, squares = every(states, commands, known)
    gaps = ca.horzcat(body[:n, 1:], z[(n + 1) * samples :]) - reached
    rows = ca.vertcat(gaps, commands - states[n - 1, :]) if limits.rated else gaps
    problem = {"x": z, "p": ca.vec(known), "f": ca.sum2(squares), "g": ca.vec(rows)}
    own: dict[str, Any] = {"tol": TOLERANCE, "max_iter": ITERATIONS, "mu_init": 1e-2}
    own |= {"acceptable_tol": KINKED, "acceptable_obj_change_tol": STILL, "acceptable_iter": 5}
    own |= {"bound_relax_factor": 0.0, "print_level": 0, "sb": "yes"}
    unasked = dict.fromkeys(("print_time", "calc_lam_p", "calc_lam_x", "calc_f", "calc_g"), False)
    return ca.nlpsol("limit", "ipopt", problem, {"ipopt": own, "no_nlp_grad": True, **unasked})
