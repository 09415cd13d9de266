"""Frequency responses on the command line."""

import json

import numpy as np
import pytest

from tests.support.brink import brink_file
from tests.support.commands.runner import failed, hydroservo_, succeeded

pytestmark = pytest.mark.nightly  # tests.regression runs each command

RIG = ("bode", "rig/1khz-pi-sine")


def test_bode_json_is_one_object_and_the_picture_is_there(tmp_path):
    out = tmp_path / "bode.svg"
    said = json.loads(succeeded(*RIG, "--periods", "1", "--realisations", "2", "--json", "--out", out))
    assert said["scenario"] == "rig/1khz-pi-sine"
    assert said["stable"] is True
    for name in ("machine", "open", "closed", "sensitivity", "compliance", "open_compliance"):
        curve = said[name]
        assert len(curve["frequency"]) == len(curve["magnitude"]) == len(curve["phase"])
    measured, linear = said["closed"]["measured"], said["closed"]
    expected = np.interp(measured["frequency"], linear["frequency"], linear["magnitude"])
    np.testing.assert_allclose(measured["magnitude"], expected, rtol=0.02)
    assert min(measured["coherence"]) > 0.99
    assert said["closed"]["unit"] == ""
    assert said["compliance"]["unit"] == "m/(s N)"
    assert said["bandwidth"] > said["bandwidth_90"] > 0.0
    assert abs(said["oscillation_gain"] / said["gain_margin"] - 1.0) < 0.1
    assert b"<svg" in out.read_bytes()[:500]


def test_bode_prints_margins_and_bandwidths():
    text = succeeded(*RIG, "--linear")
    for word in ("gain margin", "phase margin", "disk margin", "sensitivity peak", "bandwidth"):
        assert word in text
    assert "coherence" not in text


def test_bode_says_why_there_are_no_margins(tmp_path):
    result = hydroservo_("bode", brink_file(tmp_path, "axis/position"), "--linear", "--json")
    said = json.loads(result.stdout)
    assert said["gain_margin"] is said["phase_margin"] is said["sensitivity_peak"] is None
    assert 1.5 < said["oscillation_gain"] < 1.8  # 3.5 to 5.1 dB
    assert "but the loop oscillates from 3." in result.stderr


def test_bode_prints_a_dash_for_what_is_not_coherent():
    text = " ".join(succeeded("bode", "axis/force", "--amplitude", "0.1V", "--realisations", "2").split())
    assert "Measured: gain margin \N{EN DASH} (coherence 0." in text
    assert "try a larger --amplitude" in text


def test_bode_over_a_number(tmp_path):
    out = tmp_path / "bode.png"
    words = ("--vary", "plant.mass=4..12kg", "--band", "1..100Hz", "--out", out)
    said = json.loads(succeeded(*RIG, *words, "--json"))
    assert (said["varied"], said["unit"]) == ("plant.mass", "kg")
    assert [point["value"] for point in said["points"]] == [4.0, 6.0, 8.0, 10.0, 12.0]
    margins = [point["phase_margin"] for point in said["points"]]
    assert margins == sorted(margins, reverse=True)
    assert out.read_bytes().startswith(b"\x89PNG")


def test_bode_beside_a_log(tmp_path):
    u = np.random.default_rng(0).normal(size=2000)
    rows = [f"{1e-3 * k:.3f},{u[k]:.6g},{50.0 * u[max(k - 2, 0)]:.6g}" for k in range(2000)]
    log, out = tmp_path / "bench.csv", tmp_path / "bode.png"
    log.write_text("\n".join(["t,command [V],velocity [mm/s]", *rows]) + "\n")
    words = ("--set", 'identify.columns.time="t [s]"', "--linear", "--log", log, "--out", out)
    said = json.loads(succeeded(*RIG, *words, "--json"))
    (told,) = said["logs"]
    assert told["log"].endswith("bench.csv")
    assert "closed" not in told
    np.testing.assert_allclose(told["machine"]["magnitude"], 0.05, rtol=0.05)
    assert out.read_bytes().startswith(b"\x89PNG")
    assert "machine, coherence above 0.95" in " ".join(succeeded(*RIG, *words).split())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--band", "1..900Hz"), "band = 900.0: must be below Nyquist's frequency, 500 [Hz]"),
        (("--band", "1Hz"), "must be a range"),
        (("--band", "1..9 bar"), "does not convert to Hz"),
        (("--band=-50%..+100%",), "is relative, and there is no value that it could be relative to"),
        (("--amplitude", "nan"), "amplitude = nan: must be a finite number at least 1e-12 [V]"),
        (("--amplitude", "2 bar"), "--amplitude = '2 bar': does not convert to V"),
        (("--out", "bode.txt"), "must end in one of .png, .svg, .pdf"),
        (("--out", "nowhere/at/all/bode.png", "--periods", "0"), "periods = 0: must be"),
        (("--vary", "plant.mass=4..9kg", "--vary", "plant.leakage=0..1e-12"), "must be one number"),
        (("--vary", "plant.mas=4..12kg"), "did you mean plant.mass?"),
        (("--log", "nowhere.csv"), "nowhere.csv: there is no such file"),
        (("--excitation", "sweep"), "is not one of 'multisine', 'chirp'"),
        (("--vary", "plant.mass"), "must be of the form PATH=LOW..HIGH"),
        (("--command", "2V", "--set", "supply.supply_pressure=1e3 bar", "--load", "nan"), "force = nan"),
    ],
)
def test_what_has_no_picture_is_one_line(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in failed(*RIG, *words)


def test_a_loop_that_oscillates_as_it_stands_has_no_margins(tmp_path):
    """Though small motions about a point would have some."""
    changes = {
        "controller.controller.controller.proportional_gain": "5000 V/m",
        "controller.controller.controller.integral_gain": "20000 V/(m s)",
        "simulation.duration": "6 s",
    }
    sets = [word for path, value in changes.items() for word in ("--set", f"{path}={value}")]
    result = hydroservo_("bode", "axis/position", "--linear", "--json", *sets)
    said = json.loads(result.stdout)
    assert (said["stable"], said["gain_margin"], said["oscillation_gain"]) == (False, None, 1.0)
    assert "no margins: the loop oscillates as it stands" in result.stderr
