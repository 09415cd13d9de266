"""How far loops are from oscillating, and the bounds on that which a search of their gains keeps."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.monitors import Oscillation
from hydroservo.core.block import replace
from hydroservo.core.field import Field
from hydroservo.core.formatting import NONE, number, quantity
from hydroservo.linear.margins import MARGIN_LABELS, NO_SLOPE_ERRORS, formatted_margin, margin_in
from hydroservo.linear.moving_margins import MarginPoint, Reserve, margin_points
from hydroservo.linear.onset import LARGE, first_lasting_swing, with_amplified_command, with_longer_run
from hydroservo.linear.view import known_onset, loop_view
from hydroservo.runs.batch import loop_with_steps, simulate_batch
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.show import Cell, Column, Table

Numbers = NDArray[np.float64]
Columns = Mapping[str, Numbers]

UNSTABLE = 5.0  # violation of an unstable loop, to which the logarithm of its growth is added
LINEAR = 20.0  # added to a violation of linear margins, so that it outweighs any oscillation
WILDEST = 10.0  # the most that an oscillation or its growth counts, as of a run that diverges
FINE = 0.25  # dB from gain to gain, of a closer look


class Bounds(NamedTuple):
    """The margins that loops must keep while their machines move."""

    gain_margin: Annotated[float, Field("", "least gain margin, a factor", at_least=1)] = 10.0**0.3
    phase_margin: Annotated[float, Field("rad", "least phase margin", at_least=0, below=math.pi)] = (
        math.pi / 6.0
    )
    max_sensitivity: Annotated[float, Field("", "largest sensitivity peak", above=1)] = 10.0**0.3


class LoopGuard:
    """Holds candidates against bounds, on the loops of a search and on those of its uncertainty.

    The margins are those at the loops' :func:`~hydroservo.linear.moving_margins.margin_points`. The loops
    also run, 5 s longer than their own time, at their gain and at the bound on it: none may oscillate. Where
    no loop has a slope, as of a sliding law, they run at their own gain alone.
    """

    def __init__(self, bounds: Bounds, loops: Mapping[str, Loop], threads: int | None) -> None:
        self.bounds, self.loops, self.threads = bounds, loops, threads
        self.places = {name: margin_points(loop) for name, loop in loops.items()}
        self.longer = {
            name: loop_with_steps(with_longer_run(loop), loop, strict=False)[0]
            for name, loop in loops.items()
        }
        sloped = any(self.places.values())
        self.gains = np.array([1.0, math.sqrt(bounds.gain_margin), bounds.gain_margin] if sloped else [1.0])

    def violations(self, candidates: Columns) -> Numbers:
        """How far each candidate is beyond the bounds; 0 within them.

        Of several places beyond them the first counts, and runs only where no place is.
        """
        count = next(iter(candidates.values())).size
        found = np.zeros(count)
        places = [place for own_places in self.places.values() for place in own_places]
        for k in range(count):
            own = {path: float(values[k]) for path, values in candidates.items()}
            beyond = (self.beyond(reserve_with(place, own)) for place in places)
            first = next((excess for excess in beyond if excess > 0.0), 0.0)
            found[k] = LINEAR + first if first else 0.0
        due = np.flatnonzero(found == 0.0)
        if due.size:
            some = {path: values[due] for path, values in candidates.items()}
            found[due] = np.max([self.swings(name, some, self.gains) for name in self.loops], axis=0)
        return found

    def beyond(self, reserve: Reserve) -> float:
        """By how much, as a logarithm, a reserve is beyond the bounds."""
        if math.isnan(reserve.gain_margin):
            return UNSTABLE + min(math.log1p(1e3 * (reserve.growth - 1.0)), WILDEST)
        bounds = self.bounds
        ratios = (
            bounds.gain_margin / reserve.gain_margin,
            bounds.phase_margin / max(reserve.phase_margin, 1e-9),
            reserve.sensitivity_peak / bounds.max_sensitivity,
        )
        return max(0.0, math.log(max(ratios)))

    def swings(self, name: str, candidates: Columns, gains: Numbers) -> Numbers:
        """The logarithm of each candidate's oscillation over the least that counts, at the worst gain."""
        amplitude = self.amplitudes(name, candidates, gains)
        least = np.where(gains > 1.0, LARGE, Oscillation().threshold)
        with np.errstate(divide="ignore"):
            found = np.log(np.nan_to_num(amplitude, nan=0.0, posinf=math.inf) / least)
        return np.asarray(np.clip(found, 0.0, WILDEST).max(axis=1))

    def amplitudes(self, name: str, candidates: Columns, gains: Numbers) -> Numbers:
        """The command's amplitude [V] in the oscillation of each candidate, shape (candidates, gains).

        It is 0 for none, nan where it cannot be told, and infinite where the run diverged.
        """
        count = max((values.size for values in candidates.values()), default=1)
        columns = {
            f"controller.{path}" if path.startswith("controller.") else path: np.repeat(values, gains.size)
            for path, values in candidates.items()
        }
        tiled = np.tile(gains, count)
        columns |= {"controller.extend_gain": tiled, "controller.retract_gain": tiled}
        loop = with_amplified_command(self.longer[name])
        data = quietly(simulate_batch)(loop, columns, metrics=[Oscillation()], threads=self.threads)
        amplitude = np.where(data["diverged"].values, math.inf, data["oscillation_command"].values)
        return np.asarray(amplitude.reshape(count, gains.size))

    def objections(self, parameters: Mapping[str, float]) -> list[str]:
        """What is beyond the bounds with some values: where their own law stays, and at finer gains."""
        return [
            f"{name}: {problem}"
            for name, loop in self.loops.items()
            for problem in [
                *self.linear_problems(replace(loop, parameters)),
                *self.run_problems(name, parameters),
            ]
        ]

    def linear_problems(self, loop: Loop) -> Iterator[str]:
        """What is beyond the bounds of a loop's margins, each where it is worst."""
        places = {place.point.command: place.margins for place in margin_points(loop)}
        unstable = [number(command) for command, margins in places.items() if not margins.stable]
        if unstable:
            yield f"small motions are unstable under {', '.join(unstable)} V"
            return
        for label, least, unit, side in (
            ("gain_margin", self.bounds.gain_margin, "dB", "below"),
            ("phase_margin", self.bounds.phase_margin, "rad", "below"),
            ("sensitivity_peak", self.bounds.max_sensitivity, "dB", "above"),
        ):
            sign = 1.0 if side == "below" else -1.0
            values = {command: getattr(margins, label) for command, margins in places.items()}
            command = min(values, key=lambda one: sign * values[one], default=0.0)
            if places and sign * values[command] < sign * least:
                shown, bound = (
                    formatted_margin(values[command], unit, NONE),
                    formatted_margin(least, unit, NONE),
                )
                yield f"{MARGIN_LABELS[label][0]} {shown} under {number(command)} V, {side} {bound}"

    def run_problems(self, name: str, parameters: Mapping[str, float]) -> Iterator[str]:
        """What a loop's runs show."""
        bound = self.gains[-1]
        steps = np.arange(0.0, 20.0 * math.log10(bound) + 1.5 * FINE, FINE)  # one beyond the bound
        gains = 10.0 ** (steps / 20.0)
        columns = {path: np.array([value]) for path, value in parameters.items()}
        (amplitude,) = self.amplitudes(name, columns, gains)
        if amplitude[0] > 0.0:
            yield f"oscillates as it stands, {quantity(amplitude[0], 'V')} in the command"
            return
        large = np.where(np.nan_to_num(amplitude) >= LARGE, amplitude, 0.0)
        onset = first_lasting_swing(gains, large)
        if onset < bound:
            yield f"oscillates from {formatted_margin(onset, 'dB', NONE)} more gain"


