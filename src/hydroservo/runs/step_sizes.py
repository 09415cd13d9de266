"""Whether the steps of a run are short enough: from the machine's fastest motion, and by halving them."""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hydroservo.control.loop import AUTO, Loop
from hydroservo.core import ops
from hydroservo.core.block import leaves, replace, values
from hydroservo.core.errors import ParameterError
from hydroservo.machine.integrators.jumps import AFTER, BEFORE
from hydroservo.runs.evaluation import FIRST, Rates, machine_rates

COMMAND = "controller.u"
INSTANTS = 8  # of a run at which the machine is linearised, spread evenly
NUDGE = 1e-6  # of a state's largest value, for its finite difference
PEAK = 10.0  # times the median rate: what is faster than that at some instants is left to doubling
TRUSTED = 1e-3  # largest relative difference to a run with steps half as long
MOST_JUMPS = 1000  # of a load that are looked at
MOST_PARTS = 100  # of a sample period, for a delayed command
DOUBLINGS = 8  # of the first number of substeps
STALLS = 2  # doublings in a row that did not halve the difference: nothing settles any more
STILL = 1e-12  # of a state, in SI units: one that never has more stands still, and what it has is rounding

Numbers = NDArray[np.float64]


class RecordedSignals(Protocol):
    """What a run recorded, as far as its steps are judged by it; a Dataset is such."""

    def __getitem__(self, path: str, /) -> ArrayLike: ...

    def assign_attrs(self, **attrs: Any) -> Self: ...


RecordedRun = TypeVar("RecordedRun", bound=RecordedSignals)
StepRun = Callable[[Loop], RecordedRun]


def machine_paths(loop: Loop) -> tuple[str, ...]:
    """What must be recorded of a run for its steps to be judged: the machine's states and the command."""
    return (*(path for path, _ in leaves(loop.machine(loop.init()))), COMMAND)


def fastest_rate(loop: Loop, data: RecordedSignals | None = None) -> float:
    """The largest |lambda| [1/s] of the machine's Jacobian along a run, as :func:`fastest_rates` has them."""
    return float(fastest_rates(loop, data).max(initial=0.0))


def fastest_rates(loop: Loop, data: RecordedSignals | None = None) -> NDArray[np.float64]:
    """The largest |lambda| [1/s] of the eigenvalues of the machine's Jacobian, at some instants of a run.

    The machine is linearised by central differences with the command held, at instants spread evenly over
    the run and where each state and the command are largest. An orifice near a vanishing drop, or a jump in
    a device's law, shows as a very large value.

    Returns:
        One rate for each instant at which the Jacobian is finite.
    """
    start = loop.machine(loop.init())
    times, states, commands = (
        trajectory(loop, data) if data is not None else (np.zeros(1), np.array([values(start)]), np.zeros(1))
    )
    if not states.size:
        return np.zeros(0)
    largest = np.abs(states).max(axis=0)
    nudges = NUDGE * np.where(largest > 0.0, largest, 1.0)
    rows = sorted({*even_rows(len(times)), *np.abs(states).argmax(axis=0), np.abs(commands).argmax()})
    move = machine_rates([loop], start)

    def at(row: int) -> Numbers:
        return jacobian(move, states[row], float(commands[row]), loop.load.force(float(times[row])), nudges)

    found = [at(row) for row in rows]
    finite = np.array([one for one in found if np.isfinite(one).all()])
    return np.abs(np.linalg.eigvals(finite)).max(axis=1) if finite.size else np.zeros(0)


def trajectory(loop: Loop, data: RecordedSignals) -> tuple[Numbers, Numbers, Numbers]:
    """The instants, states and commands of a run, as far as they are finite."""
    *paths, command = (np.asarray(data[path]) for path in machine_paths(loop))
    states = np.stack(paths, axis=1)
    there = np.isfinite(states).all(axis=1) & np.isfinite(command)
    return np.asarray(data["time"])[there], states[there], command[there]


