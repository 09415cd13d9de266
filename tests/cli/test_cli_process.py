"""The command as a process of its own: streams, signals and exit statuses."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hydroservo.cli.messages import progress_bar
from tests.support.commands.processes import (
    HYDROSERVO,
    ends_by,
    leaves_nothing,
    needs_posix,
    on_terminal,
    process,
)
from tests.support.commands.runner import failed
from tests.support.needs import needs

QUICK = ("run", "paper/sine-pi", "--set", "simulation.duration=0.02", "--interpreted")
HOURS = ("--set", "simulation.duration=1e5", "--set", "simulation.record_period=10")

pytestmark = pytest.mark.slow  # processes of their own

needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")


def test_json_is_all_there_is_on_stdout_and_stderr_is_empty(tmp_path):
    done = process(*QUICK, "--json", "--out", str(tmp_path))
    assert done.returncode == 0
    assert json.loads(done.stdout)["scenario"] == "paper/sine-pi"
    assert done.stderr == ""


def test_an_error_is_one_line_on_stderr_and_status_2():
    done = process("run", "paper/sine-pie")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("hydroservo: paper/sine-pie: ")
    assert done.stderr.count("\n") == 1


def test_wrong_usage_is_one_line_and_status_2():
    done = process("run", "paper/sine-pi", "--nothing")
    assert done.returncode == 2
    assert done.stderr == "hydroservo: no such option: --nothing (see hydroservo run --help)\n"


@pytest.mark.parametrize("module", ["hydroservo.cli", "hydroservo.cli.commands"])
def test_heavy_libraries_wait_until_they_are_used(module):
    heavy = "{'matplotlib', 'numpy', 'xarray', 'pandas', 'scipy', 'pyarrow', 'pydantic', 'jinja2', 'rich'}"
    code = f"import sys, {module}; print(*sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.parametrize("given", [None, "3"])
def test_designs_have_one_thread_unless_told_otherwise(given):
    """Of OpenBLAS, which reads its variable where numpy and scipy load it."""
    code = "import atexit, os, sys; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS']))"
    code += "; from hydroservo.cli import main; assert 'numpy' not in sys.modules; main()"
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    environment |= {} if given is None else {"OPENBLAS_NUM_THREADS": given}
    done = subprocess.run(
        [sys.executable, "-c", code, "--version"], text=True, capture_output=True, check=True, env=environment
    )
    assert done.stdout.split()[-1] == (given or "1")


INTERRUPTED_AT = """
import builtins, os, signal, sys
from hydroservo.cli import main
find, wanted = builtins.__import__, sys.argv.pop(1)
def importing(name, *args):
    if name == wanted:
        builtins.__import__ = find
        os.kill(os.getpid(), signal.SIGINT)
    return find(name, *args)
builtins.__import__ = importing
main()
"""


@needs_posix
@pytest.mark.parametrize("module", ["hydroservo.cli.commands", "typer", "numpy", "xarray", "pandas"])
def test_ctrl_c_while_libraries_are_imported_is_one_line(module):
    words = [sys.executable, "-c", INTERRUPTED_AT, module, "compare", "paper/sine-pi"]
    done = subprocess.run(words, text=True, capture_output=True, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "hydroservo: interrupted; nothing was left half-written\n"


LOADED = """
import sys
from hydroservo.cli import main
try:
    main()
finally:
    print(*{name.partition(".")[0] for name in sys.modules}, file=sys.stderr)
"""


@pytest.mark.parametrize("words", [("--version",), ("scenarios",), ("studies",)])
def test_what_says_little_loads_little(words):
    done = subprocess.run([sys.executable, "-c", LOADED, *words], text=True, capture_output=True, check=True)
    assert not set(done.stderr.split()) & {"jinja2", "llvmlite", "numpy", "pandas", "scipy", "xarray"}


def test_a_run_that_leaves_no_files_waits_for_no_library_that_it_does_not_need():
    words = [
        sys.executable,
        "-c",
        LOADED,
        "run",
        "paper/sine-pi",
        "--set",
        "simulation.duration=0.01s",
        "--json",
    ]
    loaded = set(subprocess.run(words, text=True, capture_output=True, check=True).stderr.split())
    assert "numpy" in loaded
    assert not loaded & {"jinja2", "matplotlib", "numba", "pandas", "pint", "scipy", "xarray"}


ENDED = """
import atexit, os, signal
from hydroservo.cli import main
atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))
main()
"""


@needs_posix
def test_ctrl_c_after_all_is_done_changes_nothing():
    done = subprocess.run(
        [sys.executable, "-c", ENDED, "--version"], text=True, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("hydroservo ")


IGNORED = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_IGN)
os.execv(sys.executable, [sys.executable, "-c", sys.argv[1], "run", "paper/sine-pi", "--json", *sys.argv[2:]])
"""
AS_IT_BEGINS = """
import os, signal
os.kill(os.getpid(), signal.SIGINT)
from hydroservo.cli import main
os.kill(os.getpid(), signal.SIGINT)
main()
"""