def reserve_with(place: MarginPoint, parameters: Mapping[str, float]) -> Reserve:
    """A place's reserve; that of a wildly unstable loop where the values allow no law on its machine."""
    try:
        return place.reserve(parameters)
    except NO_SLOPE_ERRORS:
        return Reserve(math.inf)


class StabilityMargins(NamedTuple):
    """How far a loop is from oscillating, as ``bode`` shows it; nan where a number cannot be had."""

    oscillation_gain: Annotated[float, Field("", "factor on the gain from which the loop oscillates")]
    gain_margin: Annotated[float, Field("", "least gain margin while moving")]
    phase_margin: Annotated[float, Field("rad", "least phase margin while moving")]
    sensitivity_peak: Annotated[float, Field("", "largest sensitivity peak while moving")]
    oscillation_command: Annotated[float, Field("V", "amplitude of the command in a sustained oscillation")]

    def __str__(self) -> str:
        shown = {name: MARGIN_LABELS[name] for name in self._fields if name in MARGIN_LABELS}
        texts = (
            f"{label} {formatted_margin(getattr(self, name), unit, NONE)}"
            for name, (label, unit) in shown.items()
        )
        return ", ".join(texts)

    def cells(self) -> list[Cell]:
        """The margins of a row of a table."""
        named = {name: MARGIN_LABELS[name][1] for name in self._fields if name in MARGIN_LABELS}
        return [Cell(*margin_in(unit, getattr(self, name))) for name, unit in named.items()]


class StabilityChange(NamedTuple):
    """How a loop stands before a search and after it."""

    name: str
    before: StabilityMargins
    after: StabilityMargins

    def __str__(self) -> str:
        return f"{self.name}: before, {self.before}; after, {self.after}"

    @staticmethod
    def table(changes: "Sequence[StabilityChange]") -> Table:
        """How loops stand, a row for each before and one after."""
        margins = (
            Column(MARGIN_LABELS[name][0], digits=3, right=True)
            for name in StabilityMargins._fields
            if name in MARGIN_LABELS
        )
        rows = [
            [Cell(one.name), Cell(when), *standing.cells()]
            for one in changes
            for when, standing in (("before", one.before), ("after", one.after))
        ]
        return Table(
            "margins", (Column("machine"), Column("values"), *margins), rows, "Margins while moving."
        )


def stability_of(loop: Loop) -> StabilityMargins:
    """How far a loop is from oscillating; the oscillation is that of a run 5 s longer than its own."""
    run = quietly(simulate)(with_longer_run(loop), record=(), metrics=[Oscillation()])
    amplitude = math.inf if run["diverged"] else float(run["oscillation_command"])
    try:
        view = loop_view(loop, None, None, None)
    except NO_SLOPE_ERRORS:
        return StabilityMargins(known_onset(loop, None), math.nan, math.nan, math.nan, amplitude)
    margins = view.trusted.margins
    return StabilityMargins(
        view.onset, margins.gain_margin, margins.phase_margin, margins.sensitivity_peak, amplitude
    )


def stability_changes(loops: Mapping[str, Loop], parameters: Mapping[str, float]) -> list[StabilityChange]:
    """How loops stand with their own values, and with others."""
    return [
        StabilityChange(name, stability_of(loop), stability_of(replace(loop, parameters)))
        for name, loop in loops.items()
    ]