def even_rows(count: int) -> list[int]:
    """At most INSTANTS numbers of rows, the first and the last among them."""
    return [int(row) for row in np.linspace(0, count - 1, min(count, INSTANTS)).round()]


def jacobian(move: Rates, x: Numbers, u: float, force: float, nudges: Numbers) -> Numbers:
    """d(rates)/d(states), in units of the states' nudges [1/s]; not finite where there is none."""
    steps = np.diag(nudges)
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is left out afterwards
        around = np.concatenate([x + steps, x - steps])[np.newaxis]
        after, before = np.split(move(around, np.array([[u, force]]), FIRST)[0], 2)
        return np.asarray(0.5 * (after - before).T / nudges[:, np.newaxis])


def coarseness(loop: Loop, data: RecordedSignals | None = None) -> str:
    """That a machine moves too fast for its steps, in one line; empty if it does not.

    It does if it somewhere moves faster than the integrator's ``trusted_rate``; one that has no such rate
    never says so.
    """
    simulation = loop.simulation
    integrator, period, substeps = simulation.integrator, simulation.period, simulation.substeps
    rate, trusted = fastest_rate(loop, data), integrator.trusted_rate(period, substeps)
    if rate <= trusted:
        return ""
    more = integrator.substeps_for(rate, period, simulation.tolerance) > substeps
    advice = 'simulation.substeps = "auto" finds how many' if more else "shorten simulation.period"
    return (
        f"the steps are too coarse to be trusted: the machine moves at up to {rate:.3g} 1/s, and "
        f"{type(integrator).__name__} with {substeps} substep{'s' * (substeps != 1)} in {period:g} s follows "
        f"up to {trusted:.3g} 1/s; {advice}"
    )


def checked_steps(loop: Loop, run: StepRun[RecordedRun]) -> RecordedRun:
    """A run of a loop whose steps are chosen, if they are to be, and judged.

    Args:
        loop: the loop.
        run: simulates a loop whose substeps are a number; its result has the paths of :func:`machine_paths`.

    Returns:
        The run. Where substeps were chosen it has the attributes of :func:`settle_substeps`; where its steps
        are not to be trusted, an attribute ``warning`` says why in one line, as ``step_doubt`` has it.
    """
    if loop.simulation.substeps == AUTO:
        return settle_substeps(loop, run)
    data = run(loop)
    said = step_doubt(loop, data, run)
    return data.assign_attrs(warning=said) if said else data


def step_doubt(loop: Loop, data: RecordedRun, run: StepRun[RecordedRun]) -> str:
    """Why a run's steps are too coarse to be trusted, in one line; empty if they are not.

    Steps are suspect where the machine moves faster than the integrator is trusted to follow, where that says
    nothing, and where the load jumps inside one of them. A second run with steps half as long then decides. A
    machine that moves too fast needs none where the run is lost, or where the integrator chooses its steps
    and has no shortest one.
    """
    fast, jump, integrator = coarseness(loop, data), first_jump_inside(loop), loop.simulation.integrator
    lost = not np.isfinite(np.asarray(data[COMMAND])).all()
    halves = hasattr(integrator, "most_steps") or not hasattr(integrator, "attempt")
    if fast and (lost or not halves):
        return fast
    if judged_by_rate(loop) and not fast and jump == math.inf:
        return ""
    error = largest_difference(loop, data, run(with_half_steps(loop)))
    return "" if error <= TRUSTED else fast or halving_text(loop, error, jump)


def with_half_steps(loop: Loop) -> Loop:
    """The loop with steps half as long; the shortest ones, where the integrator chooses them."""
    simulation = loop.simulation
    if not hasattr(simulation.integrator, "most_steps"):
        return with_substeps(loop, 2 * simulation.substeps)
    changed: Loop = replace(loop, {"simulation.integrator.most_steps": 2 * simulation.integrator.most_steps})
    return changed


