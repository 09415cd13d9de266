"""The paper's loops, and the bound of its Lemma 1, to the letter of the print."""

from typing import Any

from hydroservo.control.controllers.backstepping import Backstepping
from hydroservo.control.controllers.tsmc import TSMC
from hydroservo.control.loop import Loop
from hydroservo.core.block import replace, value_at
from hydroservo.machine.plants.design_model import DesignModel
from hydroservo.machine.theory import settling_bound
from hydroservo.papers.tsmc_eha_2021.printed.backstepping import PrintedBackstepping
from hydroservo.papers.tsmc_eha_2021.printed.tsmc import PrintedTSMC

LAWS: dict[type, Any] = {Backstepping: PrintedBackstepping, TSMC: PrintedTSMC}  # PI is as printed


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


def printed(loop: Loop) -> Loop:
    """A loop with the machine and the law as they are printed: see the two functions below."""
    return printed_law(printed_leakage(loop))


def printed_leakage(loop: Loop) -> Loop:
    """A loop whose machine has the leakage term of the print, as has all that is believed of it.

    It is 4 beta_e A_p C_tl/V_t x2 for 4 beta_e C_tl/V_t x2: the machine with A_p C_tl in place of C_tl.
    The units do not match, and next to no damping is left.

    Args:
        loop: its plant is a :class:`~hydroservo.machine.plants.LoadPressurePlant`.

    Source: eqs. (5), (7) and (26) of doi:10.1007/s42401-021-00087-w.
    """
    paths = ["plant"]
    if isinstance(getattr(loop.controller, "model", None), DesignModel):
        paths.append("controller.model.plant")
    plants = {path: value_at(loop, path) for path in paths}
    changed: Loop = replace(
        loop, {f"{path}.leakage": plant.piston_area * plant.leakage for path, plant in plants.items()}
    )
    return changed


def printed_law(loop: Loop) -> Loop:
    """A loop whose ``TSMC`` or ``Backstepping`` is :class:`PrintedTSMC` or :class:`PrintedBackstepping`.

    Any other law, such as PI, stays.
    """
    kind = LAWS.get(type(loop.controller))
    if kind is None:
        return loop
    return loop._replace(controller=kind(**{name: getattr(loop.controller, name) for name in kind._fields}))
