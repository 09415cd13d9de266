"""``hydroservo export``: what is printed and written, and what it says where something is wrong."""

import json
import re
import subprocess
from pathlib import Path

import pytest

import hydroservo
from hydroservo.export.compilers import TOOLCHAINS, this_platform
from hydroservo.runs.provenance import scenario_hash
from hydroservo.scenario import load_scenario
from tests.support.bases import on_base
from tests.support.commands.runner import PLUGIN, failed, succeeded
from tests.support.needs import needs

SHORT = ("--set", "simulation.duration=20 ms")
C = ("export", "c", "paper/sine-pi", *SHORT)
FIXED = on_base('simulation.duration = "1 ms"\ncontroller.type = "Fixed"\n')

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("forgotten")]


def names(prefix):
    return [f"{prefix}{ending}" for ending in (".h", ".c", "_vectors.h", "_replay.c")] + [
        "Makefile",
        "README.md",
    ]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """An export, what it printed, and where it is."""
    out = tmp_path_factory.mktemp("export") / "new folder"
    return succeeded(*C, "--out", out), out


def test_it_says_what_was_written_and_what_to_do_next(done):
    needs("cc")
    said, out = done
    first, proof, *others = said.splitlines()
    assert first == "PI of scenario paper/sine-pi: 24 bytes of state, 40 of parameters, double precision"
    assert proof == "checked with cc: 542 samples bit for bit"
    assert others == [
        f"written to {out}: {', '.join(names('sine_pi'))}",
        f"next: make -C '{out}' check",
    ]
    assert sorted(path.name for path in out.iterdir()) == sorted(names("sine_pi"))


def test_the_next_command_passes(done):
    needs("make", "cc")
    command = done[0].splitlines()[-1].removeprefix("next: ")
    run = subprocess.run(  # noqa: S602 - the line that the command prints for a shell
        command, shell=True, capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert re.search(r"sine_pi: (\d+) of \1 samples bit for bit", run.stdout)


def test_json_is_one_object(tmp_path):
    said = json.loads(succeeded(*C, "--out", tmp_path, "--precision", "single", "--prefix", "rig", "--json"))
    proof = said.pop("proof")
    assert proof["samples"] == 500
    assert (proof["compiler"], proof["unproved"]) == ("cc", "")
    assert "in single precision against double" in proof["deviation"]
    assert said == {
        "scenario": "paper/sine-pi",
        "hash": scenario_hash(load_scenario("paper/sine-pi", {"simulation.duration": 0.02})),
        "version": hydroservo.__version__,
        "unit": "controller",
        "prefix": "rig",
        "precision": "single",
        "period": 1e-5,
        "state_bytes": 12,
        "parameter_bytes": 20,
        "files": [str(tmp_path / name) for name in names("rig")],
    }
    assert "float rig_step(" in (tmp_path / "rig.h").read_text()


def test_parameters_inline(tmp_path):
    assert ", 0 of parameters," in succeeded(*C, "--out", tmp_path, "--inline")
    assert "_defaults" not in (tmp_path / "sine_pi.h").read_text()


@pytest.mark.parametrize(
    ("unit", "step"), [("machine", "machine_sine_pi_command *command"), ("loop", "loop_sine_pi_parameters")]
)
def test_the_machine_and_the_loop(tmp_path, unit, step):
    said = succeeded(*C, "--out", tmp_path, "--unit", unit)
    assert said.startswith(f"{unit.capitalize()} of scenario paper/sine-pi: ")
    assert step in (tmp_path / f"{unit}_sine_pi.h").read_text()
    needs("make", "cc")
    run = subprocess.run(["make", "-C", tmp_path, "check"], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    assert f"{unit}_sine_pi: 500 of 500 samples bit for bit" in run.stdout


def test_a_scenario_with_a_metric_of_ones_own_needs_its_plugin(tmp_path):
    """Though the metric is no part of what is exported."""
    text = 'base = "paper/sine-pi"\nsimulation.duration = "2 ms"\nmetrics.narrow.type = "Tolerance"\n'
    (tmp_path / "my.toml").write_text(text)
    export = ("export", "c", tmp_path / "my.toml", "--out", tmp_path / "c")
    said = failed(*export)
    assert "my.toml: metrics.narrow.type: 'Tolerance' is not a type here; " in said
    assert "; a class of your own needs its file: --plugin FILE" in said
    succeeded(*export, "--plugin", Path(__file__).parents[2] / "examples" / "my_metric.py")


def test_a_file_of_ones_own_with_a_plugin(tmp_path):
    (tmp_path / "plugin.py").write_text(PLUGIN)
    (tmp_path / "My law.toml").write_text(FIXED)
    plugin = ("--plugin", tmp_path / "plugin.py")
    said = succeeded("export", "c", tmp_path / "My law.toml", *plugin, "--out", tmp_path / "c")
    assert said.startswith("Fixed of scenario My law: ")
    assert (tmp_path / "c" / "my_law.c").exists()


def test_a_law_that_stops_plain_python_is_said_in_one_line(tmp_path):
    (tmp_path / "plugin.py").write_text(
        PLUGIN.replace("FixedState(self", "FixedState(y.velocity / (y.velocity - 1e300) + self")
    )
    (tmp_path / "law.toml").write_text(FIXED)
    said = failed(
        "export", "c", tmp_path / "law.toml", "--plugin", tmp_path / "plugin.py", "--out", tmp_path / "c"
    )
    assert "no test vectors: Python stopped with ZeroDivisionError" in said
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--prefix", "a-b"), "prefix = 'a-b': must be"),
        (("--prefix", "math"), "prefix = 'math': must be"),
        (("--unit", "loop", "--precision", "single"), "double precision"),
        (("--set", "plant.mass=0"), "plant.mass"),
    ],
)
def test_what_cannot_be_exported_is_said_in_one_line(tmp_path, options, message):
    assert message in failed(*C, "--out", tmp_path / "c", *options)
    assert not (tmp_path / "c").exists()


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    assert "file" in failed(*C, "--out", tmp_path / "file" / "c")


