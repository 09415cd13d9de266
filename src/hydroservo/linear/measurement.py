"""Frequency responses and margins measured on the nonlinear simulation, by tones or a chirp."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.monitors import PistonTravel
from hydroservo.core.block import Block, leaves
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import number
from hydroservo.core.group import nested
from hydroservo.linear.excitation import ExcitationChirp, Excited, ExcitedDemand, PushedLoad, Tones
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
COHERENT = 0.9  # of the tones on both sides of a crossover, at least


class ExcitationPlan(NamedTuple):
    """How a loop is excited."""

    harmonics: NDArray[np.int64]  # numbers of the tones among those of the period, rising, shape (tones,)
    period: int  # of all tones together, in samples
    periods: int  # that are heard, after one in which the loop settles
    realisations: int  # each with phases of its own, drawn at random
    seed: int  # of the draws
    excitation: str = "multisine"  # "multisine", all tones at once, or "chirp", one that passes them

    def frequencies(self, sample_period: float) -> Vector:
        """Of the tones [rad/s]."""
        return np.asarray(2.0 * np.pi * self.harmonics / (self.period * sample_period))


class ToneSpectra(NamedTuple):
    """Spectra of signals at the tones, shape (realisations, periods, tones), by the signal's path."""

    spectra: dict[str, Response]

    def response(self, output: str, input_: str) -> Response:
        """The best linear approximation: the mean of Y U* by that of |U|^2 of realisations and periods."""
        y, u = self.spectra[output], self.spectra[input_]
        return np.asarray((y * u.conj()).mean((0, 1)) / (np.abs(u) ** 2).mean((0, 1)))

    def beside(self, name: str, spectrum: Response) -> "ToneSpectra":
        """With one more signal."""
        return ToneSpectra(self.spectra | {name: spectrum})

    def coherence(self, output: str, input_: str) -> Vector:
        """|mean of Y U*|^2 by the means of |Y|^2 and |U|^2: below 1 by noise, and by what is not linear."""
        y, u = self.spectra[output], self.spectra[input_]
        cross = np.abs((y * u.conj()).mean((0, 1))) ** 2
        power = (np.abs(y) ** 2).mean((0, 1)) * (np.abs(u) ** 2).mean((0, 1))
        return np.asarray(cross / np.maximum(power, LEAST_POWER))


def measure_spectra(
    loop: Loop,
    point: OperatingPoint,
    excited: str,
    amplitude: float,
    plan: ExcitationPlan,
    also: Sequence[str],
) -> ToneSpectra:
    """What a loop answers to tones, about a point.

    It is simulated as it is, with noise and steps of resolution, from the point on. Each realisation draws
    its phases; a period passes before it is heard. Without noise the periods of one realisation are alike,
    and what differs between realisations is what is not linear.

    Source: Pintelon and Schoukens, System Identification, 2012, ch. 3 and 4 (best linear approximation).
    Fails to tell even distortions of a realisation's own phases from noise.
    """
    paths = [GIVEN, ASKED, SIGNAL, DEMAND, FORCE, *also]
    make = EXCITATIONS[plan.excitation]
    runs = []
    draw = np.random.default_rng(plan.seed)
    for phases in draw.uniform(0.0, 2.0 * np.pi, (plan.realisations, plan.harmonics.size)):
        given = {name: silence() for name in EXCITED} | {
            excited: make(plan, loop.simulation.period, amplitude, phases)
        }
        data = quietly(simulate)(
            excited_loop(loop, point, given, plan), record=paths, metrics=[PistonTravel()]
        )
        if "substeps" in data.attrs:  # another draw of phases moves its machine as fast
            loop = with_substeps(loop, int(data.attrs["substeps"]))
        if data["diverged"] or data["stroke_left"]:
            what = "diverged" if data["diverged"] else out_of_stroke(point)
            raise ParameterError("amplitude", amplitude, f"the loop {what}")
        runs.append([without_growth(data, path, point) for path in paths])
    return tone_spectra(np.array(runs), paths, plan)


def out_of_stroke(point: OperatingPoint) -> str:
    """How a loop came to leave its stroke."""
    speed = abs(float(point.machine.plant.velocity))
    return (
        f"left its stroke, moving at {1e3 * speed:.3g} mm/s from its point on" if speed else "left its stroke"
    )


def silence() -> Tones:
    """Nothing, at no cost: a load is asked many times in each sample."""
    return Tones(0.0, np.empty(0), np.empty(0))


def tones_of(plan: ExcitationPlan, sample_period: float, amplitude: float, phases: Vector) -> Tones:
    return Tones(amplitude, plan.frequencies(sample_period), phases)


