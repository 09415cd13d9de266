"""The optimal control of a machine over some samples: one sparse problem, its states unknown too."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.core.errors import HydroservoError
from hydroservo.limits.command import CommandLimits
from hydroservo.limits.interval import Interval

TOLERANCE = 1e-9  # of the optimality conditions, with squared errors in units of the law's
KINKED, STILL = 1e-2, 1e-7  # what is left of them at a kink, where the squares change no more than this
ITERATIONS = 200

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]


class Course(NamedTuple):
    """How a machine goes through some samples, in the units of its interval.

    Attributes:
        states: at each sample and at the end, shape (states, samples + 1).
        commands: shape (samples,).
    """

    states: Matrix
    commands: Vector

    def part(self, first: int, last: int) -> "Course":
        """Samples first to last - 1."""
        return Course(self.states[:, first : last + 1], self.commands[first:last])


class Optimum(NamedTuple):
    """What a search ended with.

    Attributes:
        course: the best that it found.
        squares: the sum of squared errors, each with its share of the run.
        iterations: of the solver.
        converged: whether the conditions of a local optimum hold there, or, at a kink of the machine, nothing
            gets better any more.
    """

    course: Course
    squares: float
    iterations: int
    converged: bool


def optimum(one: Interval, limits: CommandLimits, known: Matrix, guess: Course, threads: int) -> Optimum:
    """The commands with the least squared error over some samples, from a given state.

    With x_k the state at a sample, u_k its command and p_k what is known of the interval after it::

        minimise sum of l(x_k, u_k, p_k)  subject to  x_(k+1) = f(x_k, u_k, p_k),  |u_k| <= limit

    and |u_k - u_(k-1)| <= rate h where the command's rate is limited. All x_k and u_k are unknown; an
    interior-point method with exact second derivatives finds them together.

    Args:
        one: a sample period of the machine.
        limits: of the command.
        known: what is known of each interval, shape (numbers, samples).
        guess: where the search begins; the machine begins in its first state.
        threads: on which the samples are computed.

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
    found = solver(x0=flat(guess), p=known.ravel(order="F"), lbx=low, ubx=high, lbg=-most, ubg=most)
    z, said = np.array(found["x"]).ravel(), solver.stats()
    if not np.isfinite(z).all():
        raise HydroservoError(f"the search for the limit failed: {said['return_status']}")
    body = z[: (n + 1) * samples].reshape(samples, n + 1)
    states = np.column_stack([body[:, :n].T, z[(n + 1) * samples :]])
    course = Course(states, np.clip(body[:, n], -bound, bound))
    return Optimum(course, float(found["f"]), int(said["iter_count"]), bool(said["success"]))


def flat(course: Course) -> Vector:
    """x_0, u_0, x_1, u_1, ..., x_N."""
    pairs = np.vstack([course.states[:, :-1], course.commands]).T
    return np.concatenate([pairs.ravel(), course.states[:, -1]])


def solver_of(one: Interval, limits: CommandLimits, samples: int, threads: int) -> Any:
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
