"""What is known of a run besides its machine: demand and load at each step, and what is expected of them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.machine.integrators.jumps import BEFORE

JUMP = 0.05  # of a signal's whole range: a step of the integrator that changes it more is a jump

Matrix = NDArray[np.float64]
Vector = NDArray[np.float64]
Places = NDArray[np.intp]


class Foreknown(NamedTuple):
    """Demand and load at the steps of the integrator.

    Attributes:
        demand: at the beginning of each step, shape (steps,).
        rate: its rate there.
        second_rate: and that of its rate.
        force: on the rod at the beginning, middle and end of each [N], shape (3, steps); before a jump at
            its end.
        step: how long one takes [s].
        substeps: how many there are in a sample period.
    """

    demand: Vector
    rate: Vector
    second_rate: Vector
    force: Matrix
    step: float
    substeps: int

    def table(self, first: int, last: int) -> Matrix:
        """What an interval knows, of samples first to last - 1: shape (4 substeps, samples)."""
        chosen, samples = slice(first * self.substeps, last * self.substeps), last - first
        forces = self.force[:, chosen].T.reshape(samples, -1)
        return np.hstack([forces, self.demand[chosen].reshape(samples, -1)]).T


def foreknown(loop: Loop, samples: int) -> Foreknown:
    """The demand and the load of a loop, over so many samples."""
    simulation = loop.simulation
    period, substeps = simulation.period, simulation.substeps
    h = period / substeps
    starts = [k * period + i * h for k in range(samples) for i in range(substeps)]
    demands = np.array([loop.reference.at(t) for t in starts])
    forces = np.array([forces_of(loop, t, h) for t in starts]).T
    value, rate, second_rate = demands.T
    return Foreknown(value, rate, second_rate, forces, h, substeps)


def forces_of(loop: Loop, t: float, h: float) -> tuple[float, float, float]:
    """The load [N] at the three instants at which RK4 asks for it in a step."""
    force, jump = loop.load.force, loop.load.next_jump(t)
    end = t + h if BEFORE * (t + h) > jump else min(t + h, BEFORE * jump)
    return force(t), force(t + 0.5 * h), force(end)


def jumps(known: Foreknown) -> tuple[Places, Places]:
    """The steps at whose beginning the demand, or its rate, jumps; and those at which the load does.

    A signal jumps where a step changes it by more than a twentieth of its whole range beyond what its rate
    says; a rate likewise, by that of its range from 0.
    """
    h, size = known.step, np.abs(known.rate).max()
    moved = np.diff(known.demand) - h * known.rate[:-1] - 0.5 * h * h * known.second_rate[:-1]
    turned = np.diff(known.rate) - h * known.second_rate[:-1]
    demand = (np.abs(moved) > JUMP * np.ptp(known.demand)) | (np.abs(turned) > JUMP * size)
    load = np.abs(known.force[0, 1:] - known.force[2, :-1]) > JUMP * np.ptp(known.force)
    return np.flatnonzero(demand) + 1, np.flatnonzero(load) + 1


def expected(known: Foreknown, step: int) -> Foreknown:
    """What is expected of demand and load where no jump is foreseen that comes at a step or after it.

    From the first such jump on the demand goes on at its rate, and the load stays as it is.
    """
    demand, force = known.demand.copy(), known.force.copy()
    of_demand, of_load = (first_from(found, step) for found in jumps(known))
    if of_demand is not None:
        last = of_demand - 1
        after = np.arange(1, demand.size - last)
        demand[of_demand:] = demand[last] + after * known.step * known.rate[last]
    if of_load is not None:
        force[:, of_load:] = force[2, of_load - 1]
    return known._replace(demand=demand, force=force)


def first_from(found: Places, step: int) -> int | None:
    """The first of some steps that is not before a step."""
    later = found[found >= step]
    return int(later[0]) if later.size else None
