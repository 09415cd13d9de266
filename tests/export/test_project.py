"""The folder of an export in C: it builds without a warning, its replay passes, its README is true."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from toy import toy

from hydroservo.errors import HydroservoError, ParameterError
from hydroservo.export.deviation import measured_deviation
from hydroservo.export.exported import Signal
from hydroservo.export.prefix import checked_prefix, default_prefix
from hydroservo.export.project import c_project, memory, write_c_project
from hydroservo.export.units import Part
from hydroservo.export.vectors import HUGE, made_vectors
from hydroservo.scenario import load_scenario
from hydroservo.simulate import simulate

FILES = ["toy.h", "toy.c", "toy_vectors.h", "toy_replay.c", "Makefile", "README.md"]
COMPILERS = ["gcc", "clang"]
CALL = {"changes": {"simulation.duration": 0.05}}  # s; 5000 samples


def needs(*tools):
    missing = [tool for tool in tools if shutil.which(tool) is None]
    return pytest.mark.skipif(bool(missing), reason=f"needs {', '.join(missing)}")


compilers = pytest.mark.parametrize(
    "compiler", [pytest.param(name, marks=needs("make", name)) for name in COMPILERS]
)


def single(exported):
    """The toy in single precision, as the translator would write it."""

    def text(double):
        constants = re.sub(r"(?<![\w.])(\d+\.\d+|1e-05)(?![\w.])", r"\1f", double)
        return constants.replace("double", "float")

    return exported._replace(real="float", header=text(exported.header), source=text(exported.source))


def make(folder, *words):
    return subprocess.run(["make", "-C", folder, *words], capture_output=True, text=True, check=False)


def check(folder, compiler):
    return make(folder, "check", f"CC={compiler}", "CFLAGS=-O2 -Werror")


@pytest.fixture(scope="module")
def loop():
    return load_scenario("paper/sine-pi", **CALL)


@pytest.fixture(scope="module")
def vectors(loop):
    return made_vectors(loop, Part.CONTROLLER, toy())


@pytest.fixture(scope="module")
def close_vectors(loop):
    return made_vectors(loop, Part.CONTROLLER, single(toy()))


@pytest.fixture
def folder(tmp_path, vectors):
    write_c_project(toy(), vectors, tmp_path)
    return tmp_path


@compilers
def test_the_replay_is_bit_for_bit_and_without_a_warning(folder, compiler):
    done = check(folder, compiler)
    assert (done.returncode, done.stderr) == (0, "")
    assert "\ntoy: 542 of 542 samples bit for bit\n" in done.stdout


@compilers
@pytest.mark.parametrize(("row", "column", "name"), [(17, 1, "integral"), (499, 2, "unlimited")])
def test_one_bit_of_one_number_is_found(tmp_path, vectors, compiler, row, column, name):
    true = vectors.expected[row, column]
    wrong = vectors.expected.copy()
    wrong[row, column] = np.nextafter(true, 1.0)
    write_c_project(toy(), vectors._replace(expected=wrong), tmp_path)
    done = check(tmp_path, compiler)
    assert done.returncode != 0
    assert f"toy: sample {row + 1} of 542: controller.{name} [V]\n" in done.stdout
    assert f"= {true:.17g}\n" in done.stdout
    assert f"= {wrong[row, column]:.17g}\n" in done.stdout
    assert "bit for bit" not in done.stdout


@needs("make", "gcc")
@pytest.mark.parametrize(("found", "expected"), [("0.0", "-0x0.0p+0"), ("0.0", "NAN"), ("NAN", "0x0.0p+0")])
def test_signs_of_zeros_and_nan_count(folder, found, expected):
    vectors = folder / "toy_vectors.h"
    vectors.write_text(re.sub(r"(toy_start.* = \{)[^,]*", rf"\g<1>{expected}", vectors.read_text()))
    source = folder / "toy.c"
    source.write_text(source.read_text().replace("(toy_state){.u = 0.0", f"(toy_state){{.u = {found}"))
    done = check(folder, "gcc")
    assert done.returncode != 0
    assert "toy: sample 0 of 542: controller.u [V]\n" in done.stdout


@needs("make", "gcc")
def test_what_step_returns_is_the_states_command(folder):
    source = folder / "toy.c"
    source.write_text(source.read_text().replace("return state->u;", "return state->unlimited + 1.0;"))
    done = check(folder, "gcc")
    assert done.returncode != 0
    assert "sample 1: what step returned is not the state's command" in done.stdout


@compilers
def test_single_precision_states_its_deviation(tmp_path, close_vectors, compiler):
    exported = single(toy())
    write_c_project(exported, close_vectors, tmp_path)
    done = check(tmp_path, compiler)
    assert (done.returncode, done.stderr) == (0, "")
    said = done.stdout[done.stdout.index("toy: 500 samples") : done.stdout.index("make: Leaving")]
    assert said in (tmp_path / "README.md").read_text()
    relative = {line.split()[2]: float(line.split()[1]) for line in said.splitlines()[2:-1]}
    assert list(relative) == [signal.path for signal in exported.states]
    assert all(0.0 < value < 1e-4 for value in relative.values())
    assert make(tmp_path, "check", "CFLAGS=-DTOY_TOLERANCE=1e-9").returncode != 0


def test_without_a_compiler_nothing_is_measured(tmp_path, close_vectors, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "gcc")
    text = c_project(single(toy()), close_vectors)["README.md"]
    assert "It was not measured when this folder was written" in text


@pytest.mark.parametrize("compiler", ["false", "true", "no-such-compiler"])
def test_a_compiler_that_does_not_work_is_passed_over(compiler, close_vectors, monkeypatch, tmp_path):
    texts = c_project(single(toy()), close_vectors)
    with monkeypatch.context() as changed:
        changed.setattr("hydroservo.export.deviation.COMPILERS", ())
        changed.setenv("CC", compiler)
        assert measured_deviation("toy", texts) is None


def test_parameters_may_be_inlined(tmp_path, vectors):
    names = {"proportional_gain": "100.0", "integral_gain": "10.0", "period": "1e-05"}
    exported = toy()
    header = re.sub(r"/\* Saturation.*?toy_parameters;", "", exported.header, flags=re.S)
    header = header.replace("extern const toy_parameters toy_defaults;", "")
    source = re.sub(r"const toy_parameters toy_defaults.*?};", "", exported.source, flags=re.S)
    source = re.sub(r"static double saturation_apply.*?}", "", source, flags=re.S)
    source = source.replace(
        "saturation_apply(&parameters->saturation, unlimited)", "ops_clip(unlimited, -10.0, 10.0)"
    )
    for name, value in names.items():
        source = source.replace(f"parameters->{name}", value)
    texts = [
        text.replace(", const toy_parameters *parameters", "").replace("    (void)parameters;\n", "")
        for text in (header, source)
    ]
    inlined = exported._replace(inlined=True, header=texts[0], source=texts[1])
    write_c_project(inlined, vectors, tmp_path)
    text = (tmp_path / "README.md").read_text()
    assert "24 bytes of state for each instance |" in text
    assert "toy_defaults" not in text
    assert "| `integral_gain` | 10.0 | V/m | integral gain k_i |" in text
    if shutil.which("make") and shutil.which("gcc"):
        done = check(tmp_path, "gcc")
        assert (done.returncode, done.stderr) == (0, "")


def test_a_unit_without_command_or_arguments(tmp_path, vectors):
    exported = toy()
    header = exported.header.replace("double toy_step", "void toy_step")
    source = exported.source.replace("double toy_step", "void toy_step").replace("    return state->u;\n", "")
    for old in (
        ", const toy_measurement *measurement,\n                const toy_demand *demand",
        "demand->value - measurement->velocity",
    ):
        header, source = (text.replace(old, "0.5" if "->" in old else "") for text in (header, source))
    closed = exported._replace(command=False, arguments=(), header=header, source=source)
    state = np.array([[10.0, 5e-5, 50.00005], [10.0, 1e-4, 50.0001]])
    write_c_project(closed, vectors._replace(inputs=np.zeros((2, 0)), expected=state), tmp_path)
    assert "control_interrupt" not in (tmp_path / "README.md").read_text()
    if shutil.which("make") and shutil.which("gcc"):
        done = check(tmp_path, "gcc")
        assert done.stderr == "" or "error" not in done.stderr
        assert "toy: 2 of 2 samples bit for bit\n" in done.stdout


def test_the_same_export_gives_the_same_bytes(loop, vectors, tmp_path):
    again = c_project(toy(), made_vectors(loop, Part.CONTROLLER, toy()))
    write_c_project(toy(), vectors, tmp_path)
    assert {name: (tmp_path / name).read_text() for name in FILES} == again


def test_other_files_stay_and_strangers_are_not_replaced(vectors, tmp_path):
    (tmp_path / "main.c").write_text("mine")
    assert write_c_project(toy(), vectors, tmp_path) == [tmp_path / name for name in FILES]
    assert write_c_project(toy(), vectors, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*FILES, "main.c"])
    assert (tmp_path / "main.c").read_text() == "mine"
    (tmp_path / "Makefile").write_text("all: mine\n")
    (tmp_path / "toy.c").unlink()
    with pytest.raises(HydroservoError, match="Makefile: not written by hydroservo"):
        write_c_project(toy(), vectors, tmp_path)
    assert not (tmp_path / "toy.c").exists()


def test_the_readme_tells_what_is_exported(folder):
    exported, text = toy(), (folder / "README.md").read_text()
    assert text.startswith(f"# {exported.title}\n")
    for fact in (exported.hash, exported.version, "1e-05 s", "24 bytes of state for each instance; 32 bytes"):
        assert fact in text
    for signal in exported.parameters:
        row = f"| `{signal.place}` | {signal.value!r} | {signal.unit} | {signal.meaning}"
        assert row in text
    for signal in (*exported.states, *(one for argument in exported.arguments for one in argument.signals)):
        assert f"| `{signal.place}` | {signal.unit} | {signal.meaning} |" in text
    assert "sample period; set before init |" in text
    assert exported.scenario in text
    assert "  \n" not in text
    assert "\n\n\n" not in text


def test_markdown_of_a_meaning_is_escaped(vectors):
    limit = Signal("controller.limit", "limit", "", "of |s|^a * 2", 1.0)
    text = c_project(toy()._replace(parameters=(limit,)), vectors)["README.md"]
    assert r"| `limit` | 1.0 | - | of \|s\|^a \* 2 |" in text


@needs("gcc")
@pytest.mark.parametrize("command", [False, True])
def test_the_readmes_example_compiles(vectors, tmp_path, command):
    exported = toy()
    if command:
        applied = Signal("measurement.command", "command", "V", "mean of u as applied", 0.0)
        measurement = exported.arguments[0]._replace(signals=(*exported.arguments[0].signals, applied))
        header = exported.header.replace("} toy_measurement;", "    double command;\n} toy_measurement;")
        exported = exported._replace(arguments=(measurement, exported.arguments[1]), header=header)
        vectors = vectors._replace(inputs=np.zeros((542, 3)))
    write_c_project(exported, vectors, tmp_path)
    text = (tmp_path / "README.md").read_text()
    assert ("measurement.command = applied;" in text) is command
    (tmp_path / "interrupt.c").write_text(re.findall(r"```c\n(.*?)```", text, re.S)[0])
    options = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-fsyntax-only"]
    subprocess.run(["gcc", *options, tmp_path / "interrupt.c"], check=True)


@needs("make", "arm-none-eabi-gcc")
def test_a_cross_compiler_builds_the_code(folder):
    command = re.search(r"^make (toy\.o CC=arm.*m4.*)$", (folder / "README.md").read_text(), re.M)
    compiler, flags = re.search(r"CC=(\S+) CFLAGS='(.*)'", command[1]).groups()
    done = make(folder, "toy.o", f"CC={compiler}", f"CFLAGS={flags} -Werror")
    assert (done.returncode, done.stderr) == (0, "")
    options = [*flags.split(), "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    replay = subprocess.run(
        [compiler, *options, "-c", "toy_replay.c"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (replay.returncode, replay.stderr) == (0, "")


def test_vectors_begin_as_the_simulation_does(loop, vectors):
    data = simulate(loop._replace(simulation=loop.simulation._replace(record_period=1e-5)), strict=True)
    for column, signal in enumerate(toy().states):
        np.testing.assert_array_equal(vectors.expected[:50, column], data[signal.path].values[:50])
    starts = np.linspace(0, 5001 - 50, 10).round().astype(int)
    for i, start in enumerate(starts):
        seen = vectors.inputs[50 * i : 50 * i + 50]
        np.testing.assert_array_equal(seen[:, 0], data["plant.velocity"].values[start : start + 50])
        np.testing.assert_array_equal(seen[:, 1], data["reference.value"].values[start : start + 50])


def test_vectors_hold_the_command_that_was_applied():
    changes = {
        "simulation.duration": 0.02,
        "hold.type": "DelayedHold",
        "hold.delay": 5e-6,
        "simulation.substeps": 2,
    }
    loop = load_scenario("paper/sine-pi", changes)
    command = Signal("measurement.command", "command", "V", "applied", 0.0)
    arguments = (toy().arguments[0]._replace(signals=(command,)), toy().arguments[1])
    found = made_vectors(loop, Part.CONTROLLER, toy()._replace(arguments=arguments)).inputs[:, 0]
    data = simulate(loop._replace(simulation=loop.simulation._replace(record_period=1e-5)), strict=True)
    u = data["controller.u"].values
    np.testing.assert_allclose(found[100:150], (0.5 * (u[:-1] + u[1:]))[2 * 217 - 2 :][:50], rtol=1e-12)


def test_bad_samples_come_last_in_double_alone(vectors, close_vectors):
    np.testing.assert_array_equal(vectors.inputs[:500], close_vectors.inputs)
    assert np.isnan(vectors.inputs[500]).tolist() == [True, False]
    assert np.isfinite(vectors.inputs[501:]).all()
    assert vectors.inputs[521].tolist() == [HUGE, HUGE]
    np.testing.assert_array_equal(vectors.inputs[522:], vectors.inputs[480:500])


def test_a_short_scenario_gives_all_its_samples():
    loop = load_scenario("paper/sine-pi", {"simulation.duration": 1e-3})
    assert len(made_vectors(loop, Part.CONTROLLER, toy()).inputs) == 101 + 42


def test_automatic_substeps_are_settled_first():
    loop = load_scenario("paper/sine-pi", {"simulation.duration": 1e-3, "simulation.substeps": "auto"})
    assert len(made_vectors(loop, Part.CONTROLLER, toy()).inputs) == 101 + 42


def test_memory_counts_the_numbers():
    assert memory(toy()) == (24, 32)
    assert memory(single(toy())) == (12, 16)
    assert memory(toy()._replace(inlined=True)) == (24, 0)


@pytest.mark.parametrize(
    ("scenario", "prefix"),
    [
        ("paper/sine-tsmc", "sine_tsmc"),
        ("rig/1khz-pi-sine", "law_1khz_pi_sine"),
        ("dir/My Law.v2.toml", "my_law_v2"),
        ("math.toml", "law_math"),
        ("double.toml", "law_double"),
        ("-.toml", "law"),
    ],
)
def test_the_prefix_comes_from_the_scenarios_name(scenario, prefix):
    assert default_prefix(scenario) == checked_prefix(prefix) == prefix


@pytest.mark.parametrize(
    "prefix", ["", "1st", "a-b", "../up", "a b", "é", "_a", "math", "Float", "double", "a\n"]
)
def test_a_prefix_that_names_cannot_begin_with(prefix, vectors, tmp_path):
    with pytest.raises(ParameterError, match=r"^prefix = "):
        write_c_project(toy()._replace(prefix=prefix), vectors, tmp_path / "new")
    assert not (tmp_path / "new").exists()
