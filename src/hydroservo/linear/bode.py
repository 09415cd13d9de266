"""The frequency response of a loop, from its linear model and measured on its simulation."""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.field import Field, declared_fields
from hydroservo.core.formatting import quantity
from hydroservo.core.validation import checked_number, whole_number
from hydroservo.linear.margins import Margins
from hydroservo.linear.measurement import (
    ADDED,
    ASKED,
    DEMAND,
    EXCITATIONS,
    EXCITED,
    FORCE,
    GIVEN,
    SIGNAL,
    ExcitationPlan,
    ToneSpectra,
    command_rms,
    measure_spectra,
)
from hydroservo.linear.operating_point import OperatingPoint
from hydroservo.linear.view import LoopView, compliance_signal, loop_view, responses
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.cautions import warnings_of, with_warning
from hydroservo.runs.provenance import provenance
from hydroservo.work.cores import single_threaded_algebra
from hydroservo.work.notebook_bar import shows_progress

if TYPE_CHECKING:
    import xarray as xr

Vector = NDArray[np.float64]
Progress = Callable[[float], None]

TONES = 40  # of a measurement, nearly so
LEAST, MOST = 20, 10**6  # samples in a period of all tones
QUIET = 0.01  # [V] rms, by which tones move the command
FAINTEST = 1e-12  # [V] rms, above what rounding does to a command
ONSET = 0.3  # of the time of a measurement, about, that the search of the onset takes
PUSH = 1.0  # [N] of each tone, for a law that does not feel the load
KINKED = "the loop has no slope here, and the linear model is of mean slopes"
SLID = "a valve's hysteresis leaves no slope here; the linear model is that of motions that go on"
UNSTABLE = "the loop is unstable here: nothing settles that could be measured"
MEANINGS = {
    "machine": "what is controlled by the command, the loop opened",
    "open": "loop opened at its command, L",
    "closed": "what is controlled by its demand, T",
    "sensitivity": "S = 1/(1 + L)",
    "compliance": "{moved} by the load, in its direction",
    "open_compliance": "{moved} by the load, in its direction, the command held",
}


@single_threaded_algebra()
@shows_progress
def bode(
    loop: Loop,
    *,
    command: float | None = None,
    force: float | None = None,
    band: tuple[float, float] | None = None,
    amplitude: float = QUIET,
    excitation: str = "multisine",
    periods: int = 2,
    realisations: int = 4,
    measure: bool = True,
    progress: Progress | None = None,
) -> "xr.Dataset":
    """The frequency responses of a loop about a point: from its linear model, and measured.

    The loop is measured as it is, with noise and steps of resolution, on its simulation. Many tones at once
    are added to its command, then to its demand, then to its load, with random phases; or one tone that
    passes all frequencies, a chirp. Their size is such that the linear model moves the command by
    ``amplitude``. Of realisations and periods it takes the best linear approximation, and the coherence,
    which noise and bends of the machine make less than 1.

    Where the loop has no slope, as in friction at rest, the linear model is that of the mean of both sides'
    slopes; a valve's hysteresis passes all of the command there, as of motions that go on. Margins are then
    those while the loop moves, at commands of 10 % and 50 % of its run's largest, the worst of them; and nan
    where they are not within 1.5 dB of the gain from which the loop itself oscillates
    (``oscillation_gain``). The attribute ``warning`` says which, and why.

    Args:
        loop: the loop; its demand is exchanged for the one that is fulfilled at the point.
        command: u [V] under which the machine has settled; None for that of a steady start, or 0.
        force: on the rod [N]; None for that of the load at t = 0.
        band: lowest and highest frequency [Hz]; None for what lies about the loop's crossover.
        amplitude: rms of the command's motion [V].
        excitation: "multisine", many tones at once, or "chirp".
        periods: that are heard of each realisation.
        realisations: with phases of their own.
        measure: False for the linear model alone, which is all that there is of an unstable loop.
        progress: called now and then with the fraction done.

    Returns:
        A Dataset with complex responses ``machine``, ``open``, ``closed``, ``sensitivity``, ``compliance``
        and ``open_compliance`` over ``frequency`` [Hz], the measured ones with ``_measured`` and their
        coherence with ``_coherence`` over ``tone`` [Hz], all :class:`~hydroservo.linear.Margins`,
        ``bandwidth`` (-3 dB) and ``bandwidth_90`` (-90 degrees) [Hz]. Signals are those at the samples. An
        attribute ``warning`` says where margins are from, or why there are none, and why nothing was
        measured, as of a loop that leaves its stroke meanwhile.

    Raises:
        ParameterError: there is no such point, no loop is closed, or a frequency is not below Nyquist's.


    Source: Pintelon and Schoukens, System Identification, 2012, ch. 2-4 (tones, best linear approximation);
    Astrom, Murray, Feedback Systems, 2008, ch. 9 and 12 (what the responses are).
    Fails to see between samples; and about a point that moves fast, whose position changes meanwhile.
    """
    loop = checked_loop(loop)
    checked_number(amplitude, "amplitude", Field("V", "", at_least=FAINTEST), float)
    if excitation not in EXCITATIONS:
        raise ParameterError("excitation", excitation, one_of(str(excitation), EXCITATIONS))
    whole_number("periods", periods, 1, 1000)
    whole_number("realisations", realisations, 1, 1000)
    report = progress or (lambda _: None)
    share = ONSET if measure else 1.0
    view = loop_view(loop, command, force, band, lambda done: report(share * done))
    data = linear_curves(view, view.grid)
    if not measure:
        return data
    if not view.judged.margins.stable:
        return with_warning(data, [UNSTABLE])
    plan = tone_plan(view.low, view.high, loop.simulation.period, periods, realisations)
    plan = plan._replace(excitation=excitation)
    try:
        measuring = measured_curves(
            loop, view, plan, amplitude, lambda done: report(share + (1.0 - share) * done)
        )
    except ParameterError as error:
        return with_warning(data, [f"not measured with {quantity(amplitude, 'V')}: {error.allowed}"])
    return data.assign(measuring)