@needs_posix
def test_a_command_of_a_script_s_background_is_not_interrupted(tmp_path):
    words = [
        sys.executable,
        "-c",
        IGNORED,
        AS_IT_BEGINS,
        "--out",
        tmp_path,
        "--set",
        "simulation.duration=1ms",
    ]
    done = subprocess.run(words, text=True, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "metrics.json").exists()


@needs_posix
@pytest.mark.parametrize(
    "args",
    [
        ("run", "paper/sine-tsmc", "--interpreted"),
        ("run", "paper/sine-tsmc", *HOURS),
        ("compare", "paper/sine-tsmc", "paper/sine-pi", *HOURS),
        ("paper",),
    ],
)
def test_ctrl_c_leaves_nothing_half_written(tmp_path, args):
    out = tmp_path / "out"
    leaves_nothing(out, *args, "--out", str(out))


@needs_posix
@pytest.mark.parametrize(
    ("number", "word"),
    [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated"), (signal.SIGHUP, "hung up")],
)
def test_signals_that_end_a_command_leave_nothing(tmp_path, number, word):
    ends_by(number, word, tmp_path, "run", "paper/sine-tsmc", *HOURS, "--out", str(tmp_path / "out"))


EXPORTING = """
import os, signal, sys
from hydroservo.export import compilers
from hydroservo.cli import main
compile_file, number = compilers.compile_file, int(sys.argv.pop(1))
def compiling(folder, *args, **options):
    assert list(folder.iterdir())
    signal.raise_signal(number)
    return compile_file(folder, *args, **options)
for module in list(sys.modules.values()):
    if getattr(module, "compile_file", None) is compile_file:
        module.compile_file = compiling
compilers.compile_file = compiling
main()
"""


@needs_posix
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_an_export_that_is_ended_removes_its_folders(tmp_path, number):
    needs("cc")
    out, temporary = tmp_path / "law.fmu", tmp_path / "temporary"
    temporary.mkdir()
    words = ["export", "fmu", "rig/1khz-pi-sine", "--out", str(out)]
    done = subprocess.run(
        [sys.executable, "-c", EXPORTING, str(int(number)), *words],
        text=True,
        capture_output=True,
        check=False,
        env={**os.environ, "TMPDIR": str(temporary)},
    )
    assert done.returncode == 128 + number
    assert list(temporary.iterdir()) == []
    assert not out.exists()


NOHUP = """
import os, signal, sys
signal.signal(signal.SIGHUP, signal.SIG_IGN)
os.execv(sys.executable, [sys.executable, "-c", sys.argv[1], *sys.argv[2:]])
"""
HUNG_UP = """
import os, signal
from hydroservo.cli import main
os.kill(os.getpid(), signal.SIGHUP)
main()
"""


@needs_posix
def test_nohup_holds():
    words = [sys.executable, "-c", NOHUP, HUNG_UP, "--version"]
    assert subprocess.run(words, text=True, capture_output=True, check=False).returncode == 0


ENDLESS = """
from pathlib import Path
from typing import Annotated, NamedTuple

from hydroservo import Field


class State(NamedTuple):
    u: Annotated[float, Field("V", "command")]


class Endless(NamedTuple):
    def init(self):
        return State(0.0)

    def step(self, s, y, r, dt):
        x = {start}
        while x > 0.5:
            x = x + 1.0
        return State(x)


Path(__file__).with_name("loaded").touch()
"""
IMPATIENT = """
import hydroservo.cli.interrupts
from hydroservo.cli import main
hydroservo.cli.interrupts.PATIENCE = 0.5
main()
"""


@needs_posix
@pytest.mark.slow  # waits for time to run out
@pytest.mark.parametrize(
    ("start", "says"),
    [
        ("1.0", r" in Endless.step \(.*law.py, line 1[6-8]\)"),
        ("1e3 * r.value", "; what was computed did not stop within 0.5 s, as a while without end does not"),
    ],
)
def test_ctrl_c_ends_a_law_that_never_returns(tmp_path, monkeypatch, start, says):
    """In plain Python at the first sample, then in compiled code, once the demand is no longer 0."""
    law = tmp_path / "law.py"
    tmp_path.chmod(0o700)
    monkeypatch.setenv("HYDROSERVO_CACHE_DIR", str(tmp_path))
    law.write_text(ENDLESS.format(start=start))
    (tmp_path / "my.toml").write_text('base = "paper/sine-pi"\ncontroller = { type = "Endless" }\n')
    words = ("run", tmp_path / "my.toml", "--plugin", law)
    with subprocess.Popen(
        [sys.executable, "-c", IMPATIENT, *words], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as running:
        begun = "*.kernel" if "r.value" in start else "loaded"
        while running.poll() is None and not any(tmp_path.glob(begun)):
            time.sleep(0.1)
        time.sleep(2.0)
        running.send_signal(signal.SIGINT)
        try:
            stdout, stderr = running.communicate(timeout=60)
        finally:
            running.kill()
    assert (running.returncode, stdout) == (130, "")
    assert re.fullmatch(f"hydroservo: interrupted{says}; nothing was left half-written\n", stderr)


@needs_posix
def test_a_reader_that_leaves_is_no_error():
    read, write = os.pipe()
    os.close(read)
    done = process("scenarios", "show", "paper/sine-tsmc", stdout=write, stderr=subprocess.PIPE)
    os.close(write)
    assert done.returncode == 1
    assert done.stderr == ""


@needs_full
@pytest.mark.parametrize(
    "args",
    [("scenarios",), ("scenarios", "show", "paper/sine-pi"), (*QUICK, "--json"), ("--version",), ("--help",)],
)
def test_a_full_stdout_is_one_line_and_status_2(args):
    with Path("/dev/full").open("w") as full:
        done = process(*args, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr == "hydroservo: No space left on device\n"


@needs_full
def test_a_full_stderr_changes_no_result():
    warned = (*QUICK, "--set", "plant.mass=1e9", "--json")
    with Path("/dev/full").open("w") as full:
        done = process(*warned, stdout=subprocess.PIPE, stderr=full)
        refused = process("run", "nothing", stdout=subprocess.PIPE, stderr=full)
    heard = process(*warned)
    assert (done.returncode, done.stdout) == (0, heard.stdout)
    assert "hydroservo: warning: " in heard.stderr
    assert (refused.returncode, refused.stdout) == (2, "")


@needs_posix
@pytest.mark.parametrize("closed", [0, 1, 2])
def test_a_stream_that_is_closed_keeps_no_file_from_being_written(tmp_path, closed):
    words = [*HYDROSERVO, *QUICK, "--out", str(tmp_path / "out")]
    done = subprocess.run(
        words, capture_output=True, text=True, check=False, preexec_fn=lambda: os.close(closed)
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads((tmp_path / "out" / "metrics.json").read_text())["scenario"].startswith("paper/sine-pi")
    assert (done.stdout == "") == (closed == 1)


@pytest.mark.parametrize("value", ["abc", "", "-5", "1" * 20])
def test_an_epoch_that_is_no_number_is_refused(value):
    done = process(*QUICK, env={**os.environ, "SOURCE_DATE_EPOCH": value}, stdout=-1, stderr=-1)
    assert done.returncode == 2
    assert done.stderr.startswith(
        f"hydroservo: SOURCE_DATE_EPOCH = {value!r}: must be a whole number of seconds"
    )


@pytest.mark.parametrize(
    ("name", "value"),
    [("MPLBACKEND", "foo"), ("MPLCONFIGDIR", "/proc/nothing"), ("COLUMNS", "x"), ("OMP_NUM_THREADS", "4,3")],
)
def test_odd_surroundings_change_nothing(tmp_path, name, value):
    done = process(*QUICK, "--out", str(tmp_path), env={**os.environ, name: value}, stdout=-1, stderr=-1)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "run.png").exists()


UNFORESEEN = """
from hydroservo.cli import main
def describe(*args, **options):
    raise ValueError("of a library")
from hydroservo.cli.commands import Commands
from typer.core import TyperGroup
TyperGroup.invoke = describe
main()
"""


def test_what_nothing_foresees_is_one_line():
    words = [sys.executable, "-c", UNFORESEEN, "scenarios"]
    done = subprocess.run(words, text=True, capture_output=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        "hydroservo: a defect of hydroservo: ValueError: of a library; with HYDROSERVO_TRACEBACK=1 in the "
        "environment it says where\n"
    )
    shown = {**os.environ, "HYDROSERVO_TRACEBACK": "1"}
    assert "Traceback" in subprocess.run(words, text=True, capture_output=True, check=False, env=shown).stderr


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("run", "paper/sine-pi", "--out", ""), "the word after --out is empty"),
        (("batch", "paper/sine-pi", "--runs", "3", "--seeds", "--out= "), "--out is empty"),
        (("bode", ""), "the word after bode is empty"),
        (("run", "caf\udce9.toml"), "'caf\\udce9.toml' is not UTF-8, as all words must be"),
    ],
)
def test_words_that_mean_nothing_are_refused(tmp_path, monkeypatch, words, problem):
    monkeypatch.chdir(tmp_path)
    assert failed(*words) == f"hydroservo: {problem} (see hydroservo --help)\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("title", ["液压轴 $x_1$ _^", "Ω⃗ שלום \N{GRINNING FACE}"])
