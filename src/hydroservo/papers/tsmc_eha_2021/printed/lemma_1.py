"""The bound of Lemma 1 as eq. (9) prints it."""

from hydroservo.theory import settling_bound


def printed_settling_bound(
    linear_rate: float, power_rate: float, exponent: float, initial: float, start: float = 0.0
) -> float:
    """The printed instant [s] by which a function V that decreases as in Lemma 1 were zero.

    ::

        t_0 + 1/(mu (1 + alpha)) ln(1 + mu V(t_0)^(1 - alpha)/delta)

    That is no bound: it is shorter than the right one by the factor (1 - alpha)/(1 + alpha).

    Args:
        linear_rate: mu [1/s], above 0.
        power_rate: delta [V^(1 - alpha)/s], above 0.
        exponent: alpha, above 0 and below 1.
        initial: V(t_0), in the unit of V, at least 0.
        start: t_0 [s].

    Raises:
        ParameterError: an argument out of range.

    Source: eq. (9) of doi:10.1007/s42401-021-00087-w.
    Fails always: where V decreases no faster than it must, it is still positive then.
    """
    right = settling_bound(linear_rate, power_rate, exponent, initial)
    return start + right * (1.0 - exponent) / (1.0 + exponent)
