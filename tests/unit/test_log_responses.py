"""Frequency responses of recorded logs: a filter's own, a bench's, and logs that tell nothing."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.signal import coherence as scipy_coherence
from scipy.signal import csd, freqz, lfilter

from hydroservo import Loop, bode, linearize, load_scenario, replace, simulate
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.figures.bode import plot_bode
from hydroservo.identification.log_responses import welch, window_for, with_logs
from hydroservo.linear.measurement import EXCITATIONS, EXCITED, ExcitationPlan, excited_loop
from hydroservo.linear.operating_point import operating_point

PATHS = {"command [V]": "controller.u", "velocity [m/s]": "controlled.value", "w [mm/s]": "reference.value"}
B, A = [0.1, 0.2], [1.0, -1.2, 0.5]  # of a filter


def rig() -> Loop:
    return replace(load_scenario("rig/1khz-pi-sine"), {"plant.start_position": 0.039})


def bench(path: Path, excited: str, amplitude: float) -> Path:
    """A log of the rig with noise on its velocity, excited by 200 tones."""
    loop = rig()
    plan = ExcitationPlan(np.arange(2, 802, 4), 2000, 9, 1, seed=0)
    phases = np.random.default_rng(1).uniform(0.0, 2.0 * math.pi, 200)
    make = EXCITATIONS["multisine"]
    given = {name: make(plan, 1e-3, amplitude if name == excited else 0.0, phases) for name in EXCITED}
    data = simulate(excited_loop(loop, operating_point(loop, None), given, plan), record=[*PATHS.values()])
    columns = {"time [s]": data["time"].values, **{key: data[one].values for key, one in PATHS.items()}}
    columns["velocity [m/s]"] = columns["velocity [m/s]"] + np.random.default_rng(2).normal(
        0.0, 1e-5, data["time"].size
    )
    columns["w [mm/s]"] = 1e3 * columns["w [mm/s]"]
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_known_filter_has_its_response_and_a_coherence_of_one() -> None:
    u = np.random.default_rng(0).normal(size=40_000)
    found = welch(
        [(u[:15_000], lfilter(B, A, u)[:15_000]), (u[15_000:], lfilter(B, A, u)[15_000:])], 1e-3, "log"
    )
    _, expected = freqz(B, A, found.frequency, fs=1e3)
    np.testing.assert_allclose(found.response, expected, rtol=5e-3)
    assert found.coherence.min() > 0.999


def test_windows_are_averaged_as_scipy_does() -> None:
    draw = np.random.default_rng(0)
    u, period = np.cumsum(draw.normal(size=9_000)), 1e-3
    y = lfilter(B, A, u) + draw.normal(size=u.size)
    found = welch([(u, y)], period, "log")
    size = window_for([u.size], "log")
    options = {"fs": 1.0 / period, "nperseg": size, "detrend": "linear"}
    frequency, coherence = scipy_coherence(u, y, **options)
    response = csd(u, y, **options)[1] / csd(u, u, **options)[1]
    lines = np.searchsorted(frequency, found.frequency)
    assert lines.size > 100
    np.testing.assert_allclose(found.frequency, frequency[lines], rtol=1e-12)
    np.testing.assert_allclose(found.response, response[lines], rtol=1e-9)  # of lines far below the largest
    np.testing.assert_allclose(found.coherence, coherence[lines], rtol=1e-9)


def test_noise_leaves_the_coherence_that_its_share_of_the_power_says() -> None:
    """gamma^2 = 1/(1 + S_nn/S_yy), and the estimate spreads by sqrt((1 - gamma^2)/(2 n gamma^2))."""
    draw = np.random.default_rng(0)
    u = draw.normal(size=200_000)
    found = welch([(u, 2.0 * u + draw.normal(size=u.size))], 1e-3, "log")
    assert found.coherence.mean() == pytest.approx(4.0 / 5.0, abs=0.02)
    spread = np.abs(found.response.imag / 2.0).std()
    assert np.std(found.response.imag / 2.0) == pytest.approx(math.sqrt(0.2 / (2.0 * 16 * 0.8)), rel=0.15)
    assert spread < 0.1


def test_without_a_relation_there_is_next_to_no_coherence() -> None:
    draw = np.random.default_rng(0)
    found = welch([(draw.normal(size=50_000), draw.normal(size=50_000))], 1e-3, "log")
    assert found.coherence.mean() < 2.0 / 16.0


@pytest.mark.parametrize(("excited", "amplitude"), [("command", 2e-3), ("reference", 2e-4)])
def test_a_log_of_the_machine_shows_its_linear_model(tmp_path: Path, excited: str, amplitude: float) -> None:
    loop = rig()
    path = bench(tmp_path / "bench.csv", excited, amplitude)
    data = with_logs(bode(loop, measure=False), loop, [path], {"reference": "w"})
    model, whole = linearize(loop, sampled=True), linearize(loop, "loop")
    lines = {
        "machine": lambda w: model.response(w, "controlled", "command"),
        "closed": lambda w: whole.response(w, "controlled", "reference.value"),
    }
    for name in ("machine", "closed") if excited == "reference" else ("machine",):
        clean = data[f"{name}_recorded_coherence"].values > 0.999
        frequency = data["recorded"].values[clean]
        assert (frequency.min() < 5.0, frequency.max() > 150.0) == (True, True)
        ratio = data[f"{name}_recorded"].values[clean] / lines[name](2.0 * math.pi * frequency)
        off, late = np.abs(20.0 * np.log10(np.abs(ratio))), np.abs(np.degrees(np.angle(ratio)))
        assert (np.median(off) < 0.1, np.median(late) < 1.0) == (True, True)
        assert (off.max() < 0.4, late.max() < 4.0) == (True, True)  # five deviations of the estimate
    assert data["machine_recorded"].attrs["units"] == data["machine"].attrs["units"]


def test_the_picture_has_a_colour_for_each_log(tmp_path: Path) -> None:
    loop = rig()
    paths = [bench(tmp_path / f"{name}.csv", name, 1e-3) for name in ("command", "reference")]
    data = with_logs(bode(loop, measure=False), loop, paths, {"reference": "w"})
    fig = plot_bode(data)
    assert [axis.get_title(loc="left") for axis in fig.axes[:3]] == [
        "(a) machine",
        "(b) open loop",
        "(c) closed loop",
    ]
    assert len(fig.axes[0].collections) == 2
    assert len(fig.axes[2].collections) == 2  # whose demand stands still tells nothing of the closed loop
    said = [text.get_text() for text in fig.legends[0].get_texts()]
    assert said == ["linear model", "command.csv", "reference.csv"]


def log(path: Path, samples: int = 2000, period: float = 1e-3, **changes: object) -> Path:
    draw = np.random.default_rng(0)
    u = draw.normal(size=samples)
    columns = {"time [s]": period * np.arange(samples), "command [V]": u, "velocity [m/s]": lfilter(B, A, u)}
    pd.DataFrame(columns | changes).to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    ("make", "said"),
    [
        ({"samples": 300}, "has 300 samples without a gap, too few for a frequency response; 544 are needed"),
        ({"command [V]": 0.5}, "neither command nor reference changes: nothing excites the machine"),
        ({"velocity [m/s]": 0.5}, "never changes, and nothing else is measured"),
        ({"velocity [m/s]": np.nan}, "never changes, and nothing else is measured"),
        ({"reference [bar]": 0.0}, "does not convert to m/s; write [identify.columns] reference = "),
    ],
)
def test_a_log_that_tells_nothing_is_refused_in_one_line(
    tmp_path: Path, make: dict[str, object], said: str
) -> None:
    loop = rig()
    path = log(tmp_path / "log.csv", **make)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError) as caught:
        with_logs(bode(loop, measure=False), loop, [path])
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_log_without_what_is_controlled_names_it(tmp_path: Path) -> None:
    loop = load_scenario("axis/pump-controlled")
    with pytest.raises(
        ScenarioError, match="does not hold what the loop controls, its position; it has velocity"
    ):
        with_logs(bode(loop, measure=False), loop, [log(tmp_path / "log.csv")])


def test_no_log_is_refused() -> None:
    loop = rig()
    with pytest.raises(ParameterError, match="must be at least one"):
        with_logs(bode(loop, measure=False), loop, [])


def test_gaps_and_another_sample_period_are_said(tmp_path: Path) -> None:
    loop = rig()
    path = log(tmp_path / "log.csv", samples=4000, period=2e-3)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:1500] + lines[1600:]) + "\n")
    data = with_logs(bode(loop, measure=False), loop, [path])
    assert "is sampled every 2 ms, the law every 1 ms" in data.attrs["warning"]
    assert "gaps longer than 5 samples split it into 2 stretches" in data.attrs["warning"]
    _, expected = freqz(B, A, data["recorded"].values, fs=500.0)
    np.testing.assert_allclose(data["machine_recorded"].values, expected, rtol=0.05)