def judged_by_rate(loop: Loop) -> bool:
    """True where the machine's fastest motion says whether the steps are short enough."""
    simulation = loop.simulation
    return math.isfinite(simulation.integrator.trusted_rate(simulation.period, simulation.substeps))


def first_jump_inside(loop: Loop) -> float:
    """The first instant at which the load jumps and no step ends [s]; inf if there is none.

    Of a load that jumps very often the first jumps alone are looked at.
    """
    simulation, load, jump = loop.simulation, loop.load, 0.0
    if hasattr(simulation.integrator, "attempt"):  # which ends a step on each
        return math.inf
    step = simulation.period / simulation.substeps
    for _ in range(MOST_JUMPS):
        jump = load.next_jump(jump)
        if jump >= simulation.duration:
            break
        steps = jump / step
        jumps = load.force(BEFORE * jump) != load.force(AFTER * jump)  # and not its slope alone
        if jumps and abs(steps - round(steps)) > 1e-9 * max(steps, 1.0):
            return float(jump)
    return math.inf


def halving_text(loop: Loop, error: float, jump: float) -> str:
    """That steps half as long change a run by an error; why, where the load jumps inside a step."""
    substeps = loop.simulation.substeps
    advice = 'simulation.substeps = "auto" finds how many' if jump == math.inf else jump_text(jump)
    return (
        f"the steps are too coarse to be trusted: {substeps} substep{'s' * (substeps != 1)} in a sample "
        f"period and twice as many differ by {error:.1e} of the machine's largest values; {advice}"
    )


def settle_substeps(loop: Loop, run: StepRun[RecordedRun]) -> RecordedRun:
    """A run with as many substeps as the machine needs.

    The fastest eigenvalue, at the start and then along a run (but no more than ten times the median there),
    says how many substeps the integrator takes to meet ``simulation.tolerance``. The run with twice as many
    then says how much they miss, as :func:`largest_difference` has it, and substeps are doubled until that is
    within the tolerance. What does not settle (a law that switches at every sample amplifies rounding; a load
    jumps inside substeps) is given up once the difference was not halved twice in a row, or after eight
    doublings; the run that missed least is returned.

    Returns:
        The run, with the attributes ``substeps`` (what was chosen), ``step_error`` (the difference measured),
        and ``warning`` where it did not settle.
    """
    tolerance = loop.simulation.tolerance
    substeps = needed_substeps(loop, fastest_rates(loop))
    data = run(with_substeps(loop, substeps))
    more = needed_substeps(loop, fastest_rates(loop, data))
    if more > substeps:
        substeps, data = more, run(with_substeps(loop, more))
    least, chosen, best, stalls = math.inf, substeps, data, -1
    for _ in range(DOUBLINGS):
        finer = run(with_substeps(loop, 2 * substeps))
        error = largest_difference(loop, data, finer)
        stalls = 0 if error < 0.5 * least else stalls + 1
        if error < least:
            least, chosen, best = error, substeps, data
        if least <= tolerance or stalls == STALLS:
            break
        substeps, data = 2 * substeps, finer
    said = {} if least <= tolerance else {"warning": unsettled_text(with_substeps(loop, chosen), least)}
    return best.assign_attrs(substeps=chosen, step_error=least, **said)


