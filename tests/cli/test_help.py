"""Help, version and the list of scenarios."""

import re
import shlex
from pathlib import Path

import pandas as pd
import pytest
from typer.main import get_command
from typer.testing import CliRunner

import hydroservo
from hydroservo.cli.commands import app
from hydroservo.cli.options import WHERE, parse_ranges
from hydroservo.scenario import load_scenario, parse_override, scenario_source, scenarios
from hydroservo.studies.spec_file import read_study, study_source
from tests.support.bases import on_base
from tests.support.commands.runner import PLUGIN, QUICK, SHORT, SMALL, failed, hydroservo_, succeeded
from tests.support.needs import needs
from tests.support.synthetic_logs import exact_log, recorded, with_units
from tests.support.tiers import mostly


def test_version():
    assert succeeded("--version") == f"hydroservo {hydroservo.__version__}\n"


def test_no_arguments_show_help():
    assert "Usage: hydroservo" in CliRunner().invoke(app, [], prog_name="hydroservo").output


def commands_with_out(command, above=()):
    """The words of each command that has --out, and the help of that option."""
    for name, inner in getattr(command, "commands", {}).items():
        yield from commands_with_out(inner, (*above, name))
        yield from (((*above, name), one.help) for one in inner.params if "--out" in one.opts)


def test_out_means_the_same_in_each_command():
    found = dict(commands_with_out(get_command(app)))
    assert {("run",), ("batch",), ("tune",), ("log",), ("schema",), ("export", "fmu")} <= set(found)
    assert [words for words, text in found.items() if not text.endswith(WHERE)] == []


