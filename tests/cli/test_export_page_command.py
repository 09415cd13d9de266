"""``hydroservo export page``: what is printed and written, and what it says where something is wrong."""

import json

import pytest

import hydroservo
from hydroservo import load_scenario
from hydroservo.runs.provenance import scenario_hash
from tests.support.commands.runner import failed, hydroservo_, succeeded

CHANGES = ("--set", "simulation.duration=50 ms")
PAGE = ("export", "page", "rig/1khz-pi-sine", *CHANGES)
GAINS = ["controller.proportional_gain", "controller.integral_gain"]
MASS = ("--slider", "plant.mass=-50%..+50%")

pytestmark = pytest.mark.slow


def test_it_says_what_can_be_changed_and_what_was_shown(tmp_path):
    out = tmp_path / "new" / "page.html"
    first, proof, written = succeeded(*PAGE, "--out", out).splitlines()
    assert first == f"Loop of scenario rig/1khz-pi-sine: sliders for {', '.join(GAINS)}"
    assert proof == "checked with zig and wasmtime: 255 samples bit for bit"  # 51, as it is and at four ends
    assert written == f"written: {out}, {out.stat().st_size / 1024:.0f} KiB; it opens in a browser"
    assert [path.name for path in out.parent.iterdir()] == ["page.html"]
    assert "<h1>Rig at 1 kHz, exact sensors: sine, PI, changed</h1>" in out.read_text()


def test_json_is_one_object(tmp_path):
    said = json.loads(succeeded(*PAGE, *MASS, "--out", tmp_path / "page.html", "--json"))
    assert said == {
        "scenario": "rig/1khz-pi-sine",
        "hash": scenario_hash(load_scenario("rig/1khz-pi-sine", {"simulation.duration": 0.05})),
        "version": hydroservo.__version__,
        "unit": "loop",
        "prefix": "loop_1khz_pi_sine",
        "precision": "double",
        "period": 0.001,
        "proof": {"samples": 153, "compiler": "zig and wasmtime", "unproved": "", "deviation": ""},
        "sliders": ["plant.mass"],
        "file": str(tmp_path / "page.html"),
    }


def test_the_same_page_each_time_under_a_title_of_its_own(tmp_path):
    (tmp_path / "my.toml").write_text('base = "rig/1khz-pi-sine"\nsimulation.duration = "50 ms"\n')
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    for page in pages:
        succeeded("export", "page", tmp_path / "my.toml", "--out", page)
    assert "<h1>Loop of scenario my</h1>" in pages[0].read_text()  # and not the title of its base
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_what_is_designed_with_is_left_out(tmp_path):
    said = succeeded("export", "page", "laws/backstepping-sine", *CHANGES, "--out", tmp_path / "page.html")
    assert "left out, as they cannot be sliders: controller.controller.observer.dist" in said


def test_steps_too_coarse_are_said_on_stderr_and_in_the_page(tmp_path):
    coarse = ("--set", "simulation.period=1 ms", "--set", "simulation.substeps=1", *CHANGES)
    page = tmp_path / "page.html"
    result = hydroservo_("export", "page", "paper/sine-pi", *coarse, *MASS, "--out", page)
    assert result.exit_code == 0
    assert result.stderr.startswith("hydroservo: warning: paper/sine-pi: the steps are too coarse")
    assert "Warning: the steps are too coarse to be trusted" in page.read_text()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((*PAGE, "--out", "page.htm"), "page.htm: its name must end in .html"),
        ((*PAGE, "--slider", "controller.gain=1..2"), "--slider: controller.gain: must be one of"),
        ((*PAGE, "--slider", f"{GAINS[0]}=1..2 kg"), f"--slider: {GAINS[0]}: '1 kg' does not convert"),
        ((*PAGE, "--slider", f"{GAINS[0]}=9..9"), f"--slider: {GAINS[0]}: '9..9' is not a range"),
        ((*PAGE, "--slider", f"{GAINS[0]}=9"), f"--slider: '{GAINS[0]}=9' must be of the form"),
        ((*PAGE, *MASS, *MASS), "--slider: plant.mass: is given twice"),
        (
            ("export", "page", "laws/lq-sine"),
            "it decides controller.gain_1 and 2 others; choose another number",
        ),
        (("export", "page", "my.toml"), "nothing to change: give --slider PATH=LOW..HIGH, or the scenario"),
    ],
)
def test_what_cannot_be_is_one_line(words, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    law = 'controller = { type = "PI", proportional_gain = 3.0, integral_gain = 600.0 }'
    (tmp_path / "my.toml").write_text(f'base = "rig/1khz"\nreference.type = "Sine"\n{law}\n')
    out = () if "--out" in words else ("--out", "page.html")
    assert said in failed(*words, *out)
    assert [path.name for path in tmp_path.iterdir()] == ["my.toml"]
