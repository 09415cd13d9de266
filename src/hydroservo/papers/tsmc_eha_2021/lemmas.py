"""Lemma 2 and the conditions (17) and (25) of the proofs, asked about a run of the paper's law."""

from typing import TYPE_CHECKING

from hydroservo.control.controllers.tsmc import TSMC
from hydroservo.control.observers.tsm import TSMObserver
from hydroservo.machine.theory import Decrease, GainCondition, decrease, gain_condition

if TYPE_CHECKING:
    import xarray as xr


def lemma_2(data: "xr.Dataset", observer: TSMObserver) -> tuple[GainCondition, GainCondition]:
    """The gain condition in both channels of a simulated run, over every sample of it, recorded or not.

    Args:
        data: what ``simulate`` returned.
        observer: the observer whose gains are judged; it need not be the one that ran.

    Source: Lemma 2 of doi:10.1007/s42401-021-00087-w.
    Fails where :func:`~hydroservo.machine.theory.gain_condition` does.
    """
    return (
        gain_condition(observer.switching_gain_1, data["disturbance_max_1"]),
        gain_condition(observer.switching_gain_2, data["disturbance_max_2"]),
    )


def condition_17(data: "xr.Dataset", observer: TSMObserver, period: float) -> tuple[Decrease, Decrease]:
    """Condition (17) for both observer surfaces of a simulated run that recorded them.

    The dead zone is 2 T max(D_i, max |d_Li|): what the switching term and the disturbance together can move a
    surface by within one period T, with room for the error of the observer's forward step.

    Args:
        data: what ``simulate`` returned, with ``controller.observer.s1`` and ``s2``.
        observer: the observer that ran.
        period: sample period T of the controller [s].

    Raises:
        ParameterError: as :func:`~hydroservo.machine.theory.decrease`.
        KeyError: a surface was not recorded.

    Source: eq. (17) of doi:10.1007/s42401-021-00087-w.
    Fails inside a boundary layer, where D tanh(s/phi) is less than |d|: s then rests where the two are
    equal, and the condition is reported as violated there, which it is. With the implicit realisation
    the recorded surface is s_hat, which is exactly 0 once reached.
    """
    gains = (
        (observer.linear_gain_1, observer.switching_gain_1, observer.power_gain_1),
        (observer.linear_gain_2, observer.switching_gain_2, observer.power_gain_2),
    )
    first, second = (
        decrease(
            data["time"],
            data[f"controller.observer.s{i}"],
            k,
            eps,
            observer.exponent,
            2.0 * period * max(D, float(data[f"disturbance_max_{i}"])),
        )
        for i, (k, D, eps) in enumerate(gains, start=1)
    )
    return first, second


def condition_25(data: "xr.Dataset", controller: TSMC, dead_zone: float) -> Decrease:
    """Condition (25) for the controller surface xi_2 of a simulated run that recorded it.

    Args:
        data: what ``simulate`` returned, with ``controller.xi2``.
        controller: the controller that ran.
        dead_zone: in the unit of xi_2 [m/s^2]. No sampled bound is at hand as for (17): xi_2 holds d_hat_1
            itself, and with it all that the realisation of sgn leaves in it.

    Raises:
        ParameterError: as :func:`~hydroservo.machine.theory.decrease`.
        KeyError: the surface was not recorded.

    Source: eqs. (23)-(25) of doi:10.1007/s42401-021-00087-w.
    Fails where the estimate of d(d_hat_1)/dt lags, where u is held between samples, and where it saturates:
    (25) knows none of the three, and a moving demand keeps xi_2 off 0 by what they leave.
    """
    return decrease(
        data["time"],
        data["controller.xi2"],
        controller.linear_gain_2,
        controller.power_gain_2,
        controller.exponent_2,
        dead_zone,
    )
