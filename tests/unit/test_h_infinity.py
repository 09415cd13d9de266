"""H-infinity loop shaping: what gamma promises of the sampled loop, its filter, and how it runs."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hydroservo import ParameterError, replace, simulate, simulate_batch
from hydroservo.control.controlled import Velocity
from hydroservo.control.controllers import PI, Biquad, HInfinityLoopShaping
from hydroservo.control.synthesis.coprime import StateMatrices, robust_controller
from hydroservo.control.synthesis.loop_shaping import from_bilinear, sampled_plant, to_bilinear
from hydroservo.core.signals import Demand, Measurement
from hydroservo.linear import margins
from hydroservo.papers.tsmc_eha_2021.machine import MODEL, VALVE_LAG
from hydroservo.scenario import load_scenario

NAN = math.nan


def designed(
    k_p: float, k_i: float, period: float = 1e-3, tau: float = VALVE_LAG, factor: float = 1.1
) -> HInfinityLoopShaping:
    return HInfinityLoopShaping(k_p, k_i, tau, factor).designed(MODEL, period)


def passed(filters: list[Biquad], z: complex) -> complex:
    found = 1.0 + 0.0j
    for one in filters:
        low = 1.0 + one.fed_back / z + one.fed_back_earlier / z**2
        found *= (one.now + one.before / z + one.earlier / z**2) / low
    return found


def velocity(z: complex, period: float, tau: float) -> complex:
    """The velocity over the command, from the equations of the design model, sampled with a hold."""
    m = MODEL
    a = np.array(
        [[m.f1(1.0), m.g1(), 0.0], [m.f2(1.0, 0.0), m.f2(0.0, 1.0), m.g2(0.0, 0.0)], [0.0, 0.0, -1.0 / tau]]
    )
    b = np.array([0.0, 0.0, 1.0 / tau])
    both = expm(np.vstack([np.column_stack([a, b]), np.zeros(4)]) * period)
    return np.linalg.solve(z * np.eye(3) - both[:3, :3], both[:3, 3])[0]


@pytest.mark.parametrize(
    ("k_p", "k_i", "period", "expected"),
    [(3.0, 600.0, 1e-4, 1.80), (10.0, 3000.0, 1e-4, 2.57), (3.0, 600.0, 1e-3, 1.93)],
)
def test_the_least_gamma_is_that_with_half_a_sample_of_delay(
    k_p: float, k_i: float, period: float, expected: float
) -> None:
    """As a design with Pade's approximation of the hold has it, where periods are short for the weight."""
    assert designed(k_p, k_i, period).gamma / 1.1 == pytest.approx(expected, abs=0.01)


@pytest.mark.slow  # fine grids of frequencies
@pytest.mark.parametrize("period", [1e-3, 1e-4])
@pytest.mark.parametrize(("k_p", "k_i"), [(3.0, 600.0), (10.0, 3000.0)])
def test_the_sampled_loop_has_the_gamma_that_is_promised(k_p: float, k_i: float, period: float) -> None:
    """The norm of [K; 1] (1 + G_s K)^-1 [1, G_s], for one signal sqrt((1 + |K|^2) (1 + |G_s|^2)) |S|."""
    law = designed(k_p, k_i, period)
    worst = 0.0
    for w in np.geomspace(1.0, math.pi / period, 4000):
        z = np.exp(1j * w * period)
        shaped = velocity(z, period, VALVE_LAG) * (k_p + k_i * period * z / (z - 1.0))
        k = law.gain * passed([law.first, law.second], z)
        worst = max(worst, math.sqrt((1.0 + abs(k) ** 2) * (1.0 + abs(shaped) ** 2)) / abs(1.0 + shaped * k))
    assert worst <= law.gamma * (1.0 + 1e-6)
    assert worst == pytest.approx(law.gamma, rel=0.02)


@pytest.mark.parametrize("tau", [0.0, 1e-3, VALVE_LAG])
@pytest.mark.parametrize("k_i", [0.0, 600.0])
@pytest.mark.parametrize("period", [1e-3, 1e-5])
def test_the_sections_are_the_controller(tau: float, k_i: float, period: float) -> None:
    law = designed(3.0, k_i, period, tau)
    plant = to_bilinear(sampled_plant(MODEL, tau, period, 3.0, k_i))
    k = from_bilinear(robust_controller(plant).k)
    for w in (1e-4, 0.01, 0.3, 0.9):
        z = np.exp(1j * math.pi * w)
        whole = (k.c @ np.linalg.solve(z * np.eye(len(k.a)) - k.a, k.b) + k.d).item()
        assert law.gain * passed([law.first, law.second], z) == pytest.approx(whole, rel=1e-7)


def test_a_plant_there_and_back_is_the_same() -> None:
    plant = sampled_plant(MODEL, VALVE_LAG, 1e-3, 3.0, 600.0)
    again: StateMatrices = from_bilinear(to_bilinear(plant))
    z = np.exp(0.3j)
    ours, theirs = ((p.c @ np.linalg.solve(z * np.eye(4) - p.a, p.b) + p.d).item() for p in (plant, again))
    assert theirs == pytest.approx(ours, rel=1e-9)
    assert ours == pytest.approx(velocity(z, 1e-3, VALVE_LAG) * (3.0 + 0.6 * z / (z - 1.0)), rel=1e-9)


