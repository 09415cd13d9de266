"""Frequency responses measured on the nonlinear simulation, by many tones at once or by a chirp."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.monitors import PistonTravel
from hydroservo.core.block import Block, leaves
from hydroservo.core.errors import ParameterError
from hydroservo.core.group import nested
from hydroservo.linear.excitation import Chirp, Excited, ExcitedDemand, PushedLoad, Tones
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.machine.starts import AsBuilt
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import simulate
from hydroservo.runs.step_sizes import with_substeps

if TYPE_CHECKING:
    import xarray as xr

Vector = NDArray[np.float64]
Response = NDArray[np.complex128]

EXCITED = ("command", "reference", "load")
GIVEN, ASKED, SIGNAL = "controller.u", "controller.controller.u", "controlled.value"
DEMAND, FORCE = "reference.value", "load.force"
ADDED = "added"  # to the command, what is given less what is asked for
LEAST_POWER = 1e-300
BELOW, ABOVE, HIGHEST = 0.5, 1.1, 0.98  # a chirp's ends by those of the tones, and of Nyquist's frequency


class Experiment(NamedTuple):
    """How a loop is excited.

    Attributes:
        harmonics: numbers of the tones among those of the period, rising, shape (tones,).
        period: of all tones together, in samples.
        periods: that are heard, after one in which the loop settles.
        realisations: each with phases of its own, drawn at random.
        seed: of the draws.
        excitation: "multisine", all tones at once, or "chirp", one that passes them.
    """

    harmonics: NDArray[np.int64]
    period: int
    periods: int
    realisations: int
    seed: int
    excitation: str = "multisine"

    def frequencies(self, sample_period: float) -> Vector:
        """Of the tones [rad/s]."""
        return np.asarray(2.0 * np.pi * self.harmonics / (self.period * sample_period))


class Heard(NamedTuple):
    """Spectra of signals at the tones, shape (realisations, periods, tones), by the signal's path."""

    spectra: dict[str, Response]

    def response(self, output: str, input_: str) -> Response:
        """The best linear approximation: the mean of Y U* by that of |U|^2 of realisations and periods."""
        y, u = self.spectra[output], self.spectra[input_]
        return np.asarray((y * u.conj()).mean((0, 1)) / (np.abs(u) ** 2).mean((0, 1)))

    def beside(self, name: str, spectrum: Response) -> "Heard":
        """With one more signal."""
        return Heard(self.spectra | {name: spectrum})

    def coherence(self, output: str, input_: str) -> Vector:
        """|mean of Y U*|^2 by the means of |Y|^2 and |U|^2: below 1 by noise, and by what is not linear."""
        y, u = self.spectra[output], self.spectra[input_]
        cross = np.abs((y * u.conj()).mean((0, 1))) ** 2
        power = (np.abs(y) ** 2).mean((0, 1)) * (np.abs(u) ** 2).mean((0, 1))
        return np.asarray(cross / np.maximum(power, LEAST_POWER))


def measured(
    loop: Loop, point: OperatingPoint, excited: str, amplitude: float, plan: Experiment, also: Sequence[str]
) -> Heard:
    """What a loop answers to tones, about a point.

    It is simulated as it is, with noise and steps of resolution, from the point on. Each realisation draws
    its phases; a period passes before it is heard. Without noise the periods of one realisation are alike,
    and what differs between realisations is what is not linear.

    Args:
        loop: the loop.
        point: where it stays.
        excited: the command, the reference or the load.
        amplitude: of each tone, or of the chirp, in the unit of that.
        plan: the tones.
        also: paths of states that are heard too.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 3 and 4 (best linear approximation).
    Fails to tell even distortions of a realisation's own phases from noise.
    """
    paths = [GIVEN, ASKED, SIGNAL, DEMAND, FORCE, *also]
    make = EXCITATIONS[plan.excitation]
    runs = []
    for phases in drawn_phases(plan):
        given = {name: silence() for name in EXCITED} | {
            excited: make(plan, loop.simulation.period, amplitude, phases)
        }
        data = quietly(simulate)(prepared(loop, point, given, plan), record=paths, metrics=[PistonTravel()])
        loop = stepping_as(loop, data)
        if data["diverged"] or data["stroke_left"]:
            what = "diverged" if data["diverged"] else out_of_stroke(point)
            raise ParameterError("amplitude", amplitude, f"the loop {what}")
        runs.append([steady(data, path, point) for path in paths])
    return heard(np.array(runs), paths, plan)