def test_names_in_any_script_draw(tmp_path, title):
    file = tmp_path / f"{title.partition(' ')[0]}.toml"
    file.write_text(
        f"base = 'paper/sine-pi'\ntitle = '{title}'\nsimulation.duration = '20 ms'\n", encoding="utf-8"
    )
    out = tmp_path / title
    done = process("run", str(file), "--out", str(out))
    assert (done.returncode, done.stderr) == (0, "")
    assert file.stem in (out / "report.html").read_text(encoding="utf-8")


def test_a_terminal_without_a_sign_shows_another():
    done = process(*QUICK, env={**os.environ, "PYTHONIOENCODING": "ascii"}, stdout=-1, stderr=-1)
    assert done.returncode == 0
    assert done.stdout.isascii()
    assert "rms_error" in done.stdout


@needs_posix
def test_progress_is_shown_on_a_terminal_and_not_on_stdout():
    status, shown, stdout = on_terminal("stderr", *QUICK, "--json")
    assert status == 0
    assert json.loads(stdout)["scenario"] == "paper/sine-pi"
    assert "paper/sine-pi" in shown
    assert "%" in shown


class Log(io.StringIO):
    """A stream that is no terminal, whose clock goes on by a second with each report."""

    def __init__(self, monkeypatch):
        super().__init__()
        self.seconds = 0.0
        monkeypatch.setattr("time.monotonic", lambda: self.seconds)
        monkeypatch.setattr(sys, "stderr", self)
        monkeypatch.setattr("hydroservo.cli.messages.FIRST_LINE", 10.0)

    def lines_of(self, seconds):
        with progress_bar("a run") as report:
            for self.seconds in range(seconds):
                report(self.seconds / seconds, "a run")
        return self.getvalue().splitlines()


