"""Single sensors against the formulas of their errors, and what they make together."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydroservo import Loop, Simulation, ops, replace, simulate
from hydroservo.control.controllers import PI
from hydroservo.core.block import Block
from hydroservo.core.signals import Draws, MachineOutputs, Measurement
from hydroservo.machine.sensors import (
    DelayedSensors,
    Difference,
    Dropout,
    Encoder,
    ExactDifferentiator,
    ExactDifferentiatorState,
    FilteredDifference,
    IdealPosition,
    IdealSensors,
    LoadCell,
    NoisySensors,
    PressureTransducer,
    RigSensors,
    VelocitySensor,
)
from hydroservo.testing.examples import example

H = 1e-3
COUNT = 1e-6
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
MACHINE = MachineOutputs(0.1, 491.0, 0.03, 2.5e6, 1.5e6, 0.0)
EXACT = PressureTransducer(range_low=-1e9, range_high=1e9, noise=0.0, bits=0)


def draws(sample: int, stream: float = 0.0) -> Draws:
    return Draws(7.0, stream, float(sample))


def rms(values: Iterable[float]) -> float:
    return float(np.sqrt(np.mean(np.square([*values]))))


def read(sensor: Any, positions: Sequence[float]) -> np.ndarray:
    """What a position sensor reads, one after the other."""
    s, found = sensor.init(), []
    for k, x in enumerate(positions):
        s = sensor.step(s, float(x), draws(k), H)
        found.append(s.value)
    return np.array(found)


def velocities(estimator: Any, positions: Sequence[float], h: float = H) -> np.ndarray:
    s, found = estimator.init(), []
    for k, x in enumerate(positions):
        s = estimator.step(s, MACHINE, float(x), draws(k), h)
        found.append(s.value)
    return np.array(found)


def pressures(sensor: PressureTransducer, given: Sequence[float]) -> np.ndarray:
    s, found = sensor.init(), []
    for k, pressure in enumerate(given):
        s = sensor.step(s, float(pressure), draws(k), H)
        found.append(s.value)
    return np.array(found)


def measurements(sensors: Any, machines: Sequence[MachineOutputs], stream: float = 0.0) -> list[Measurement]:
    s, found = sensors.init(), []
    for k, machine in enumerate(machines):
        s = sensors.step(s, machine, draws(k, stream), H)
        found.append(sensors.measure(s, machine, float(k)))
    return found


def moving(samples: int) -> list[MachineOutputs]:
    """A machine none of whose outputs repeats itself."""
    return [
        MachineOutputs(1.0 + k, 2.0 + 3.0 * k, 3.0 + 5.0 * k, 1e5 + k, 2e5 + k, 0.0) for k in range(samples)
    ]


# Position


@given(st.floats(-0.1, 0.1), st.floats(1e-7, 1e-3))
def test_an_encoder_reads_whole_counts_and_errs_by_half_of_one_at_most(x: float, count: float) -> None:
    value = read(Encoder(count), [x])[0]
    assert value / count == pytest.approx(round(value / count), abs=1e-6)
    assert abs(value - x) <= 0.5 * count * (1.0 + 1e-9) + 1e-16


def test_an_encoders_error_over_a_ramp_is_that_of_even_rounding() -> None:
    """Steps of an irrational number of counts meet all parts of a count alike."""
    x = COUNT * GOLDEN * np.arange(20_000)
    error = read(Encoder(COUNT), x) - x
    assert rms(error) == pytest.approx(COUNT / math.sqrt(12.0), rel=1e-3)
    assert abs(error.mean()) < 1e-3 * COUNT


def test_an_ideal_position_is_the_position() -> None:
    assert [*read(IdealPosition(), [0.1, 0.25])] == [0.1, 0.25]


# Velocity


@pytest.mark.parametrize(
    "estimator",
    [Difference(), example(FilteredDifference), example(ExactDifferentiator)],
    ids=lambda e: type(e).__name__,
)
def test_estimates_start_at_rest_wherever_the_piston_is(estimator: Block) -> None:
    assert [*velocities(estimator, [0.05] * 3)] == [0.0] * 3


@pytest.mark.parametrize("fraction", [GOLDEN, math.sqrt(2.0) - 1.0, 0.1 * math.sqrt(2.0)])
def test_a_differences_error_at_constant_speed(fraction: float) -> None:
    """It is 1 - f counts in a share f of the samples, and -f counts in the others."""
    x = COUNT * (3.0 + fraction) * np.arange(20_000)
    error = velocities(Difference(), read(Encoder(COUNT), x))[1:] - (x[1] - x[0]) / H
    assert rms(error) == pytest.approx(COUNT * math.sqrt(fraction * (1.0 - fraction)) / H, rel=1e-3)


def test_a_differences_error_over_all_speeds_is_that_of_two_independent_roundings() -> None:
    k = np.arange(100_000)
    x = COUNT * (0.5 * k**2 * (10.0 * GOLDEN / k.size))  # from rest to 6.2 counts a sample
    x[k.size // 2 :] += 0.3 * COUNT * GOLDEN
    error = velocities(Difference(), read(Encoder(COUNT), x))[1:] - np.diff(x) / H
    assert np.abs(error).max() <= COUNT / H * (1.0 + 1e-9)
    assert rms(error) == pytest.approx(COUNT / (math.sqrt(6.0) * H), rel=0.02)


def test_a_filtered_difference_lags_by_its_time_constant_and_half_a_period() -> None:
    acceleration, t = 2.0, H * np.arange(2000)
    found = velocities(FilteredDifference(5e-3), 0.5 * acceleration * t**2)
    assert found[-1] == pytest.approx(acceleration * (t[-1] - 5e-3 - 0.5 * H), rel=1e-9)
    assert velocities(FilteredDifference(5e-3), 0.3 * t)[-1] == pytest.approx(0.3, rel=1e-9)


@pytest.mark.parametrize("time_constant", [1e-3, 1e-2])
def test_a_filtered_differences_noise(time_constant: float) -> None:
    noise = [COUNT * ops.normal(3.0, 0.0, float(k)) for k in range(40_000)]
    found = velocities(FilteredDifference(time_constant), noise)[100:]
    expected = COUNT * math.sqrt(2.0 / ((time_constant + H) * (2.0 * time_constant + H)))
    assert rms(found) == pytest.approx(expected, rel=0.03)


@given(
    st.floats(-1e-3, 1e-3),
    st.floats(-0.1, 0.1),
    st.floats(0.1, 100.0),
    st.floats(0.1, 3.0),
    st.floats(1.0, 3.0),
)
def test_a_differentiators_step_solves_its_inclusion(
    offset: float, velocity: float, L: float, gain_1: float, gain_2: float
) -> None:
    """z_1 and z_2 of the next instant satisfy both equations there, with one xi in Sgn(e)."""
    before, x = ExactDifferentiatorState(velocity, 0.04 + offset), 0.04
    after = ExactDifferentiator(L, gain_1, gain_2).step(before, MACHINE, x, draws(0), H)
    e = after.position - x
    xi = (before.value - after.value) / (H * gain_2 * L)
    assert abs(xi) <= 1.0 + 1e-9
    if abs(e) > 1e-12:
        assert xi == pytest.approx(math.copysign(1.0, e), rel=1e-9)
    root = math.copysign(math.sqrt(abs(e)), e)
    slope = after.value - gain_1 * math.sqrt(L) * root
    assert after.position == pytest.approx(
        before.position + H * slope, rel=0.0, abs=2e-15 + 1e-8 * H * abs(root)
    )


def test_a_differentiator_meets_a_ramp_after_a_finite_time() -> None:
    found = velocities(ExactDifferentiator(10.0), 0.01 + 0.03 * H * np.arange(200))
    assert abs(found[3] - 0.03) > 1e-4
    assert np.abs(found[100:] - 0.03).max() < 1e-12


@pytest.mark.parametrize("h", [1e-3, 1e-4])
def test_a_differentiators_error_on_a_parabola_is_bound_by_half_a_period(h: float) -> None:
    t = h * np.arange(2000)
    for L in (2.0, 5.0):
        found = velocities(ExactDifferentiator(L), 0.5 * 2.0 * t**2, h)
        late = np.abs(found - 2.0 * t)[1000:].max()
        assert 0.0 < late <= 0.5 * h * L * (1.0 + 1e-6)


def explicit(positions: Sequence[float], start: ExactDifferentiatorState, L: float) -> np.ndarray:
    """The differentiator with a forward step, as it is usually programmed."""
    z1, z2, found = start.position, start.value, []
    for x in positions:
        e = z1 - x
        sign = math.copysign(1.0, e) if e else 0.0
        z1, z2 = z1 + H * (z2 - 1.5 * math.sqrt(L * abs(e)) * sign), z2 - H * 1.1 * L * sign
        found.append(z2)
    return np.array(found)


def test_a_differentiator_does_not_chatter_at_rest_where_its_explicit_form_does() -> None:
    start, L = ExactDifferentiatorState(0.01, 0.0), 10.0
    s, found = start, []
    for k in range(2000):
        s = ExactDifferentiator(L).step(s, MACHINE, 0.0, draws(k), H)
        found.append(s.value)
    variation = np.abs(np.diff(found[1000:])).sum()
    chatter = np.abs(np.diff(explicit([0.0] * 2000, start, L)[1000:])).sum()
    assert variation == 0.0
    assert chatter == pytest.approx(999 * H * 1.1 * L, rel=1e-9)  # a full step each sample


def test_a_differentiator_smooths_what_a_difference_does_not() -> None:
    """A slow sine seen through counts at 10 kHz, where a count is 10 mm/s."""
    h = 1e-4
    t = h * np.arange(40_000)
    w = 0.5 * math.pi
    counted = read(Encoder(COUNT), 0.03 / w * (1.0 - np.cos(w * t)))
    true = 0.03 * np.sin(w * t)
    errors = [
        rms((velocities(one, counted, h) - true)[1000:]) for one in (Difference(), ExactDifferentiator(1.0))
    ]
    assert errors[1] < 0.2 * errors[0]


def test_a_differentiator_with_a_wide_bound_is_the_difference() -> None:
    counted = read(Encoder(COUNT), 0.03 * H * np.arange(500))
    found = velocities(ExactDifferentiator(1e3), counted)
    assert found[100:] == pytest.approx(velocities(Difference(), counted)[100:], rel=0.0, abs=1e-12)


def test_a_velocity_sensor_sees_the_machine_and_not_the_position() -> None:
    assert [*velocities(VelocitySensor(), [1.0, 2.0, 3.0])] == [MACHINE.velocity] * 3
    noisy = velocities(VelocitySensor(1e-3), [0.0] * 20_000) - MACHINE.velocity
    assert rms(noisy) == pytest.approx(1e-3, rel=0.02)


# Pressure


def test_a_transducer_is_clipped_to_its_range() -> None:
    for bits in (0, 12):
        low, high = pressures(PressureTransducer(-1e5, 60e5, 0.0, bits=bits), [-5e5, 70e5])
        assert low == -1e5
        assert high == 60e5 - (61e5 / 2**12 if bits else 0.0)


@given(st.floats(0.0, 59e5), st.integers(6, 20))
def test_a_converters_code_is_the_nearest_one(pressure: float, bits: int) -> None:
    step = 60e5 / 2**bits
    value = pressures(example(PressureTransducer, noise=0.0, bits=bits), [pressure])[0]
    assert value / step == round(value / step)
    assert abs(value - pressure) <= 0.5 * step * (1.0 + 1e-12)


def test_a_transducers_noise_and_offset_are_shares_of_its_span() -> None:
    found = pressures(PressureTransducer(-1e5, 60e5, 0.005, offset=0.01, bits=0), [30e5] * 20_000) - 30e5
    assert found.mean() == pytest.approx(0.01 * 61e5, rel=0.02)
    assert found.std() == pytest.approx(0.005 * 61e5, rel=0.02)


def test_rounding_of_a_converter_adds_to_the_noise() -> None:
    """Where the noise covers a step, the powers add: sigma^2 + q^2/12."""
    sensor = example(PressureTransducer, noise=0.002, bits=8)
    step = 60e5 / 2**8
    found = pressures(sensor, [30e5 + 0.3 * step] * 40_000) - (30e5 + 0.3 * step)
    assert rms(found) == pytest.approx(math.sqrt((0.002 * 60e5) ** 2 + step**2 / 12.0), rel=0.02)


def test_a_transducers_own_lag() -> None:
    """The share that is left of a step after n samples is (tau/(tau + h))^n; it starts at the first one."""
    sensor = example(PressureTransducer, noise=0.0, bits=0, time_constant=4.0 * H)
    found = pressures(sensor, [10e5, *[20e5] * 9])
    assert found == pytest.approx(20e5 - 10e5 * 0.8 ** np.arange(10), rel=1e-12)


# Together


def test_a_rig_with_ideal_parts_sees_what_ideal_sensors_see() -> None:
    area = MACHINE.hydraulic_force / (MACHINE.pressure_a - MACHINE.pressure_b)
    rig = RigSensors(IdealPosition(), VelocitySensor(), EXACT, EXACT, area, area, LoadCell(0.0))
    found, expected = (measurements(one, [MACHINE])[0] for one in (rig, IdealSensors()))
    assert found == pytest.approx(expected, rel=1e-12)


def test_the_hydraulic_force_is_that_of_the_known_areas() -> None:
    rig = example(RigSensors, pressure_a=EXACT, pressure_b=EXACT, area_a=5e-4, area_b=3e-4)
    y = measurements(rig, [MACHINE])[0]
    assert y.hydraulic_force == 5e-4 * y.pressure_a - 3e-4 * y.pressure_b
    assert y.hydraulic_force == pytest.approx(5e-4 * 2.5e6 - 3e-4 * 1.5e6, rel=1e-12)


def test_the_velocity_is_that_of_the_position_as_measured() -> None:
    machines = [MachineOutputs(9.0, 0.0, x, 0.0, 0.0, 0.0) for x in (0.0102, 0.0104, 0.0116)]
    found = [y.velocity for y in measurements(RigSensors(Encoder(1e-3)), machines)]
    assert found == pytest.approx([0.0, 0.0, 2e-3 / H])  # counts 10, 10, 12


def test_each_sensor_draws_numbers_of_its_own() -> None:
    noisy = example(PressureTransducer, noise=0.01, bits=0)
    rig = RigSensors(IdealPosition(), VelocitySensor(1.0), noisy, noisy)
    found = measurements(rig, [MachineOutputs(0.0, 0.0, 0.0, 30e5, 30e5, 0.0)] * 20_000)
    noise = np.array([(y.velocity, y.pressure_a, y.pressure_b) for y in found])
    together = np.corrcoef(noise.T) - np.eye(3)
    assert np.abs(together).max() < 3.5 / math.sqrt(len(found))


@pytest.mark.parametrize(
    "sensors", [IdealSensors(), example(NoisySensors)], ids=lambda one: type(one).__name__
)
def test_a_delay_is_of_one_sample_exactly_and_not_of_the_command(sensors: Block) -> None:
    machines = moving(6)
    direct, once, twice = (
        measurements(one, machines)
        for one in (sensors, DelayedSensors(sensors), DelayedSensors(DelayedSensors(sensors)))
    )
    for k in range(6):
        assert once[k] == direct[max(k - 1, 0)]._replace(command=float(k))
        assert twice[k] == direct[max(k - 2, 0)]._replace(command=float(k))


def test_a_dropout_repeats_what_came_last() -> None:
    machines = moving(2000)
    found = measurements(Dropout(0.3), machines)
    last = 0
    for k, y in enumerate(found):
        last = k if ops.uniform(7.0, 0.0, float(k)) >= 0.3 else last
        assert y == measurements(IdealSensors(), [machines[last]])[0]._replace(command=float(k))
    lost = sum(a.velocity == b.velocity for a, b in pairwise(found))
    assert lost / 1999 == pytest.approx(0.3, abs=3.5 * math.sqrt(0.3 * 0.7 / 1999))
    assert measurements(Dropout(0.3), machines) == found


def test_a_dropout_that_never_comes_or_always() -> None:
    machines = moving(5)
    never = measurements(Dropout(0.0, example(NoisySensors)), machines)
    assert never == measurements(example(NoisySensors), machines, stream=2.0)
    always = measurements(Dropout(1.0), machines)
    assert {y[:3] for y in always} == {always[0][:3]}
    assert always[0].velocity == machines[0].velocity


def test_losses_and_noise_share_no_numbers() -> None:
    machines = [MACHINE] * 20_000
    noisy = Dropout(0.5, NoisySensors(1.0, 1.0))
    received = [y.velocity for y in measurements(noisy, machines)]
    kept = np.array([k for k in range(1, 20_000) if received[k] != received[k - 1]])
    assert np.array(received)[kept].mean() == pytest.approx(MACHINE.velocity, abs=3.5 / math.sqrt(kept.size))


def test_in_a_loop_the_law_sees_what_a_rig_measures() -> None:
    """The whole chain of a compiled run, made again from its record."""
    simulation = Simulation(0.05, H, 8, record_period=H, seed=7)
    sensors = DelayedSensors(example(RigSensors, velocity=example(FilteredDifference)))
    loop = example(Loop, simulation, controller=PI(2.0, 0.0), sensors=sensors)
    run = simulate(loop, strict=True)
    positions = read(example(Encoder), run["plant.position"].values)
    estimated = velocities(example(FilteredDifference), positions)
    assert np.array_equal(run["sensors.sensors.velocity.value"], estimated)
    seen = np.concatenate([estimated[:1], estimated[:-1]])
    assert run["controller.u"].values == pytest.approx(
        2.0 * (run["reference.value"].values - seen), abs=1e-15
    )
    again = simulate(replace(loop, {"simulation.seed": 8}), record=["sensors.sensors.pressure_a.value"])
    name = "sensors.sensors.pressure_a.value"
    assert not np.array_equal(again[name], run[name])