def linear_curves(view: LoopView, grid: Vector) -> "xr.Dataset":
    """The linear responses at some frequencies [Hz], with margins and bandwidths."""
    import xarray as xr

    point = view.point
    linear = responses(point, view.parts, 2.0 * math.pi * grid)
    data = xr.Dataset(
        {name: ("frequency", curve, curve_attributes(name, point)) for name, curve in linear.curves.items()},
        coords={"frequency": ("frequency", grid, {"units": "Hz", "long_name": "frequency"})},
        attrs=provenance(point.loop, view.asked) | {"command": point.command, "force": point.force},
    )
    data = data.assign(scalar_variables(view))
    slid = SLID if view.slid else ""
    return with_warning(data, [slid if view.judged.linear else KINKED, view.trusted.remark])


def bode_over(
    loops: Mapping[float, Loop],
    path: str,
    unit: str,
    *,
    command: float | None = None,
    force: float | None = None,
    band: tuple[float, float] | None = None,
) -> "xr.Dataset":
    """The linear responses of loops that differ in a number, along ``point``.

    Args:
        loops: by the value of that number.
        path: where it is.
        unit: its SI unit.
        command: as :func:`hydroservo.bode` has it.
        force: likewise.
        band: likewise; None for one that holds those of all.

    Raises:
        ParameterError: as :func:`hydroservo.bode`, and the path's value.
    """
    import xarray as xr

    def one(value: float, band: tuple[float, float] | None) -> LoopView:
        try:
            return loop_view(checked_loop(loops[value]), command, force, band)
        except ParameterError as error:
            raise ParameterError(path, value, f"{error.path}: {error.allowed}") from None

    views = [one(value, band) for value in loops]
    low, high = min(view.low for view in views), max(view.high for view in views)
    views = [view._replace(low=low, high=high) for view in views]
    grid = np.unique(np.concatenate([view.grid for view in views]))
    found = [linear_curves(view, grid).drop_vars(["gain_crossovers", "phase_crossovers"]) for view in views]
    index = xr.DataArray(list(loops), dims="point", attrs={"units": unit, "long_name": path}, name="point")
    lines = [
        f"at {quantity(value, unit)}: {line}"
        for value, one in zip(loops, found, strict=True)
        for line in warnings_of(one)
    ]
    data = xr.concat(found, index, combine_attrs="override")
    data.attrs.pop("warning", None)  # the first point's
    return with_warning(data, lines)


def tone_plan(low: float, high: float, h: float, periods: int, realisations: int) -> ExcitationPlan:
    """Tones about evenly by the logarithm, all of one period."""
    period = round(min(max(1.0 / (low * h), LEAST), MOST))
    first, last = 1, max(math.floor(high * period * h), 1)
    harmonics = np.unique(np.round(np.geomspace(first, last, TONES)).astype(np.int64))
    return ExcitationPlan(harmonics, period, periods, realisations, seed=0)