def test_a_stranger_is_not_replaced(tmp_path):
    (tmp_path / "README.md").write_text("# mine")
    assert "README.md: not written by hydroservo" in failed(*C, "--out", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["README.md"]


@pytest.fixture
def compiler():
    needs("cc")


@pytest.mark.parametrize("standard", [2, 3])
def test_an_fmu(compiler, tmp_path, standard):
    import fmpy
    from fmpy.validation import validate_fmu

    out = tmp_path / "law.fmu"
    said = succeeded("export", "fmu", "paper/sine-pi", *SHORT, "--fmi", standard, "--out", out)
    first, proof, *others = said.splitlines()
    assert (
        first
        == f"PI of scenario paper/sine-pi: 3 inputs, 1 output, 5 parameters, FMI {standard}, steps of 1e-05 s"
    )
    assert proof.startswith("checked with cc: ")
    assert others == [
        f"written: {out}, {out.stat().st_size / 1024:.0f} KiB, for {this_platform()}",
        f"next: fmpy validate {out}",
    ]
    assert validate_fmu(str(out)) == []
    about = fmpy.read_model_description(str(out))
    assert (about.fmiVersion[0], about.defaultExperiment.stopTime) == (str(standard), "0.02")


@pytest.mark.parametrize("unit", ["machine", "loop"])
def test_an_fmu_of_the_machine_in_json(compiler, tmp_path, unit):
    options = ("--unit", unit, "--json", "--out", tmp_path / "m.fmu", "--prefix", "rig")
    said = json.loads(succeeded("export", "fmu", "paper/sine-pi", *SHORT, *options))
    assert (said["unit"], said["fmi"], said["file"]) == (unit, "2", str(tmp_path / "m.fmu"))
    assert said["platforms"] == [this_platform()]
    assert said["prefix"] == "rig"
    assert (tmp_path / "m.fmu").exists()


def test_an_fmu_with_a_clock(compiler, tmp_path):
    options = ("--fmi", 3, "--clocked", "--out", tmp_path / "law.fmu")
    said = succeeded("export", "fmu", "paper/sine-pi", *SHORT, *options)
    assert said.splitlines()[0].endswith("FMI 3, a clock of 1e-05 s")
    about = json.loads(succeeded("export", "fmu", "paper/sine-pi", *SHORT, *options, "--json"))
    assert about["clocked"] is True


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "clocked = True: FMI 2.0 has no clocks; use FMI 3.0"),
        (("--fmi", 3, "--unit", "demand"), "clocked = True: only a controller can have a clock"),
    ],
)
def test_what_cannot_have_a_clock_is_said_in_one_line(tmp_path, options, message):
    out = ("--clocked", "--out", tmp_path / "law.fmu")
    assert message in failed("export", "fmu", "paper/sine-pi", *SHORT, *options, *out)
    assert not list(tmp_path.iterdir())


