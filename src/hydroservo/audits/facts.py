"""What a loop is, as the assumptions of its law are asked about it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.audits.describing import command_limit
from hydroservo.audits.monitors import CommandPeaks, CommandPeaksValues, Lumped, LumpedValues
from hydroservo.control.loop import Loop
from hydroservo.control.wiring import believed
from hydroservo.core.assumptions import Peak
from hydroservo.core.block import Block, model_in, values
from hydroservo.core.errors import ParameterError
from hydroservo.core.signals import Draws
from hydroservo.core.states import filled
from hydroservo.cosimulation import refuse_fmus
from hydroservo.linear import Linearization, linearize
from hydroservo.linear.moving_margins import largest_command, points_in_motion
from hydroservo.linear.view import LoopView, known_onset, loop_view
from hydroservo.runs.cautions import quietly
from hydroservo.runs.run import runnable_loop, simulate

Matrix = NDArray[np.float64]

LOOKS = 4096  # instants of a run at which its demand is looked at
SAMPLES = 400  # of sensors, from which their noise is known
STEP, LONG = 1.0, 2.0  # [V] and [s], of the step that a valve's lag is taken from
INSTANT = 1e100  # a state's rate, beyond which there is no lag


@dataclass(frozen=True)
class LoopFacts:
    """A loop's :class:`~hydroservo.core.assumptions.Facts`."""

    given: Loop  # the loop
    loop: Loop  # the same, ready to run
    model: Any  # what the law believes of the machine; None if nothing
    # the disturbances of a run; None where there was none, it was lost, or its machine has no model
    found: LumpedValues | None
    # the largest commands of a run; None where there was none, or it was lost
    commands: CommandPeaksValues | None = None
    known_lag: float = 0.0  # what the block that is asked is told of the valve's lag [s]

    @property
    def period(self) -> float:
        return float(self.loop.simulation.period)

    @property
    def delay(self) -> float:
        return float(getattr(self.loop.hold, "delay", 0.0))

    @property
    def limit(self) -> float:
        return command_limit(self.loop.controller)

    def knowing_the_lag(self, time_constant: float) -> "LoopFacts":
        return replace(self, known_lag=time_constant)

    @property
    def lag(self) -> float:
        return abs(self.valve_lag - self.known_lag) + self.delay

    @cached_property
    def view(self) -> LoopView | None:
        """The loop as ``bode`` has it; None where it has no operating point."""
        try:
            return loop_view(self.given, None, None, None)
        except ParameterError:
            return None

    @property
    def disk_margin(self) -> float:
        """For small motions; 0 of an unstable loop, and nan where there is none."""
        if self.view is None:
            return math.nan
        return self.view.trusted.margins.disk_margin if self.view.judged.margins.stable else 0.0

    @cached_property
    def gain_margin(self) -> float:
        """The least of the onset of oscillation and the gain margins in motion; 1 of an unstable loop."""
        if self.view is not None and not self.view.judged.margins.stable:
            return 1.0
        moving = [judged.margins for _, judged in points_in_motion(self.given, largest_command(self.given))]
        found = [one.gain_margin if one.stable else 1.0 for one in moving]
        onset = known_onset(self.given, None) if self.view is None else self.view.onset
        return min((one for one in (*found, onset) if not math.isnan(one)), default=math.nan)

    @cached_property
    def truth(self) -> Any:
        try:
            return believed(self.loop)
        except ParameterError:
            return None

    @cached_property
    def machine(self) -> Linearization | None:
        """The machine at rest, linearised; None where it has no steady state."""
        try:
            return linearize(self.loop, command=0.0)
        except ParameterError:
            return None

    def response(self, frequency: float) -> complex:
        """The controlled signal per command, small about rest, its command held over a sample and delayed."""
        if self.machine is None:
            return complex(math.nan, math.nan)
        s, h = 1j * frequency, self.period
        late = np.exp(-s * (self.delay + 0.5 * h)) * np.sinc(0.5 * frequency * h / math.pi)
        return complex(self.machine.response([frequency], "controlled", "command")[0] * late)

    @cached_property
    def valve_lag(self) -> float:
        """The time by which the opening is behind a step of the command [s]; 0 of a valve without states."""
        from scipy.integrate import solve_ivp

        valve, state = self.loop.valve, self.loop.valve.init()
        if not values(state):
            return 0.0

        def rates(_: float, numbers: Matrix) -> list[float]:
            here = filled(state, iter(numbers[:-1].tolist()))
            return [*values(valve.deriv(here, STEP)), valve.opening(here, STEP)]

        begun = np.array([*values(state), 0.0])
        if not np.abs(rates(0.0, begun)).max() < INSTANT:
            return 0.0
        found = solve_ivp(rates, (0.0, LONG), begun, "LSODA", rtol=1e-8, atol=1e-14, max_step=0.05)
        *settled, passed = found.y[:, -1].tolist()
        end = valve.opening(filled(state, iter(settled)), STEP)
        return float(LONG - passed / end) if end else math.nan

    @cached_property
    def natural_frequency(self) -> float:
        truth = self.truth
        if truth is None:
            return math.nan
        return math.sqrt(-truth.g1() * truth.f2(1.0, 0.0))

    @cached_property
    def overlap(self) -> float:
        lap = getattr(getattr(self.loop.valve, "orifice", None), "lap", 0.0)
        gain = getattr(self.loop.valve, "gain", math.nan)
        return max(lap, 0.0) / gain

    @cached_property
    def demands(self) -> tuple[Matrix, Matrix]:
        """Instants over the run [s], and the demand then."""
        times = np.linspace(0.0, self.loop.simulation.duration, LOOKS, endpoint=False)
        return times, np.array([self.loop.reference.at(float(t)).value for t in times])

    @property
    def demand(self) -> Peak:
        times, demand = self.demands
        worst = int(np.argmax(np.abs(demand)))
        return Peak(float(abs(demand[worst])), float(times[worst]))

    @property
    def demand_frequency(self) -> float:
        """Of the strongest tone of the demand [Hz], by the sine that is nearest; nan for none."""
        times, demand = self.demands
        demand = np.ldexp(demand, -math.frexp(np.abs(demand).max())[1])  # exact, and squares are not lost
        left = demand - demand.mean()
        if not np.abs(left).max() > 0.0:
            return math.nan
        span = times[-1] + times[1]

        def missed(frequency: float) -> float:
            phase = 2.0 * math.pi * frequency * times
            table = np.column_stack([np.ones_like(times), np.cos(phase), np.sin(phase)])
            missing: float = np.linalg.lstsq(table, demand, rcond=None)[1].sum()
            return missing

        from scipy.optimize import minimize_scalar

        tries = np.arange(1, 400) * (0.25 / span)
        best = min(tries, key=missed)
        step = 0.25 / span
        bounds = (max(best - step, 1e-3 * step), best + step)
        return float(minimize_scalar(missed, bounds=bounds, method="bounded", options={"xatol": 1e-6}).x)

    @cached_property
    def noise(self) -> tuple[float, float]:
        """rms of the noise of the velocity [m/s] and of the hydraulic force [N], of the machine at rest."""
        loop, h = self.loop, self.period
        state = loop.init()
        seen = loop.seen(state, loop.load.force(0.0))
        sensors, heard = state.sensors, []
        for k in range(SAMPLES):
            draws = Draws(float(loop.simulation.seed), 0.0, float(k))
            sensors = loop.sensors.step(sensors, seen, draws, h)
            y = loop.sensors.measure(sensors, seen, 0.0)
            heard.append((y.velocity, y.hydraulic_force))
        velocity, force = np.std(heard, axis=0).tolist()
        return float(velocity), float(force)

    def peaks(self, *names: str) -> tuple[Peak, ...]:
        return tuple(peak_in(self.found, name) for name in names)

    @property
    def disturbances(self) -> tuple[Peak, Peak]:
        first, second = self.peaks("largest_1", "largest_opened" if self.known_lag else "largest_2")
        return first, second

    @property
    def disturbance_rates(self) -> tuple[Peak, Peak]:
        first, second = self.peaks("rate_1", "rate_opened" if self.known_lag else "rate_2")
        return first, second

    @property
    def command(self) -> Peak:
        return peak_in(self.commands, "command")

    @property
    def command_rate(self) -> Peak:
        return peak_in(self.commands, "command_rate")