def needed_substeps(loop: Loop, found: NDArray[np.float64]) -> int:
    """How many substeps a machine of these rates takes."""
    simulation = loop.simulation
    rate = min(float(found.max()), PEAK * float(np.median(found))) if found.size else 0.0
    substeps = int(simulation.integrator.substeps_for(rate, simulation.period, simulation.tolerance))
    parts = command_parts(loop)
    return -(-substeps // parts) * parts


def command_parts(loop: Loop) -> int:
    """How many equal parts a sample period must have for a delayed command to come between two of them.

    1 for an integrator that chooses its steps, which ends one where the command comes.
    """
    delay, period = getattr(loop.hold, "delay", 0.0), loop.simulation.period
    if delay > (1.0 + 1e-9) * period:
        raise ParameterError("hold.delay", delay, f"must be at most the sample period of {period:g} s")
    if not hasattr(loop.simulation.integrator, "substep"):
        return 1
    share = Fraction(delay / period).limit_denominator(MOST_PARTS)
    if abs(share - delay / period) > 1e-9:
        wanted = f"must be k/n of the period of {period:g} s, n to {MOST_PARTS}"
        raise ParameterError("hold.delay", delay, wanted)
    return share.denominator


def with_exact_delay(loop: Loop) -> Loop:
    """The loop, a delayed command's share of a period exact: "0.3333333333 ms" of 1 ms is a third.

    An integrator that chooses its steps ends one wherever the command comes.
    """
    delay, period, parts = getattr(loop.hold, "delay", 0.0), loop.simulation.period, command_parts(loop)
    exact = round(parts * delay / period) / parts * period
    rounded = ops.at_or_after(min(delay, exact), max(delay, exact))
    if rounded or not hasattr(loop.simulation.integrator, "substep"):
        return loop
    changed: Loop = replace(loop, {"hold.delay": exact})
    return changed


def check_substeps(loop: Loop) -> None:
    """Refuse substeps that do not end where a delayed command comes."""
    substeps, parts = loop.simulation.substeps, command_parts(loop)
    if substeps != AUTO and substeps % parts:
        wanted = f"must be a multiple of {parts}, for the hold's delay"
        raise ParameterError("simulation.substeps", substeps, wanted)


def with_substeps(loop: Loop, substeps: int) -> Loop:
    """The loop with so many substeps in a sample period."""
    changed: Loop = replace(loop, {"simulation.substeps": substeps})
    return changed


def at_period(loop: Loop, period: float) -> Loop:
    """The loop at another sample period [s].

    A computing delay keeps its share of the period, and steps are at most as long as they were.
    """
    given: Any = loop.simulation
    hold: Any = loop.hold
    share = period / given.period
    substeps = AUTO if given.substeps == AUTO else math.ceil(share * given.substeps - 1e-9)
    if hasattr(hold, "delay"):
        hold = hold._replace(delay=share * hold.delay)
    return loop._replace(simulation=given._replace(period=period, substeps=substeps), hold=hold)


def unsettled_text(loop: Loop, error: float) -> str:
    """That substeps and twice as many differ by more than they may; why, where the load jumps inside one."""
    substeps, tolerance = loop.simulation.substeps, loop.simulation.tolerance
    jump = first_jump_inside(loop)
    cause = "" if jump == math.inf else f"; {jump_text(jump)}"
    return (
        f"the steps did not settle: {substeps} substeps and twice as many differ by {error:.1e} of the "
        f"machine's largest values, more than simulation.tolerance = {tolerance:g}{cause}"
    )


def jump_text(jump: float) -> str:
    return f"the load jumps inside a step, first at {jump:g} s; Tsit5 ends one there"


def largest_difference(loop: Loop, coarse: RecordedSignals, fine: RecordedSignals) -> float:
    """The largest difference of a machine's states in two runs, relative to each state's largest value.

    It is inf where one run is lost and the other is not. States that stand still in both do not count.
    """
    *paths, _ = machine_paths(loop)
    pairs = ((np.asarray(coarse[path]), np.asarray(fine[path])) for path in paths)
    return max((state_difference(*pair) for pair in pairs), default=0.0)


def state_difference(a: Numbers, b: Numbers) -> float:
    there = np.isfinite(a)
    if not np.array_equal(there, np.isfinite(b)):
        return math.inf
    apart = np.abs(a[there] - b[there]).max(initial=0.0)
    largest = np.abs(b[there]).max(initial=0.0)
    if max(apart, largest) <= STILL:
        return 0.0
    return float(apart / largest) if largest > 0.0 else math.inf
