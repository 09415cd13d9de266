"""What a law supposes of its loop: hypotheses of its theorem, each with its margin."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol


class Peak(NamedTuple):
    """The largest size of a signal on a run, and the instant of it [s]."""

    value: float
    time: float = math.nan


class Assumption(NamedTuple):
    """A hypothesis on a loop, asked of it.

    Attributes:
        name: in a few words.
        meaning: what must be above or below what.
        value: what is compared.
        bound: with what.
        unit: of both.
        margin: the factor by which it holds, above 1; nan where it cannot be told.
        at: the instant at which it is worst [s]; nan for one that belongs to no instant.
        measured: whether it is of a run; else of the loop's numbers.
    """

    name: str
    meaning: str
    value: float
    bound: float
    unit: str
    margin: float
    at: float = math.nan
    measured: bool = False

    @property
    def holds(self) -> bool | None:
        """None where it cannot be told."""
        return None if math.isnan(self.margin) else self.margin > 1.0


class Facts(Protocol):
    """What a loop is, as the assumptions of laws are asked about it; nan or None for what is not known.

    ``gain_margin`` is the factor on the loop's gain from which it oscillates, small or large motions,
    whichever is less. ``lag`` is by how much the command is late without the block that is asked being told:
    what it does not know of the valve's lag, and the computing delay; ``model`` what the law around it
    believes of the machine, ``truth`` what that would be of the machine as it is. Disturbances are those of
    that model, their rates the largest differences between samples over the period.
    """

    @property
    def period(self) -> float: ...
    @property
    def delay(self) -> float: ...
    @property
    def valve_lag(self) -> float: ...
    @property
    def lag(self) -> float: ...
    @property
    def disk_margin(self) -> float: ...
    @property
    def gain_margin(self) -> float: ...
    @property
    def natural_frequency(self) -> float: ...
    @property
    def limit(self) -> float: ...
    @property
    def model(self) -> Any: ...
    @property
    def truth(self) -> Any: ...
    @property
    def demand(self) -> Peak: ...
    @property
    def demand_frequency(self) -> float: ...
    @property
    def disturbances(self) -> tuple[Peak, Peak]: ...
    @property
    def disturbance_rates(self) -> tuple[Peak, Peak]: ...
    @property
    def command(self) -> Peak: ...
    @property
    def command_rate(self) -> Peak: ...
    @property
    def noise(self) -> tuple[float, float]: ...
    @property
    def overlap(self) -> float: ...
    @property
    def response(self) -> Callable[[float], complex]: ...
    def knowing_the_lag(self, time_constant: float) -> "Facts": ...


def above(
    name: str, meaning: str, value: float, bound: float | Peak, unit: str = "", *, measured: bool = False
) -> Assumption:
    """That a value is above a bound, both at least 0; its margin is the value over the bound."""
    peak = bound if isinstance(bound, Peak) else Peak(bound)
    return Assumption(
        name, meaning, value, peak.value, unit, margin_ratio(value, peak.value), peak.time, measured
    )


def below(
    name: str, meaning: str, value: float | Peak, bound: float, unit: str = "", *, measured: bool = False
) -> Assumption:
    """That a value is below a bound, both at least 0; its margin is the bound over the value."""
    peak = value if isinstance(value, Peak) else Peak(value)
    return Assumption(
        name, meaning, peak.value, bound, unit, margin_ratio(bound, peak.value), peak.time, measured
    )


def near(name: str, meaning: str, value: float, bound: float, factor: float, unit: str = "") -> Assumption:
    """That a value is within a factor of another; its margin is what is left of that; nan by 0."""
    ratio = margin_ratio(value, bound) if bound else math.nan
    off = max(ratio, margin_ratio(1.0, ratio)) if ratio > 0.0 else math.inf
    margin = math.nan if math.isnan(ratio) else margin_ratio(factor, off)
    return Assumption(name, meaning, value, bound, unit, margin)


def sampled_faster(rate: float, facts: Facts, what: str) -> Assumption:
    """That a rate [1/s] is below that of the samples."""
    return below("sample rate", f"{what} is below 1/h", rate, 1.0 / facts.period, "1/s")


def valve_faster(rate: float, facts: Facts, what: str) -> Assumption:
    """That a rate [1/s] is below one over the lag of valve and computer that the law is not told of."""
    return below(
        "valve lag", f"{what} is below one over the valve's lag", rate, margin_ratio(1.0, facts.lag), "1/s"
    )


def valve_damps(facts: Facts) -> Assumption:
    """That the valve is fast enough to damp the mass on the oil: three times as fast."""
    meaning = "its lag is below a third of one over the oil's natural frequency"
    return below("valve's speed", meaning, facts.natural_frequency * facts.valve_lag, 1.0 / 3.0)


def noise_known(name: str, believed: float, facts: Facts, signal: int) -> Assumption:
    """That the noise of a signal, 0 the velocity or 1 the hydraulic force, is what a design took it for."""
    meaning, unit = f"{name} is within a factor 3 of the noise", ("m/s", "N")[signal]
    return near("noise known", meaning, believed, facts.noise[signal], 3.0, unit)


def model_stable(facts: Facts) -> Assumption:
    """That the explicit step of a design model by a sample period is stable."""
    meaning = "omega_h h is below 2.5, where the step of its model is stable"
    return below("step of the model", meaning, facts.natural_frequency * facts.period, 2.5)


def oil_faster(rate: float, facts: Facts, what: str) -> Assumption:
    """That a rate [rad/s] is below the natural frequency of the mass on the oil."""
    meaning = f"{what} is below the oil's natural frequency"
    return below("oil", meaning, rate, facts.natural_frequency, "rad/s")


def robust(facts: Facts) -> Assumption:
    """That the loop, for small motions, bears a fifth more or less of gain."""
    meaning = "the disk margin of the loop for small motions is above 0.2"
    return above("small motions", meaning, facts.disk_margin, 0.2)


def half_of_largest(gain: float, unit: str, facts: Facts) -> Sequence[Assumption]:
    """That the proportional gain of a position law is below half of the largest; nothing of other laws.

    The law's other gains rise with it; ``unit`` is that of what it controls.
    """
    if unit != "m" or not gain > 0.0:
        return []
    if facts.gain_margin <= 1.0:  # the largest is not known
        meaning = "the loop does not oscillate with its proportional_gain"
        return [Assumption("gain", meaning, gain, math.nan, "V/m", 0.0)]
    meaning = "proportional_gain is below half of that at which the loop oscillates"
    return [below("gain", meaning, gain, 0.5 * facts.gain_margin * gain, "V/m")]


def noise_within_limit(jerk: float, facts: Facts) -> Assumption:
    """That the jerk [m/s^3] that a law makes of noise asks for less than the largest command."""
    meaning = "the command that the noise of the rate makes is below its limit"
    return below("noise", meaning, jerk / (facts.model.g1() * facts.model.g2(0.0, 0.0)), facts.limit, "V")


def disturbance_slower(name: str, bound: float, facts: Facts) -> Assumption:
    """That a bound [m/s^4] is above the rate of the hydraulic force's disturbance."""
    meaning = f"{name} is above the rate of g1 d_L2, as it is before an observer takes its part"
    fastest = Peak(facts.model.g1() * facts.disturbance_rates[1].value, facts.disturbance_rates[1].time)
    return above("disturbance's rate", meaning, bound, fastest, "m/s^4", measured=True)


def within_limit(facts: Facts) -> Assumption:
    """That the command never comes to its limit."""
    return below(
        "limits", "the command stays within its limit", facts.command, facts.limit, "V", measured=True
    )


def valve_known(time_constant: float, facts: Facts) -> Assumption:
    """That a modelled valve lags about as the valve does."""
    meaning = "tau is within a factor 2 of the valve's lag"
    return near("valve known", meaning, time_constant, facts.valve_lag, 2.0, "s")


def per_second(unit: str) -> str:
    """The unit of a rate of what has a unit."""
    return f"{unit}^2" if unit.endswith("/s") else f"{unit}/s"


def supposed(block: Any, *arguments: Any) -> Sequence[Assumption]:
    """What a part of a law supposes by its ``supposes``, if it has that."""
    return block.supposes(*arguments) if hasattr(block, "supposes") else ()


def margin_ratio(a: float, b: float) -> float:
    """a/b, infinite where b alone is 0, and nan where both are."""
    if b != 0.0:
        return a / b
    return math.nan if a == 0.0 or math.isnan(a) else math.inf