def test_one_output_is_an_output(compiler, tmp_path):
    said = succeeded("export", "fmu", "paper/sine-pi", "--out", tmp_path / "law.fmu")
    assert said.startswith("PI of scenario paper/sine-pi: 3 inputs, 1 output, ")


def test_equations_are_for_model_exchange(compiler, tmp_path):
    said = succeeded("export", "fmu", "paper/sine-pi", "--unit", "equations", "--out", tmp_path / "axis.fmu")
    assert said.startswith("Equations of scenario paper/sine-pi: 2 inputs, 10 outputs, ")
    assert ", FMI 2, model exchange\n" in said


@pytest.fixture
def other(compiler):
    """A platform that a cross compiler here builds for."""
    platform = next(one for one in ("aarch64-linux", "x86_64-linux") if one != this_platform())
    needs(TOOLCHAINS[platform].cross)
    return platform


@pytest.mark.nightly
@pytest.mark.parametrize("what", ["fmu", "ssp"])
def test_binaries_for_other_platforms(other, tmp_path, what):
    out = tmp_path / f"law.{what}"
    options = ("--platform", other, "--platform", this_platform(), "--out", out)
    said = succeeded("export", what, "paper/sine-pi", *SHORT, *options)
    assert f", for {other}, {this_platform()}\n" in said
    assert f"cross compiled, and not run here: the binaries for {other}\n" in said


@pytest.mark.parametrize("what", ["fmu", "ssp"])
@pytest.mark.parametrize(
    ("platform", "problem"),
    [
        ("vax", "invalid value for '--platform': 'vax' is not one of 'x86_64-linux', 'aarch64-linux', "),
        ("aarch64-windows", "a binary for aarch64-windows can only be built on such a machine"),
        (
            "x86_64-windows",
            "the C compiler x86_64-w64-mingw32-gcc is not found; for x86_64-windows, on Debian",
        ),
    ],
)
def test_a_binary_that_cannot_be_built_is_refused_before_the_export(
    tmp_path, monkeypatch, what, platform, problem
):
    monkeypatch.setattr("hydroservo.export.products.translate_part", None)  # which would fail
    monkeypatch.setenv("PATH", str(tmp_path))
    out = tmp_path / f"law.{what}"
    assert problem in failed("export", what, "paper/sine-pi", "--platform", platform, "--out", out)
    assert not list(tmp_path.iterdir())


def test_an_fmu_ends_in_fmu(tmp_path):
    said = failed("export", "fmu", "paper/sine-pi", "--out", tmp_path / "law.zip")
    assert "law.zip: its name must end in .fmu" in said
    assert not list(tmp_path.iterdir())


def test_a_system_of_fmus(compiler, tmp_path):
    out = tmp_path / "loop.ssp"
    said = succeeded("export", "ssp", "paper/sine-pi", *SHORT, "--out", out)
    titles = [line.partition(" of scenario")[0] for line in said.splitlines()[:3]]
    assert titles == ["PI", "Machine", "Demand"]
    assert said.splitlines()[3].endswith(f"KiB, FMI 2, steps of 1e-05 s, for {this_platform()}")
    assert said.count("checked with cc: ") == 3
    found = json.loads(succeeded("export", "ssp", "paper/sine-pi", *SHORT, "--out", out, "--json"))
    assert [one["unit"] for one in found["units"]] == ["controller", "machine", "demand"]
    assert found["file"] == str(out)


def test_a_system_of_fmus_ends_in_ssp(tmp_path):
    assert "must end in .ssp" in failed("export", "ssp", "paper/sine-pi", "--out", tmp_path / "loop.fmu")
    assert not list(tmp_path.iterdir())
