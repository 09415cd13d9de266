"""A figure's layout, made once and kept."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

DIGITS = 6  # of positions, as shares of the figure


def fix_layout(fig: Figure) -> None:
    """Lay a figure out, and leave it so whatever is drawn on it later.

    The solver of layouts takes its unknowns in an order that changes from one time to the next, and so leaves
    other last digits; these are rounded away, for the same picture to give the same bytes.

    Args:
        fig: the figure, all that needs room on it drawn.
    """
    fig.draw_without_rendering()
    fig.set_layout_engine("none")
    for part in fig.subfigs:
        part.bbox_relative.set_points(np.round(part.bbox_relative.get_points(), DIGITS))
    for axis in fig.axes:
        axis.set_position(Bbox(np.round(axis.get_position(original=True).get_points(), DIGITS)))
