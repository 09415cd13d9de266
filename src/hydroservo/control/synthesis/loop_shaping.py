"""A design model's velocity as a sampled PI law meets it: the plant to be stabilised robustly."""

import numpy as np

from hydroservo.control.synthesis.coprime import StateMatrices
from hydroservo.control.synthesis.linear_model import model_at_rest
from hydroservo.control.synthesis.sampled import under_held_input
from hydroservo.machine.plants.design_model import DesignModel

DIRECT = np.zeros((1, 1))


def sampled_plant(
    model: DesignModel, time_constant: float, period: float, proportional: float, integral: float
) -> StateMatrices:
    """G W: the velocity about rest over what a sampled PI weight is given, x_(k+1) = A x_k + B u_k.

    G is the model behind the valve 1/(tau s + 1), its command held over a sample, W = k_p + k_i h z/(z - 1).
    A valve without lag and an integral of 0 have no state.

    Args:
        model: what is believed of the machine.
        time_constant: tau [s] of the valve; 0 for one without lag.
        period: h [s].
        proportional: k_p [V s/m].
        integral: k_i [V/m].

    Raises:
        ValueError: it is beyond the range of floating-point numbers.
    """
    with np.errstate(all="ignore"):
        plant = model_at_rest(model, time_constant)
        scaled = plant.scaled()  # whose velocity still is in m/s
        moved, held = under_held_input(scaled.rates, scaled.driven, period)
        driven, seen = held[:, np.newaxis] / plant.command, np.eye(1, len(moved))
        gain, n = proportional + period * integral, len(moved)
        if integral == 0.0:
            return StateMatrices(moved, gain * driven, seen, DIRECT)
        whole = np.block([[moved, driven], [np.zeros((1, n)), np.ones((1, 1))]])
        given = np.append(gain * driven, [[period * integral]], axis=0)
    return StateMatrices(whole, given, np.append(seen, [[0.0]], axis=1), DIRECT)


def to_bilinear(sampled: StateMatrices) -> StateMatrices:
    """What is sampled, as a function of v = (z - 1)/(z + 1): all norms on the unit circle stay.

    Raises:
        ValueError: it has a pole at z = -1.
    """
    a, b, c, d = sampled
    try:
        half = np.linalg.inv(a + np.eye(len(a)))
    except np.linalg.LinAlgError:
        raise ValueError("it is beyond the range of floating-point numbers") from None
    root = np.sqrt(2.0)
    return StateMatrices(half @ (a - np.eye(len(a))), root * half @ b, root * c @ half, d - c @ half @ b)


def from_bilinear(law: StateMatrices) -> StateMatrices:
    """What is a function of v = (z - 1)/(z + 1), sampled.

    Raises:
        ValueError: it has a pole at v = 1.
    """
    a, b, c, d = law
    try:
        half = np.linalg.inv(np.eye(len(a)) - a)
    except np.linalg.LinAlgError:
        raise ValueError("it is beyond the range of floating-point numbers") from None
    root = np.sqrt(2.0)
    return StateMatrices(half @ (a + np.eye(len(a))), root * half @ b, root * c @ half, d + c @ half @ b)