def measured_curves(
    loop: Loop, view: LoopView, plan: ExcitationPlan, amplitude: float, report: Progress
) -> dict[str, Any]:
    """The measured responses and their coherence, as variables of a Dataset."""
    point, tones = view.point, plan.frequencies(loop.simulation.period)
    model = responses(point, view.parts, tones)
    moved = f"plant.{compliance_signal(point.loop)}"
    runs: dict[str, ToneSpectra] = {}
    for i, name in enumerate(EXCITED):
        moves = command_rms(plan, model.commanded[name])
        each = amplitude / moves if moves > 0.0 else PUSH
        try:
            runs[name] = measure_spectra(loop, point, name, each, plan, [moved])
        except ParameterError as error:
            raise ParameterError(
                "amplitude", amplitude, f"{error.allowed} while its {name} was excited"
            ) from None
        report((i + 1) / len(EXCITED))
    driven, ruled, loaded = (runs[name] for name in EXCITED)
    driven = driven.beside(ADDED, driven.spectra[GIVEN] - driven.spectra[ASKED])
    gives = driven.response(moved, GIVEN)
    circulates = -driven.response(ASKED, ADDED) / driven.response(GIVEN, ADDED)
    coherent = np.minimum(driven.coherence(ASKED, ADDED), driven.coherence(GIVEN, ADDED))
    curves = {
        "machine": (driven.response(SIGNAL, GIVEN), driven.coherence(SIGNAL, GIVEN)),
        "open": (circulates, coherent),
        "closed": (ruled.response(SIGNAL, DEMAND), ruled.coherence(SIGNAL, DEMAND)),
        "compliance": (-loaded.response(moved, FORCE), loaded.coherence(moved, FORCE)),
    }
    held = loaded.response(moved, FORCE) - gives * loaded.response(GIVEN, FORCE)
    curves["open_compliance"] = (-held, curves["compliance"][1])
    frequencies = tones / (2.0 * math.pi)
    found: dict[str, Any] = {"tone": ("tone", frequencies, {"units": "Hz", "long_name": "frequency"})}
    for name, (curve, coherence) in curves.items():
        found[f"{name}_measured"] = ("tone", curve, curve_attributes(name, point))
        found[f"{name}_coherence"] = ("tone", coherence, {"units": "", "long_name": "coherence"})
    return found


def curve_attributes(name: str, point: OperatingPoint) -> dict[str, str]:
    """Unit and meaning of a response."""
    signal, moved = point.loop.controls.declared(), compliance_signal(point.loop)
    units = {"machine": f"{signal.unit}/V", "compliance": "m/(s N)" if moved == "velocity" else "m/N"}
    unit = units.get(name.removeprefix("open_"), "")
    return {"units": unit, "long_name": MEANINGS[name].format(moved=moved)}


def scalar_variables(view: LoopView) -> dict[str, Any]:
    """Margins and bandwidths as variables of a Dataset."""
    found = view.trusted.margins
    fields = declared_fields(Margins)
    said: dict[str, Any] = {
        name: ((), value, {"units": fields[name].unit, "long_name": fields[name].meaning})
        for name, value in found._asdict().items()
        if not isinstance(value, tuple)
    }
    for name in ("gain_crossovers", "phase_crossovers"):
        about = {"units": fields[name].unit, "long_name": fields[name].meaning}
        said[name] = (name.removesuffix("s"), np.array(getattr(found, name)), about)
    about = {"units": "", "long_name": "least factor on the gain from which the loop oscillates for good"}
    return said | {"oscillation_gain": ((), view.onset, about)} | bandwidths(view)


def bandwidths(view: LoopView) -> dict[str, Any]:
    """Where the closed loop falls 3 dB below its slow motions, and where it lags 90 degrees [Hz].

    Both are nan of an unstable loop, which nothing settles in, and where the point's own margins do not hold.
    """
    fallen = late = math.nan
    if view.judged.margins.stable and view.trusted.here:
        grid = view.usual
        closed = responses(view.point, view.parts, 2.0 * math.pi * grid).curves["closed"]
        size, phase = np.abs(closed), np.unwrap(np.angle(closed))
        fallen = first_below(grid, size / size[0] - math.sqrt(0.5))
        late = first_below(grid, phase + 0.5 * math.pi)
    return {
        "bandwidth": ((), fallen, {"units": "Hz", "long_name": "where T is 3 dB below its slow motions"}),
        "bandwidth_90": ((), late, {"units": "Hz", "long_name": "where T lags 90 degrees"}),
    }


def first_below(grid: Vector, above: Vector) -> float:
    """The frequency at which a number first falls below 0, between two of a grid; nan if it never does."""
    below = np.flatnonzero(above < 0.0)
    if not below.size or below[0] == 0:
        return math.nan
    i = below[0]
    share = above[i - 1] / (above[i - 1] - above[i])
    return float(grid[i - 1] * (grid[i] / grid[i - 1]) ** share)
