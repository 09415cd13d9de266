"""The paper's loops to the letter of the print."""

from typing import Any

from hydroservo.block import replace, value_at
from hydroservo.controllers.backstepping import Backstepping
from hydroservo.controllers.tsmc import TSMC
from hydroservo.loop import Loop
from hydroservo.papers.tsmc_eha_2021.printed.backstepping import PrintedBackstepping
from hydroservo.papers.tsmc_eha_2021.printed.tsmc import PrintedTSMC
from hydroservo.plants.design_model import DesignModel

LAWS: dict[type, Any] = {Backstepping: PrintedBackstepping, TSMC: PrintedTSMC}  # PI is as printed


def printed(loop: Loop) -> Loop:
    """A loop with the machine and the law as they are printed: see the two functions below."""
    return printed_law(printed_leakage(loop))


def printed_leakage(loop: Loop) -> Loop:
    """A loop whose machine has the leakage term of the print, as has all that is believed of it.

    It is 4 beta_e A_p C_tl/V_t x2 for 4 beta_e C_tl/V_t x2: the machine with A_p C_tl in place of C_tl.
    The units do not match, and next to no damping is left.

    Args:
        loop: its plant is a :class:`~hydroservo.plants.LoadPressurePlant`.

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