def out_of_stroke(point: OperatingPoint) -> str:
    """How a loop came to leave its stroke."""
    speed = abs(float(point.machine.plant.velocity))
    return (
        f"left its stroke, moving at {1e3 * speed:.3g} mm/s from its point on" if speed else "left its stroke"
    )


def stepping_as(loop: Loop, data: "xr.Dataset") -> Loop:
    """A loop with the substeps that a run of it chose: another draw of phases moves its machine as fast."""
    chosen = data.attrs.get("substeps")
    return loop if chosen is None else with_substeps(loop, int(chosen))


def silence() -> Tones:
    """Nothing, at no cost: a load is asked many times in each sample."""
    return Tones(0.0, np.empty(0), np.empty(0))


def tones_of(plan: Experiment, sample_period: float, amplitude: float, phases: Vector) -> Tones:
    """All tones at once."""
    return Tones(amplitude, plan.frequencies(sample_period), phases)


def chirp_of(plan: Experiment, sample_period: float, amplitude: float, phases: Vector) -> Chirp:
    """One that passes all tones in a period, the first phase its own."""
    w = plan.frequencies(sample_period)
    highest = min(ABOVE * float(w[-1]), HIGHEST * math.pi / sample_period)
    period = plan.period * sample_period
    lowest = BELOW * float(w[0])
    return Chirp(amplitude, lowest, math.log(highest / lowest), period, float(phases[0]))


EXCITATIONS: dict[str, Callable[[Experiment, float, float, Vector], Block]] = {
    "multisine": tones_of,
    "chirp": chirp_of,
}


def moving(plan: Experiment, commanded: Response) -> float:
    """By how much the command moves, rms, about, for an amplitude of 1.

    Args:
        plan: the tones.
        commanded: what a law asks for at each, by what is excited.
    """
    powers = 0.5 * np.abs(commanded) ** 2
    return math.sqrt(float(powers.mean() if plan.excitation == "chirp" else powers.sum()))


def steady(data: "xr.Dataset", path: str, point: OperatingPoint) -> Vector:
    """What was recorded at a path, without what it grows by about a point that moves."""
    growth = {SIGNAL: point.demand.rate, DEMAND: point.demand.rate}
    if "velocity" in point.machine.plant._fields:
        growth["plant.position"] = point.machine.plant.velocity
    return np.asarray(data[path].values - growth.get(path, 0.0) * data["time"].values)


def drawn_phases(plan: Experiment) -> Vector:
    """A row of phases [rad] for each realisation."""
    draw = np.random.default_rng(plan.seed)
    return draw.uniform(0.0, 2.0 * np.pi, (plan.realisations, plan.harmonics.size))


def prepared(loop: Loop, point: OperatingPoint, given: Mapping[str, Block], plan: Experiment) -> Loop:
    """The loop as it is excited, beginning at the point."""
    here, h = point.loop, loop.simulation.period
    share = float(getattr(here.hold, "delay", 0.0)) / h
    samples = plan.period * (1 + plan.periods)
    begin = dict(leaves(point.machine)) | dict(leaves(point.digital))
    digital = {
        f"controller.{path}" if path.startswith("controller.") else path: value
        for path, value in begin.items()
    }
    states = {path: value for path, value in digital.items() if not math.isnan(value)}
    states["controller.u"] = point.command
    return loop._replace(
        simulation=loop.simulation._replace(duration=h * samples, record_period=h),
        controller=Excited(loop.controller, given["command"], share),
        reference=ExcitedDemand(given["reference"], point.demand.value, point.demand.rate),
        load=PushedLoad(given["load"], point.force),
        start=AsBuilt(nested(states)),
    )


def heard(signals: NDArray[np.float64], paths: Sequence[str], plan: Experiment) -> Heard:
    """The spectra of recorded signals at the tones.

    Args:
        signals: shape (realisations, signals, samples).
        paths: of the signals.
        plan: the tones; the first period is left out.
    """
    runs, count, _ = signals.shape
    whole = signals[:, :, plan.period : plan.period * (1 + plan.periods)]
    split = whole.reshape(runs, count, plan.periods, plan.period)
    lines = np.fft.rfft(split - split.mean(axis=-1, keepdims=True), axis=-1)[..., plan.harmonics]
    return Heard({path: lines[:, i] for i, path in enumerate(paths)})