def test_the_filter_passes_what_stays() -> None:
    law = designed(3.0, 600.0)
    assert passed([law.first, law.second], 1.0) == pytest.approx(1.0, abs=1e-13)


def test_a_section_is_its_difference_equation() -> None:
    one = Biquad(0.3, -0.2, 0.1, -0.9, 0.5)
    u = [1.0, -2.0, 0.5, 0.0, 3.0]
    state, out = one.init(), []
    for value in u:
        state = one.step(state, value)
        out.append(state.value)
    past = [0.0, 0.0]
    for k in range(len(u)):
        before, earlier = (u[k - j] if k >= j else 0.0 for j in (1, 2))
        past.append(0.3 * u[k] - 0.2 * before + 0.1 * earlier + 0.9 * past[-1] - 0.5 * past[-2])
    assert out == pytest.approx(past[2:], rel=1e-14)


def test_with_filters_that_pass_everything_it_is_a_pi_law() -> None:
    law, pi = (
        HInfinityLoopShaping(3.0, 600.0, VALVE_LAG, anti_windup=50.0),
        PI(3.0, 600.0, 50.0, controls=Velocity()),
    )
    s, t = law.init(), pi.init()
    for k in range(50):
        y = Measurement(0.01 * math.sin(k), NAN, NAN, 0.9 * t.u, NAN, NAN, NAN)
        r = Demand(0.03, 0.0, 0.0)
        s, t = law.step(s, y, r, 1e-3), pi.step(t, y, r, 1e-3)
    assert (s.u, s.integral, s.unlimited) == (t.u, t.integral, t.unlimited)


def test_it_is_more_robust_than_its_weight_alone() -> None:
    loop = load_scenario("rig/1khz-pi-sine")
    for k_p, k_i in ((3.0, 600.0), (3.2309, 619.14)):
        alone = margins(replace(loop, {"controller": PI(k_p, k_i)}))
        shaped = margins(replace(loop, {"controller": HInfinityLoopShaping(k_p, k_i, VALVE_LAG)}))
        assert shaped.disk_margin > 1.5 * alone.disk_margin
        assert shaped.delay_margin > 1.5 * alone.delay_margin
    assert not margins(replace(loop, {"controller": PI(10.0, 3000.0)})).stable
    assert (
        margins(replace(loop, {"controller": HInfinityLoopShaping(10.0, 3000.0, VALVE_LAG)})).gain_margin
        > 1.8
    )


def test_less_than_the_best_gamma_is_given_for_the_factor() -> None:
    assert designed(3.0, 600.0, factor=1.3).gamma == pytest.approx(
        1.3 / 1.1 * designed(3.0, 600.0).gamma, rel=1e-8
    )


def test_gains_have_nine_digits() -> None:
    law = designed(3.0, 600.0)
    assert all(one == float(f"{one:.9g}") for one in (law.gamma, law.gain))


@pytest.mark.parametrize("weight", [(1e5, 10.0), (3.0, 1e12), (1e300, 0.0)])
def test_weights_that_nothing_stands_are_one_line(weight: tuple[float, float]) -> None:
    with pytest.raises(
        ParameterError, match=r"^HInfinityLoopShaping.proportional_gain = .* there is no robust"
    ) as caught:
        designed(*weight)
    assert "\n" not in str(caught.value)


def test_no_weight_at_all_is_refused() -> None:
    loop = replace(
        load_scenario("rig/1khz-pi-sine"), {"controller": HInfinityLoopShaping(0.0, 0.0, VALVE_LAG)}
    )
    with pytest.raises(ParameterError, match=r"proportional_gain = 0\.0: must be above 0 \[V s/m\]"):
        simulate(loop)


@pytest.mark.parametrize("demand", ["sine", "square"])
def test_it_follows_on_the_rig(demand: str) -> None:
    loop = load_scenario(f"rig/1khz-pi-{demand}", {"simulation.duration": "1 s"})
    found = simulate(replace(loop, {"controller": HInfinityLoopShaping(10.0, 3000.0, VALVE_LAG)}))
    assert not found.diverged
    assert float(found.rms_error) < 6e-3
    assert abs(float(found["controlled.value"][-1] - found["reference.value"][-1])) < 1e-3


def test_each_run_of_a_batch_has_its_own_filter_and_the_bits_of_a_run_alone() -> None:
    loop = load_scenario("rig/1khz-pi-sine", {"simulation.duration": "0.1 s"})
    loop = replace(loop, {"controller": HInfinityLoopShaping(3.0, 600.0, VALVE_LAG)})
    gains = [2.0, 3.0, 10.0]
    many = simulate_batch(loop, {"controller.proportional_gain": gains})
    for i, k_p in enumerate(gains):
        alone = simulate(replace(loop, {"controller.proportional_gain": k_p}))
        assert float(many.rms_error[i]) == pytest.approx(float(alone.rms_error), rel=1e-12)
