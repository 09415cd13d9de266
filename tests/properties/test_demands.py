"""Demands and loads as functions of time: derivatives, bounds, switching instants, records."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from hydroservo import loads, references
from hydroservo.control.references import Chirp, Multisine, Ramp, Recorded, Sine, Step
from hydroservo.core.block import Block
from hydroservo.core.time_series import TimeSeries

amplitudes = st.floats(1e-3, 1.0)
frequencies = st.floats(0.01, 100.0)
instants = st.floats(0.0, 10.0)

NEAR = 1e-3  # [rad] the stencil's half width as an angle at the highest frequency
AGREED = 1e-8  # NEAR^4/30 = 3e-14 from the stencil, 1e-12/NEAR from rounding in an angle of up to 1e4 rad


def slope(signal: Callable[[float], float], t: float, h: float) -> float:
    """The five-point difference, exact on quartics."""
    near, far = signal(t + h) - signal(t - h), signal(t + 2.0 * h) - signal(t - 2.0 * h)
    return (8.0 * near - far) / (12.0 * h)


def assert_derivatives(block: Any, t: float, omega: float, amplitude: float) -> None:
    """Against differences, to AGREED of the largest value that each derivative can have."""
    demand, h = block.at(t), NEAR / omega
    assert demand.rate == pytest.approx(
        slope(lambda t: block.at(t).value, t, h), abs=AGREED * amplitude * omega
    )
    assert demand.second_rate == pytest.approx(
        slope(lambda t: block.at(t).rate, t, h), abs=AGREED * amplitude * omega**2
    )


@given(a=amplitudes, f=frequencies, phase=st.floats(-7.0, 7.0), t=instants)
def test_sine(a: float, f: float, phase: float, t: float) -> None:
    block = Sine(a, f, phase, 0.5 * a)
    assert_derivatives(block, t, 2.0 * math.pi * f, a)
    assert abs(block.at(t).value - 0.5 * a) <= a * (1.0 + 1e-15)


@given(a=amplitudes, first=frequencies, last=frequencies, sweep=st.floats(1.0, 10.0), t=st.floats(0.0, 12.0))
def test_chirp(a: float, first: float, last: float, sweep: float, t: float) -> None:
    block = Chirp(a, first, last, sweep)
    omega = 2.0 * math.pi * max(first, last)
    if abs(t - sweep) > 2.0 * NEAR / omega:  # where the second derivative jumps
        assert_derivatives(block, t, max(omega, 1.0), a)
    assert abs(block.at(t).value) <= a


@given(a=amplitudes, first=frequencies, last=frequencies, sweep=st.floats(1.0, 10.0))
def test_chirp_ends_at_its_last_frequency(a: float, first: float, last: float, sweep: float) -> None:
    """Value and rate are continuous at the end of the sweep, and from there on it is a sine."""
    block, period = Chirp(a, first, last, sweep), 1.0 / last
    before, after = block.at(sweep * (1.0 - 1e-12)), block.at(sweep)
    omega = 2.0 * math.pi * max(first, last)
    assert before.value == pytest.approx(after.value, abs=a * omega * sweep * 2e-12)
    assert before.rate == pytest.approx(after.rate, abs=a * omega**2 * sweep * 4e-12)
    later = block.at(sweep + period)
    assert later.value == pytest.approx(after.value, abs=a * 1e-10)
    assert later.second_rate == pytest.approx(-((2.0 * math.pi * last) ** 2) * later.value, rel=1e-12)


@given(a=amplitudes, f=st.floats(0.01, 5.0), n=st.integers(1, 20), t=instants)
def test_multisine(a: float, f: float, n: int, t: float) -> None:
    block = Multisine(a, f, n)
    assert_derivatives(block, t, 2.0 * math.pi * f * n, a * math.sqrt(n))
    assert abs(block.at(t).value) <= a


@pytest.mark.parametrize("n", [*range(1, 65), *range(100, 1001, 75)])
def test_crest_factor_of_the_multisine(n: int) -> None:
    """One period on a fine grid, by FFT; between its points the signal can exceed them by 1/cos(pi/64)."""
    k = np.arange(1, n + 1)
    points = 64 * 2 ** math.ceil(math.log2(n))
    spectrum = np.zeros(points, complex)
    spectrum[k] = np.exp(-1j * np.pi * k * (k - 1) / n) / math.sqrt(2.0 * n)
    period = (np.fft.ifft(spectrum) * points).imag
    block = Multisine(1.0, 0.25, n)
    for i in (0, 3, points // 3):
        assert block.at(4.0 * i / points).value == pytest.approx(period[i], abs=1e-9)
    rms, peak = np.sqrt(np.mean(period**2)), np.abs(period).max() / math.cos(math.pi / 64)
    assert rms == pytest.approx(0.5, rel=1e-12)
    assert peak / rms < 1.94


@given(
    initial=st.floats(-1.0, 1.0),
    final=st.floats(-1.0, 1.0),
    rate=amplitudes,
    start=st.floats(0.0, 1.0),
    t=instants,
)
def test_ramp(initial: float, final: float, rate: float, start: float, t: float) -> None:
    block = Ramp(initial, final, rate, start)
    change = final - initial
    end = start + abs(change) / rate
    demand = block.at(t)
    expected = (
        np.interp(t, [start, end], [initial, final]) if end > start else (final if t >= start else initial)
    )
    assert demand.value == pytest.approx(expected, abs=1e-12)
    assert demand.second_rate == 0.0
    if start < t - 1e-9 and t + 1e-9 < end:
        assert demand.rate == math.copysign(rate, change)
    if t < start or t > end + 1e-9:
        assert demand.rate == 0.0
        assert demand.value == (initial if t < start else final)


@given(sample=st.integers(1, 10**6), dt=st.floats(1e-6, 1.0), towards=st.sampled_from([0.0, math.inf]))
def test_step_switches_on_the_sample(sample: int, dt: float, towards: float) -> None:
    """Even where rounding has put the switching instant beside it."""
    time = math.nextafter(sample * dt, towards)
    demand, load = Step(-1.0, 2.0, time), loads.Step(-1.0, 2.0, time)
    for k, value in ((sample, 2.0), (sample - 1, -1.0)):
        assert demand.at(k * dt) == (value, 0.0, 0.0)
        assert load.force(k * dt) == value


@given(a=amplitudes, period=st.floats(1e-3, 1e3), t=st.floats(0.0, 1e3))
def test_square_demand_and_square_load_are_one_wave(a: float, period: float, t: float) -> None:
    demand = references.Square(a, period, 0.25).at(t)
    assert demand.value == loads.Square(a, period, 0.25).force(t)
    assert abs(demand.value - 0.25) == pytest.approx(a, rel=1e-12)
    assert (demand.rate, demand.second_rate) == (0.0, 0.0)


@given(a=amplitudes, f=frequencies, phase=st.floats(-7.0, 7.0), offset=st.floats(-1.0, 1.0), t=instants)
def test_sine_demand_and_sine_load_are_one_wave(
    a: float, f: float, phase: float, offset: float, t: float
) -> None:
    assert loads.Sine(a, f, phase, offset).force(t) == Sine(a, f, phase, offset).at(t).value


@st.composite
def records(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    steps = draw(st.lists(st.floats(1e-3, 1.0), min_size=2, max_size=30))
    samples = st.integers(-(10**6), 10**6).map(lambda n: n * 1e-6)
    values = draw(st.lists(samples, min_size=len(steps), max_size=len(steps)))
    return draw(st.floats(-1.0, 1.0)) + np.cumsum(steps), np.array(values)


@given(record=records())
def test_a_recorded_signal_reproduces_its_samples(record: tuple[np.ndarray, np.ndarray]) -> None:
    time, value = record
    blocks: list[Block] = [Recorded(TimeSeries.from_samples(time, value))]
    blocks.append(loads.Recorded(blocks[0].series))
    for t, x in zip(time.tolist(), value.tolist(), strict=True):
        assert blocks[0].at(t).value == pytest.approx(x, abs=1e-14)
        assert blocks[1].force(t) == blocks[0].at(t).value


@given(record=records(), share=st.floats(0.0, 1.0))
def test_a_recorded_signal_is_scipys_interpolant(record: tuple[np.ndarray, np.ndarray], share: float) -> None:
    time, value = record
    t = min(float(time[0] + share * (time[-1] - time[0])), float(time[-1]))  # which rounding may pass
    demand = Recorded(TimeSeries.from_samples(time, value)).at(t)
    scipys = PchipInterpolator(time, value)
    steepest = np.abs(np.diff(value) / np.diff(time)).max()
    assert demand.value == pytest.approx(float(scipys(t)), abs=1e-13)
    assert demand.rate == pytest.approx(float(scipys(t, 1)), abs=1e-12 * (1.0 + steepest))
    assert demand.second_rate == pytest.approx(
        float(scipys(t, 2)), abs=1e-12 * (1.0 + steepest) / np.diff(time).min()
    )


@given(record=records(), share=st.floats(0.0, 1.0))
def test_a_recorded_signal_never_overshoots_its_samples(
    record: tuple[np.ndarray, np.ndarray], share: float
) -> None:
    time, value = record
    t = min(float(time[0] + share * (time[-1] - time[0])), float(time[-1]))  # which rounding may pass
    i = min(int(np.searchsorted(time, t, side="right")) - 1, time.size - 2)
    low, high = sorted(value[i : i + 2].tolist())
    assert low - 1e-14 <= Recorded(TimeSeries.from_samples(time, value)).at(t).value <= high + 1e-14


@given(record=records(), beyond=st.floats(1e-6, 1e6))
def test_a_recorded_signal_is_held_outside(record: tuple[np.ndarray, np.ndarray], beyond: float) -> None:
    time, value = record
    block = Recorded(TimeSeries.from_samples(time, value))
    before, after = block.at(float(time[0]) - beyond), block.at(float(time[-1]) + beyond)
    assert before == (value[0], 0.0, 0.0)
    assert after == (pytest.approx(value[-1], abs=1e-14), 0.0, 0.0)
