"""The picture of a linear model: its poles in the plane of s, or of z where it is sampled."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from hydroservo.figures.style import GREY, PALETTE, Plot, figure, style

if TYPE_CHECKING:
    from hydroservo.linear import Linearization

HEIGHT = 3.4  # inch
DAMPING = (0.1, 0.3, 0.5, 0.7)  # of the lines that are drawn
MARGIN = 1.15  # of an axis, beyond the outermost pole
FAINT = {"color": GREY, "linewidth": 0.6, "linestyle": ":", "zorder": 1}


def plot_poles(model: "Linearization") -> Plot:
    """The poles of a linear model, with lines of equal damping; those that are not stable are red.

    In continuous time s = -zeta w ± j w sqrt(1 - zeta^2); of a sampled model z = e^(s h), inside the unit
    circle where it is stable.

    Args:
        model: what :func:`~hydroservo.linearize` returned.
    """
    with style():
        fig = figure(HEIGHT, width=1.3 * HEIGHT)
        axis = fig.subplots()
        poles = model.poles
        lost = np.abs(poles) > 1.0 if model.period else poles.real > 0.0
        (draw_z_plane if model.period else draw_s_plane)(axis, poles)
        for which, colour in ((~lost, PALETTE[0]), (lost, PALETTE[1])):
            axis.plot(poles.real[which], poles.imag[which], "x", color=colour, markeredgewidth=1.6)
        axis.set_title(f"poles of the {model.unit}", loc="left")
    return fig


def draw_s_plane(axis: Axes, poles: np.ndarray) -> None:
    """Axes through s = 0, and rays of equal damping."""
    reach = MARGIN * float(np.abs(poles).max(initial=0.0)) or 1.0
    for zeta in DAMPING:
        x, y = -zeta * reach, reach * np.sqrt(1.0 - zeta**2)
        for sign in (1.0, -1.0):
            axis.plot([0.0, x], [0.0, sign * y], **FAINT)  # type: ignore[arg-type]
        axis.annotate(f"{zeta:g}", (x, y), color=GREY, fontsize=7, ha="right", va="bottom")
    axis.axvline(0.0, color=GREY, linewidth=0.8)
    right = MARGIN * max(float(poles.real.max(initial=0.0)), 0.1 * reach)
    axis.set(xlim=(-MARGIN * reach, right), ylim=(-MARGIN * reach, MARGIN * reach))
    axis.set(xlabel="Re s [1/s]", ylabel="Im s [rad/s]")


def draw_z_plane(axis: Axes, poles: np.ndarray) -> None:
    """The unit circle, and curves of equal damping inside it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 361)
    axis.plot(np.cos(turn), np.sin(turn), color=GREY, linewidth=0.8)
    angle = np.linspace(0.0, np.pi, 181)
    for zeta in DAMPING:
        z = np.exp((-zeta / np.sqrt(1.0 - zeta**2) + 1j) * angle)
        for half in (z, z.conj()):
            axis.plot(half.real, half.imag, **FAINT)  # type: ignore[arg-type]
        axis.annotate(f"{zeta:g}", (z[60].real, z[60].imag), color=GREY, fontsize=7, ha="center")
    reach = MARGIN * max(1.0, float(np.abs(poles).max(initial=0.0)))
    axis.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="Re z", ylabel="Im z", aspect="equal")
