"""What a linear model says."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from hydroservo.core.command_scale import in_command_unit
from hydroservo.core.formatting import number, quantity, superscripts
from hydroservo.runs.provenance import origin_of_loop
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Picture, Table
from hydroservo.show.finding import title_of

if TYPE_CHECKING:
    from hydroservo.figures.style import Plot
    from hydroservo.linear.linearization import Linearization, Quantity
    from hydroservo.linear.textbook import Textbook

CAPTION = "Poles, with lines of equal damping; those that are not stable are red."
STEADY = "Gains from each input to each output once all has settled."
ENDLESS = "\N{INFINITY}: an output that the input moves on and on."
INEXACT_LINE = Line(
    "Some derivatives come from differences", ", where there is no slope: see the last table.", Mark.DOUBTFUL
)
GUESSES = "Derivatives from differences, in SI units."


def linearization_finding(
    model: "Linearization", scenario: str = "", book: "Textbook | None" = None
) -> Finding:
    """What a linear model says.

    Args:
        model: what ``linearize`` returned.
        scenario: its name, if it has one.
        book: what a textbook's formulas say of a machine.
    """
    doubtful, inexact = ([INEXACT_LINE], [inexact_table(model)]) if model.inexact else ([], [])
    states = f"States: {', '.join(map(with_unit, model.states)) or 'none'}."
    return Finding(
        title_of(f"Linear model of the {model.unit}", scenario),
        [least_damped(model), *textbook_line(book), *doubtful, Line(states, mark=Mark.QUIET)],
        [],
        [poles_table(model), gains_table(model), *inexact],
        [Picture("poles", CAPTION, lambda: drawn(model))],
        numbers_of(model, scenario),
        origins=[origin_of_loop(scenario, model.loop)] if model.loop else [],
    )


def drawn(model: "Linearization") -> "Plot":
    from hydroservo.figures.bode import plot_poles

    return plot_poles(model)


def least_damped(model: "Linearization") -> Line:
    """The pair of poles that swings longest."""
    pairs = model.poles.imag > 0.0
    if not pairs.any():
        return Line("None of its poles swings.")
    which = np.flatnonzero(pairs)[np.argmin(model.damping[pairs])]
    frequency, damping = number(model.frequencies[which] / (2.0 * math.pi)), number(model.damping[which])
    pair = f"The least damped pair of its {len(model.poles)} poles"
    return Line(f"{pair} has {frequency} Hz and a damping ratio of {damping}.")


def textbook_line(book: "Textbook | None") -> list[Line]:
    if book is None:
        return []
    frequency, damping = number(book.natural_frequency / (2.0 * math.pi), 5), number(book.damping_ratio, 4)
    oil = f"{number(book.mass, 4)} kg on {number(1e-6 * book.stiffness, 4)} kN/mm of oil"
    return [Line(f"By the textbook's formulas: {frequency} Hz, damping ratio {damping} ({oil}).")]


def with_unit(one: "Quantity") -> str:
    unit = superscripts(in_command_unit(one.unit)[0])
    return f"{one.name} [{unit}]" if unit else one.name


def poles_table(model: "Linearization") -> Table:
    """The poles; of a pair one."""
    time = f"sampled every {quantity(model.period, 's')}" if model.period else "in continuous time"
    name, units = ("z", ("", "")) if model.period else ("s", ("1/s", "rad/s"))
    columns = (
        Column(f"Re {name}", units[0], digits=5),
        Column(f"± Im {name}", units[1], digits=5),
        Column("natural frequency", "Hz", digits=5),
        Column("damping ratio"),
    )
    each = zip(model.poles.tolist(), model.frequencies.tolist(), model.damping.tolist(), strict=True)
    rows = [
        [Cell(pole.real), Cell(pole.imag), Cell(frequency / (2.0 * math.pi)), Cell(damping)]
        for pole, frequency, damping in each
        if pole.imag >= 0.0
    ]
    return Table("poles", columns, rows, f"Poles of a model {time}, slowest first; of a pair one.")


def gains_table(model: "Linearization") -> Table:
    """The steady gain of each output by each input."""
    inputs = [(one.name, *in_command_unit(one.unit)) for one in model.inputs]
    columns = [
        Column(f"by 1 {superscripts(unit)} of {name}" if unit else f"by {name}") for name, unit, _ in inputs
    ]
    rows = [
        [
            Cell(output.name),
            *(Cell(model.steady_gain(output.name, name) / factor, output.unit) for name, _, factor in inputs),
            Cell(),
        ]
        for output in model.outputs
    ]
    note = ENDLESS if any(cell.value in (math.inf, -math.inf) for row in rows for cell in row) else ""
    return Table("gains", (Column("output"), *columns, UNIT), rows, STEADY, note)


def inexact_table(model: "Linearization") -> Table:
    """The derivatives that are not exact."""
    columns = (Column("derivative"), Column("value"), Column("off by up to", digits=2))
    rows = [[Cell(f"{one.of} by {one.by}"), Cell(one.value), Cell(one.error)] for one in model.inexact]
    return Table("inexact", columns, rows, GUESSES)


def numbers_of(model: "Linearization", scenario: str) -> dict[str, Any]:
    """All numbers of a linear model, in SI units."""
    names = {what: [one.name for one in getattr(model, what)] for what in ("states", "inputs", "outputs")}
    units = {what: [one.unit for one in getattr(model, what)] for what in names}
    return {
        "scenario": scenario,
        "unit": model.unit,
        "period": model.period or None,
        **names,
        "units": units,
        **{name: getattr(model, name).tolist() for name in "ABCD"},
        "poles": [[pole.real, pole.imag] for pole in model.poles.tolist()],
        "frequencies": model.frequencies.tolist(),
        "damping": model.damping.tolist(),
        "inexact": [one._asdict() for one in model.inexact],
    }
