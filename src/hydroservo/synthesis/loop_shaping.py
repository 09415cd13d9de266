"""A design model's velocity as a sampled PI law meets it: the plant to be stabilised robustly."""

import numpy as np

from hydroservo.plants.design_model import DesignModel
from hydroservo.synthesis.coprime import StateSpace

__all__ = ["shaped_plant"]


def shaped_plant(
    model: DesignModel, time_constant: float, period: float, proportional: float, integral: float
) -> StateSpace:
    """G W: the velocity at rest over what a PI weight is given.

    W = k_p + k_i/s, then half a sample for the hold, (1 - s h/4)/(1 + s h/4), then the valve 1/(tau s + 1),
    then the model about rest. A valve without lag and an integral of 0 have no state.

    Args:
        model: what is believed of the machine.
        time_constant: tau [s] of the valve; 0 for one without lag.
        period: h [s].
        proportional: k_p [V s/m].
        integral: k_i [V/m].
    """
    rates = np.array([[model.f1(1.0), model.g1()], [model.f2(1.0, 0.0), model.f2(0.0, 1.0)]])
    velocity = StateSpace(rates, np.array([[0.0], [model.g2(0.0, 0.0)]]), np.array([[1.0, 0.0]]))
    behind = lagged(velocity, time_constant) if time_constant > 0.0 else velocity
    return weighted(held(behind, period), proportional, integral)


def lagged(plant: StateSpace, time_constant: float) -> StateSpace:
    """A plant behind a lag of first order."""
    a = np.block([[plant.a, plant.b], [np.zeros((1, len(plant.a))), -1.0 / np.float64(time_constant)]])
    b = np.append(np.zeros(len(plant.a)), 1.0 / np.float64(time_constant))
    return StateSpace(a, b[:, np.newaxis], np.append(plant.c, [[0.0]], axis=1))


def held(plant: StateSpace, period: float) -> StateSpace:
    """A plant behind half a sample of delay, by Pade's approximation of order one: 2/(1 + s h/4) - 1."""
    late = lagged(StateSpace(plant.a, 2.0 * plant.b, plant.c), 0.25 * period)
    return late._replace(b=late.b - np.append(plant.b, [[0.0]], axis=0))


def weighted(plant: StateSpace, proportional: float, integral: float) -> StateSpace:
    """A plant behind k_p + k_i/s."""
    if integral == 0.0:
        return plant._replace(b=proportional * plant.b)
    a = np.block([[plant.a, plant.b], [np.zeros((1, len(plant.a) + 1))]])
    b = np.append(proportional * plant.b, [[integral]], axis=0)
    return StateSpace(a, b, np.append(plant.c, [[0.0]], axis=1))
