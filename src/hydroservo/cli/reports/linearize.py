"""What the report of a linear model says."""

import math

import numpy as np

from hydroservo.cli.linearize import gains_table, lines_of, poles_table
from hydroservo.cli.reporting import in_one_block, sentences, table_of
from hydroservo.figures.poles import plot_poles
from hydroservo.formatting import number
from hydroservo.linear import Linearization
from hydroservo.linear.textbook import Textbook
from hydroservo.loop import Loop
from hydroservo.reports.report import Picture, Report, origin_of_loop


def linearization_report(
    command: str, scenario: str, loop: Loop, found: Linearization, book: Textbook | None
) -> Report:
    """The report of a linear model.

    Args:
        command: makes it again.
        scenario: as the user named it.
        loop: the scenario's.
        found: what ``linearize`` returned.
        book: what a textbook's formulas say of a machine.
    """
    steady = "Gains from each input to each output once all has settled; nan where nothing settles."
    return Report(
        f"Linear model of the {found.unit} of {scenario}",
        [least_damped(found), *sentences(lines_of(found._replace(inexact=()), book))],
        in_one_block(sentences(lines_of(found, None))),
        [
            Picture(
                "poles",
                "Poles, with lines of equal damping; those that are not stable are red.",
                plot_poles(found),
            )
        ],
        [
            table_of("poles", poles_table(scenario, found), "Poles, slowest first; of a pair one."),
            table_of("gains", gains_table(found), steady),
        ],
        command,
        [origin_of_loop(scenario, loop)],
    )


def least_damped(found: Linearization) -> str:
    """The pair of poles that swings longest, in a sentence."""
    pairs = found.poles.imag > 0.0
    if not pairs.any():
        return f"None of its {len(found.poles)} poles swings."
    which = np.flatnonzero(pairs)[np.argmin(found.damping[pairs])]
    frequency = number(found.frequencies[which] / (2.0 * math.pi))
    damping = number(found.damping[which])
    count = f"its {len(found.poles)} poles"
    return f"The least damped pair of {count} has {frequency} Hz and a damping ratio of {damping}."