def test_what_takes_less_than_ten_seconds_leaves_no_line_in_a_log(monkeypatch):
    assert Log(monkeypatch).lines_of(10) == []


def test_progress_in_a_log_is_a_line_now_and_then(monkeypatch):
    assert Log(monkeypatch).lines_of(100) == [
        f"hydroservo: {percent} % done: a run" for percent in (10, 20, 40, 80)
    ]


def test_the_log_of_a_day_is_short_and_never_silent_for_long(monkeypatch):
    assert 100 < len(Log(monkeypatch).lines_of(24 * 3600)) < 200


def test_progress_in_a_log_of_a_command_goes_to_stderr_alone(monkeypatch):
    code = "from hydroservo.cli import main, messages; messages.FIRST_LINE = 0.0; main()"
    words = [sys.executable, "-c", code, *QUICK, "--json"]
    done = subprocess.run(words, text=True, capture_output=True, check=True)
    assert json.loads(done.stdout)["scenario"] == "paper/sine-pi"
    assert re.fullmatch(r"(hydroservo: \d+ % done: [^\n]*\n)+", done.stderr)


@needs_posix
def test_a_scenario_on_a_terminal_has_colours_and_the_same_text():
    status, shown, stderr = on_terminal("stdout", "scenarios", "show", "paper/sine-tsmc")
    assert (status, stderr) == (0, "")
    assert "\x1b[" in shown
    plain = process("scenarios", "show", "paper/sine-tsmc").stdout
    assert re.sub(r"\x1b\[[\d;]*m", "", shown) == plain