def peak_in(found: Any, name: str) -> Peak:
    """One of the sizes of a monitor with its instant; nan of None."""
    return Peak(math.nan) if found is None else Peak(getattr(found, name), getattr(found, f"{name}_at"))


def lumped_monitor(loop: Loop) -> Lumped | None:
    """The monitor that a run needs for the facts of a loop, which is ready to run; None if it has no model.

    It is that of the law's model, or of the machine as it is.
    """
    gain = getattr(loop.valve, "gain", None)
    if not isinstance(gain, float):
        return None
    try:
        model = model_in(loop.controller) or believed(loop)
    except ParameterError:
        return None
    return Lumped(model, gain)


def facts_of(loop: Loop, record: Sequence[str] = (), watching: Sequence[Block] = ()) -> tuple[LoopFacts, Any]:
    """The facts of a loop, after a run of it, and that run."""
    refuse_fmus(loop, "audit it")
    begun = runnable_loop(loop)
    monitor = lumped_monitor(begun)
    monitors = [*watching, CommandPeaks(), *([monitor] if monitor else [])]
    data = quietly(simulate)(loop, record=record, metrics=monitors)
    found = commands = None
    if not bool(data["diverged"]):
        commands = CommandPeaksValues(*(float(data[name]) for name in CommandPeaksValues._fields))
        if monitor is not None:
            found = LumpedValues(*(float(data[name]) for name in LumpedValues._fields))
    return LoopFacts(loop, begun, model_in(begun.controller), found, commands), data