def chirp_of(plan: ExcitationPlan, sample_period: float, amplitude: float, phases: Vector) -> ExcitationChirp:
    """One that passes all tones in a period, the first phase its own."""
    w = plan.frequencies(sample_period)
    highest = min(ABOVE * float(w[-1]), HIGHEST * math.pi / sample_period)
    period = plan.period * sample_period
    lowest = BELOW * float(w[0])
    return ExcitationChirp(amplitude, lowest, math.log(highest / lowest), period, float(phases[0]))


EXCITATIONS: dict[str, Callable[[ExcitationPlan, float, float, Vector], Block]] = {
    "multisine": tones_of,
    "chirp": chirp_of,
}


def command_rms(plan: ExcitationPlan, commanded: Response) -> float:
    """By how much the command moves, rms, about, for an amplitude of 1."""
    powers = 0.5 * np.abs(commanded) ** 2
    return math.sqrt(float(powers.mean() if plan.excitation == "chirp" else powers.sum()))


def without_growth(data: "xr.Dataset", path: str, point: OperatingPoint) -> Vector:
    """What was recorded at a path, without what it grows by about a point that moves."""
    growth = {SIGNAL: point.demand.rate, DEMAND: point.demand.rate}
    if "velocity" in point.machine.plant._fields:
        growth["plant.position"] = point.machine.plant.velocity
    return np.asarray(data[path].values - growth.get(path, 0.0) * data["time"].values)


def excited_loop(loop: Loop, point: OperatingPoint, given: Mapping[str, Block], plan: ExcitationPlan) -> Loop:
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


def tone_spectra(signals: NDArray[np.float64], paths: Sequence[str], plan: ExcitationPlan) -> ToneSpectra:
    """The spectra of recorded signals at the tones."""
    runs, count, _ = signals.shape
    whole = signals[:, :, plan.period : plan.period * (1 + plan.periods)]
    split = whole.reshape(runs, count, plan.periods, plan.period)
    lines = np.fft.rfft(split - split.mean(axis=-1, keepdims=True), axis=-1)[..., plan.harmonics]
    return ToneSpectra({path: lines[:, i] for i, path in enumerate(paths)})


class Crossing(NamedTuple):
    """A margin, and where it is from."""

    margin: float  # a factor for the gain, [rad] for the phase; nan where there is none
    frequency: float  # of the crossover [Hz]
    remark: str  # why there is no margin; empty where there is one


def measured_margins(data: "xr.Dataset") -> tuple[Crossing, Crossing]:
    """The gain margin and the phase margin of a measured loop, with lines between its tones.

    The least margin counts. One is given only where the tones on both sides of every crossover have a
    coherence of 0.9.

    Source: Astrom, Murray, Feedback Systems, 2008, sec. 9.3.
    Fails for crossovers between two tones that cross twice.
    """
    response, coherence = data["open_measured"].values, data["open_coherence"].values
    tones = data["tone"].values
    with np.errstate(divide="ignore"):  # of a tone that nothing answers, whose coherence is 0
        size = np.log(np.abs(response))
    phase = np.unwrap(np.angle(response))
    turned = np.sin(0.5 * phase + 0.5 * math.pi)  # 0 at -180 degrees, and every turn from there
    gain = least_crossing(turned, -size, tones, coherence, "\N{MINUS SIGN}180\N{DEGREE SIGN}")
    late = np.abs(np.remainder(phase, 2.0 * math.pi) - math.pi)
    return (gain._replace(margin=math.exp(gain.margin)), least_crossing(size, late, tones, coherence, "0 dB"))


def least_crossing(crossed: Vector, margin: Vector, tones: Vector, coherence: Vector, level: str) -> Crossing:
    """The least margin above 0 where another number is 0, by lines over the logarithm of the frequency."""
    found = []
    for i in np.flatnonzero(np.sign(crossed[:-1]) * np.sign(crossed[1:]) < 0.0):
        share = crossed[i] / (crossed[i] - crossed[i + 1])
        frequency = float(tones[i] * (tones[i + 1] / tones[i]) ** share)
        weakest = float(coherence[i : i + 2].min())
        if weakest < COHERENT:
            heard = f"coherence {weakest:.2f} at {number(frequency)} Hz"
            return Crossing(math.nan, frequency, f"{heard}; try a larger --amplitude or another --band")
        value = float(margin[i] + share * (margin[i + 1] - margin[i]))
        if value > 0.0:
            found.append(Crossing(value, frequency, ""))
    none = Crossing(math.nan, math.nan, f"no tone near {level}: widen --band")
    return min(found, key=lambda one: one.margin, default=none)