@pytest.mark.parametrize(
    ("words", "out", "said"),
    [
        (("run", "paper/sine-pi"), "run.csv", "is a file, by its ending; for a folder write 'run.csv/'"),
        (("audit", "paper/sine-pi"), "audit.html", "is a file, by its ending"),
        (("study", "small"), "study.d", "is a file, by its ending"),
        (("paper",), "paper.html", "is a file, by its ending"),
        (("export", "c", "paper/sine-pi"), "law.c", "is a file, by its ending"),
        (("run", "paper/sine-pi"), "there", "'there' is a file, and this command writes into a folder"),
        (("export", "fmu", "paper/sine-pi"), "law", "is a folder, and this command writes a file"),
        (("export", "ssp", "paper/sine-pi"), "law.ssp/", "is a folder, and this command writes a file"),
        (("export", "page", "paper/sine-pi"), "page", "is a folder, and this command writes a file"),
        (("schema",), "schema", "is a folder, and this command writes a file"),
        (("log", "there"), "picture.html", "must end in one of .png, .svg, .pdf, or be a folder"),
    ],
)
def test_a_place_of_the_other_kind_is_one_line(words, out, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("there").touch()
    assert said in failed(*words, "--out", out)
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_a_name_without_an_ending_or_with_a_slash_is_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for out in ("plain", "with.ending/", "with.ending"):  # the last of which is there by then
        succeeded("run", "paper/sine-pi", *QUICK, "--out", out)
        assert "run.png" in {path.name for path in Path(out).iterdir()}
    succeeded("bode", "rig/1khz-pi-sine", "--linear", "--out", "plain")
    assert Path("plain/bode.png").exists()
    succeeded("batch", "paper/sine-pi", *SHORT, "--seeds", "--runs", "2", "--out", "runs")
    assert Path("runs/batch.json").exists()


def names_of(command, above=""):
    """The names of a command's commands, and of theirs, as they are typed; not of what only holds others."""
    for name, inner in getattr(command, "commands", {}).items():
        if not hasattr(inner, "commands") or inner.invoke_without_command:
            yield f"{above}{name}"
        yield from names_of(inner, f"{above}{name} ")


def help_texts(command):
    """All that the help of a command and of those below it says."""
    yield command.help or ""
    yield from (getattr(param, "help", None) or "" for param in command.params)
    for inner in getattr(command, "commands", {}).values():
        yield from help_texts(inner)


MASS, BULK = 'plant.mass = "-40%..+70%"\n', 'plant.bulk_modulus = "-40%..+70%"\n'
COMMANDS = get_command(app)
QUOTED = re.findall(r"`([^`]+)`", "\n".join(help_texts(COMMANDS)))
EXAMPLES = sorted({text.removeprefix("hydroservo ") for text in QUOTED if text.startswith("hydroservo ")})
SERVES = re.compile("app ")  # until an interrupt
ALONE = [text for text in EXAMPLES if "--scheduler" not in text and not SERVES.match(text)]
RARE = re.compile("study |.*-windows")  # take minutes, or a cross compiler
OFTEN = [text for text in ALONE if not RARE.match(text)]
CHANGES = sorted({text for text in QUOTED if "=" in text} - {f"hydroservo {text}" for text in EXAMPLES})


@pytest.mark.parametrize("command", ["", *names_of(COMMANDS)])
def test_help(command):
    assert "Usage" in succeeded(*command.split(), "--help")


def test_the_reference_has_the_help_of_each_command():
    text = (Path(__file__).parents[2] / "docs" / "reference" / "cli.md").read_text(encoding="utf-8")
    shown = re.findall(
        r"^## (.+)$\s+```.*$\s+:tags:.*$\s+cells\.terminal\(\"hydroservo (.+) --help\"\)$", text, re.M
    )
    assert sorted(shown) == sorted((name, name) for name in names_of(COMMANDS))


def test_the_help_has_examples():
    assert len(EXAMPLES) >= 8
    assert len(CHANGES) >= 3


@pytest.mark.slow
@pytest.mark.usefixtures("forgotten")
@pytest.mark.parametrize("example", mostly(pytest.mark.nightly, ALONE, OFTEN))
def test_each_example_of_the_help_runs(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my_controller.py").write_text(PLUGIN)
    Path("my.toml").write_text(on_base('[controller]\ntype = "Fixed"\n'))
    Path("larger.toml").write_text(on_base(f"[identify.vary]\n{MASS}{BULK}"))
    Path("smaller.toml").write_text(on_base(f"[identify.vary]\n{MASS}"))
    Path("my-study.toml").write_text(study_source("small"))
    for number, log in enumerate(("bench.csv", "warm.csv")):
        pd.DataFrame(with_units(recorded(exact_log(), number))).to_csv(log, index=False)
    args = shlex.split(example.partition(" > ")[0])
    if args[:2] == ["export", "fmu"]:
        needs("cc")
    plugin = ("--plugin", "my_controller.py")
    few = ("--candidates", "128")
    more = {
        "run": QUICK,
        "compare": SHORT,
        "batch": SHORT,
        "tune": few,
        "study": SMALL,
        "identify": plugin,
        "log": plugin if "--scenario" in args else (),
        "map": plugin,
    }
    result = hydroservo_(*args, *more.get(args[0], ()))
    unfit = args[0] == "identify"  # the logs are of a machine whose valve lags, which these scenarios lack
    assert result.exit_code == (3 if unfit else 0), result.output


@pytest.mark.parametrize("change", CHANGES)
def test_each_change_that_the_help_shows_is_one(change):
    if ".." in change:
        assert len(parse_ranges([change])) == 1
        return
    changed = dict([parse_override(*shlex.split(change))])
    if change.startswith(("search.", "conditions.")):
        read_study("small", changed)
    else:
        load_scenario("paper/sine-pi", changed)


def test_scenarios_lists_each_with_its_title():
    text = succeeded("scenarios")
    for name, title in scenarios().items():
        assert [name, *title.split()] in [line.split() for line in text.splitlines()]


def test_scenarios_show_prints_the_source_as_it_is():
    assert succeeded("scenarios", "show", "paper/sine-tsmc") == scenario_source("paper/sine-tsmc")


def test_scenarios_show_names_what_is_not_there():
    assert "paper/sine-tsm" in failed("scenarios", "show", "paper/sine-tsm")
