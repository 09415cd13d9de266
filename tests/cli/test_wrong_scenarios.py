"""Whatever a scenario file holds, the loader gives a loop or says in one line what is wrong, at once."""

import time
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hydroservo import Loop, ScenarioError
from hydroservo.scenario import load_scenario, scenario_source
from tests.support.bases import on_base

LARGE = 2**20 - 500  # bytes, within the limit
LONGEST = 1900  # characters of a message
PI = on_base('[controller]\ntype = "PI"\n')
TSMC = on_base('[controller]\ntype = "TSMC"\n', law="tsmc")
NO_LAW = 'base = "rig/1khz"\n'

WRONG_TEXT = {
    "empty": ("", "plant: a [plant] table with a type is needed, or a base; it must be one of Cylinder, "),
    "no machine": (
        '[controller]\ntype = "PI"\nproportional_gain = 1\n',
        "plant: a [plant] table with a type is needed, or a base; it must be one of Cylinder, ",
    ),
    "no law": (
        NO_LAW,
        "controller: a [controller] table with a type is needed, or a base; it must be one of",
    ),
    "no type": (NO_LAW + "[controller]\n", "controller: a [controller] table with a type is needed"),
    "no gain": (
        NO_LAW + '[controller]\ntype = "PI"\n',
        "controller: proportional_gain is missing; it must be a finite number at least 0 [V s/m]",
    ),
    "no law in a wrapper": (
        NO_LAW + '[controller]\ntype = "DAC"\n',
        "controller.controller: a type is needed; it must be ",
    ),
    "number of a block of another type": (
        PI + '[plant]\ntype = "Cylinder"\n',
        "plant: area_a is missing; it must be a finite number above 0 [m^2]",
    ),
    "unknown key": (
        PI + "[plant]\nmas = 6\n",
        "plant.mas: unknown key (value 6); it must be one of mass, damping, ",
    ),
    "unknown key, nearest": (PI + "[plant]\nmas = 6\n", "; did you mean mass?"),
    "key of a table below": (PI + "[valve]\narea_gradient = 1\n", "; area_gradient is in valve.orifice"),
    "unknown table": (PI + "[plnt]\nmass = 6\n", "plnt: unknown key (value {'mass': 6})"),
    "nominal": (PI + "[nominal.plant]\nmass = 6\n", "nominal: unknown key"),
    "misspelt type": (
        on_base('[controller]\ntype = "TMSC"\n'),
        "controller.type: 'TMSC' is not a type here; did you mean TSMC?",
    ),
    "misspelt type, nearest": (on_base('[controller]\ntype = "tsmc"\n'), "did you mean TSMC?"),
    "type of another role": (
        on_base('[controller]\ntype = "TSMObserver"\n'),
        "'TSMObserver' cannot be a Controller: it says that its role is Observer",
    ),
    "type of a role without state": (
        on_base('[controller]\ntype = "Sine"\n'),
        "'Sine' cannot be a Controller: it says that its role is Load",
    ),
    "type of a class of its own": (
        PI + '[controller.saturation]\ntype = "Limit"\n',
        "must be Saturation",
    ),
    "type is a number": (on_base("[controller]\ntype = 3\n"), "controller.type: 3 must be one of"),
    "type is a huge number": (on_base(f"[controller]\ntype = 0x{'f' * 5000}\n"), "must be one of"),
    "title": (PI + "[title]\n", "title: {} must be a string"),
    "wrong dimension": (
        PI + '[plant]\nstroke = "40 bar"\n',
        "plant.stroke: '40 bar' does not convert to m; it must be a finite number above 0 [m]",
    ),
    "negative area": (
        PI + '[plant]\npiston_area = "-4.91 cm^2"\n',
        "plant.piston_area: '-4.91 cm^2' must be a finite number above 0 [m^2]",
    ),
    "nan": (PI + "[plant]\nmass = nan\n", "plant.mass: nan must be a finite number above 0 [kg]"),
    "inf": (PI + "[plant]\nmass = inf\n", "plant.mass: inf must be"),
    "overflow": (PI + "[plant]\nmass = 1e999\n", "plant.mass: inf must be"),
    "text": (PI + '[plant]\nmass = "heavy"\n', "plant.mass: 'heavy' is not a quantity such as '1.5 kg'"),
    "two lines of text": (PI + '[plant]\nmass = """a\nb"""\n', "plant.mass: 'a\\nb' is not a quantity"),
    "power tower": (PI + '[plant]\nmass = "9**9**9 kg"\n', "plant.mass: '9**9**9 kg' has a unit that cannot"),
    "boolean for a number": (PI + "[plant]\nmass = true\n", "plant.mass: True must be a finite number"),
    "date": (PI + "[plant]\nmass = 2026-01-01\n", "plant.mass: datetime.date(2026, 1, 1) must be"),
    "array": (PI + "[plant]\nmass = [6]\n", "plant.mass: [6] must be"),
    "table for a number": (PI + "[plant.mass]\n", "plant.mass: {} must be"),
    "number for a table": (PI + "plant = 3\n", "controller.plant: unknown key"),
    "number for a top table": ("plant = 3\n" + PI, "plant: 3 must be a table: [plant]"),
    "string for a block": (PI + '[controller.saturation]\nlimit = "10"\n', "has no unit; write '10 V'"),
    "array of tables": (
        on_base('[[controller]]\ntype = "PI"\n'),
        "controller: [{'type': 'PI'}] must be a table",
    ),
    "broken number of steps": (
        PI + "[simulation]\nsubsteps = 1.5\n",
        "simulation.substeps: 1.5 must be a whole number at least 1",
    ),
    "zero steps": (PI + "[simulation]\nsubsteps = 0\n", "simulation.substeps: 0 must be a whole number"),
    "steps beyond 64 bits": (PI + f"[simulation]\nsubsteps = {2**63}\n", "must be a whole number"),
    "huge hexadecimal": (PI + f"[plant]\nmass = 0x{'f' * 5000}\n", "plant.mass: a huge int must be"),
    "recording without a file": (PI + '[load]\ntype = "Recorded"\n', "load.series: a file is needed"),
    "missing recording": (
        PI + '[load]\ntype = "Recorded"\nseries.file = "none.csv"\n',
        "load.series.file: 'none.csv' there is no such file",
    ),
    "deep unknown key": (
        TSMC + "[controller.observer.realisation]\nwidth = 1\n",
        "controller.observer.realisation.width: unknown key (value 1); it must be one of velocity_thickness",
    ),
    "uncertain path": (
        PI + "[uncertainty]\nplant.dampin = 0.1\n",
        "uncertainty.plant.dampin: unknown key (value 0.1)",
    ),
    "uncertain path, nearest": (PI + "[uncertainty]\nplant.dampin = 0.1\n", "did you mean plant.damping?"),
    "uncertain group": (PI + "[uncertainty]\nplant = 0.1\n", "uncertainty.plant: unknown key (value 0.1)"),
    "uncertain control": (
        PI + "[uncertainty]\ncontroller.integral_gain = 0.1\n",
        "integral_gain: unknown key",
    ),
    "uncertain text": (
        PI + '[uncertainty]\nplant.damping = "10 kg"\n',
        "uncertainty.plant.damping: '10 kg' is not dimensionless; it must be a finite number",
    ),
    "uncertain scale": (
        PI + '[uncertainty]\nscale = "much"\n',
        "uncertainty.scale: 'much' is not a quantity",
    ),
    "uncertainty out of range": (
        PI + '[uncertainty]\nplant.mass = "-100 %"\n',
        "'-100 %' with scale 1 makes plant.mass 0; it must be a finite number above 0 [kg]",
    ),
    "quoted key with a line break": (PI + '"a\\nb" = 1\n', "controller.a\\nb: unknown key (value 1)"),
    "long key": (PI + f"{'a' * LARGE} = 1\n", "unknown key (value 1)"),
    "not TOML": (PI + "[plant\nmass = 6\n", "is not TOML: "),
    "truncated": (scenario_source("paper/machine")[:-6], "is not TOML: "),
    "a quantity without quotes": (
        PI + "plant = { mass = 6 kg }\n",
        'a number with a unit needs quotes: "6 kg"',
    ),
    "a decimal comma": (PI + "plant = { mass = 6,5 }\n", "the decimal sign is a point: 6.5"),
    "a word without quotes": (PI + "plant.type = Cylinder\n", 'a text needs quotes: "Cylinder"'),
    "a table in braces of two lines": (
        PI + 'plant = { mass = "6 kg",\n }\n',
        "a table in braces is one line",
    ),
    "the same key twice": (PI + 'type = "TSMC"\n', "is not TOML: "),
    "million digits": (PI + f"[plant]\nmass = {'9' * 10**6}\n", "holds an integer of too many digits"),
    "million digits after the point": (
        PI + f"[plant]\nmass = -0.{'9' * 10**6}\n",
        "plant.mass: -1.0 must be",
    ),
    "million hexadecimal digits": (
        PI + f"[plant]\nmass = 0x{'9' * 10**6}\n",
        "plant.mass: a huge int must be",
    ),
    "nested arrays": ("a = " + "[" * LARGE, "tables nested more than 16 deep"),
    "nested tables": ("a = " + "{a=" * (LARGE // 3), "tables nested more than 16 deep"),
    "closed nested arrays": ("a = " + "[" * 40 + "]" * 40, "tables nested more than 16 deep"),
    "dotted key": (".".join("a" * (LARGE // 2)) + " = 1", "tables nested more than 16 deep"),
    "dotted quoted key": (".".join(['"a"'] * (LARGE // 4)) + " = 1", "tables nested more than 16 deep"),
    "dotted key in a table": ("a = {" + ".".join("a" * 30_000) + " = 1}", "tables nested more than 16 deep"),
    "dotted header": ("[" + ".".join("a" * (LARGE // 2)) + "]", "tables nested more than 16 deep"),
    "many tables": (on_base("[[a]]\n" * (LARGE // 6)), "a: unknown key"),
    "many keys": (on_base("".join(f"a{i} = 1\n" for i in range(70_000))), "a0: unknown key"),
    "many numbers": (PI + "[plant]\nmass = [" + "1," * (LARGE // 2 - 50) + "]", "plant.mass: [1, 1, "),
    "spaces": (" " * LARGE, "a [plant] table"),
    "spaces before a key": (" " * LARGE + "[ ] = 1", "is not TOML"),
    "line breaks": ("\n" * LARGE, "a [plant] table"),
}

WRONG_BYTES = {
    "binary": (bytes(range(256)), "is not UTF-8 text (line 2)"),
    "null": (b"\0", "is not TOML"),
    "latin-1": (PI.encode() + b"# \xe9\n", "is not UTF-8 text (line 4)"),
    "UTF-16": (PI.encode("utf-16"), "is UTF-16 text"),
    "two byte order marks": (b"\xef\xbb\xbf" * 2 + PI.encode(), "is not TOML"),
    "huge": (b"#" * (2**20 + 1), "is larger than 1 MiB"),
}


def refused(source: str | Path, changes: dict[str, object] | None = None) -> str:
    """The message of the error, which came at once and has one line."""
    load_scenario("paper/sine-pi")  # what is read once, is
    start = time.process_time()
    with pytest.raises(ScenarioError) as caught:
        load_scenario(source, changes)
    assert time.process_time() - start < 5.0
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < LONGEST
    return message


@pytest.mark.parametrize("case", WRONG_TEXT)
def test_wrong_text(tmp_path: Path, case: str) -> None:
    text, problem = WRONG_TEXT[case]
    path = tmp_path / "wrong.toml"
    path.write_text(text, encoding="utf-8")
    message = refused(path)
    assert message.startswith(f"{path}: ")
    assert problem in message


@pytest.mark.parametrize("case", WRONG_BYTES)
def test_wrong_bytes(tmp_path: Path, case: str) -> None:
    content, problem = WRONG_BYTES[case]
    path = tmp_path / "wrong.toml"
    path.write_bytes(content)
    assert refused(path).startswith(f"{path}: {problem}")


def test_a_file_of_a_name_like_it_is_offered(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("")
    assert refused(tmp_path / "mine.tml").endswith("; did you mean mine.toml?")


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        (
            "paper/sine-tmsc",
            "there is no such file, and no built-in scenario of that name; did you mean paper/sine-tsmc?",
        ),
        ("nowhere.toml", "nowhere.toml: there is no such file"),
        ("", "is a directory"),
        (".", "is a directory"),
        ("/dev/zero", "is not a regular file"),
        ("a\0b", "a\\x00b: "),
        ("a" * 5000, "cannot be read: file name too long"),
        ("two\nlines", "two\\nlines: there is no such file"),
    ],
)
def test_wrong_sources(source: str, problem: str) -> None:
    assert problem in refused(source)


@pytest.mark.skipif("__import__('os').geteuid() == 0", reason="root may read everything")
def test_a_file_that_may_not_be_read(tmp_path: Path) -> None:
    path = tmp_path / "secret.toml"
    path.touch(mode=0o000)
    assert "cannot be read: permission denied" in refused(path)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        (
            {"plant.mass": -1},
            "paper/sine-pi, overridden: plant.mass: -1 must be a finite number above 0 [kg]",
        ),
        ({"plant.mas": 1}, "overridden: plant.mas: unknown key (value 1)"),
        ({"plant": 3}, "overridden: plant: 3 must be a table: give plant.type or the keys in it"),
        ({"controller.saturation": "none"}, "controller.saturation: 'none' must be a table"),
        ({"plant.mass.value": 3}, "plant.mass: {'value': 3} must be"),
        (
            {"controller.type": "TSM"},
            "controller.type: 'TSM' is not a type here; did you mean TSMC?; a class",
        ),
        ({"plant.mass": 3, "plant.mass.x": 1}, "overrides: plant.mass.x: mass is also given a value"),
        ({"plant.mass.x": 1, "plant.mass": 3}, "overrides: plant.mass: 3 is given where other overrides"),
        ({"": 1}, "overrides: '': must be a dotted path"),
        ({"plant..mass": 1}, "must be a dotted path"),
        ({".".join("a" * 100): 1}, "must have at most 16 parts"),
        ({"plant.mass": 10**400}, "plant.mass: 1000"),
        ({"plant.mass": None}, "plant.mass: None must be"),
        ({"simulation.period": "10 kHz"}, "simulation.period: '10 kHz' does not convert to s"),
        ({"uncertainty.scale": -10}, "with scale -10 makes"),
    ],
)
def test_wrong_changes(changes: dict[str, object], problem: str) -> None:
    assert problem in refused("paper/sine-pi", changes)


def outcome(source: str | Path, changes: dict[str, object] | None = None) -> Loop | str:
    """The loop, or the message of a ScenarioError; any other error fails the test."""
    try:
        return load_scenario(source, changes)
    except ScenarioError as error:
        return str(error)


def is_loop_or_line(result: Loop | str) -> bool:
    return isinstance(result, Loop) or (result.isprintable() and len(result) < LONGEST)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz") / "any.toml"


@given(content=st.one_of(st.binary(max_size=200), st.text(max_size=200).map(lambda text: text.encode())))
def test_any_bytes(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    assert is_loop_or_line(outcome(file))


SNIPPETS = st.one_of(
    st.text(max_size=8),
    st.sampled_from(
        [
            "[",
            "]",
            "{",
            "}",
            '"',
            "'",
            '"""',
            "=",
            ".",
            ",",
            "\n",
            "nan",
            "-inf",
            "1e999",
            "true",
            "[[",
            "]]",
            "#",
            "\\",
        ]
    ),
    st.sampled_from(
        ["type", "plant", "controller", "model", "TSMC", "PI", "Sine", "bar", "%", "scale", "9**9", "base"]
    ),
)
NAMES = ("paper/machine", "paper/sine-tsmc", "paper/square-backstepping", "rig/noisy-1khz-pi-sine")
SOURCES = st.sampled_from([scenario_source(name) for name in NAMES])


@example(text=scenario_source("paper/sine-tsmc"), cuts=[])
@given(text=SOURCES, cuts=st.lists(st.tuples(st.floats(0, 1), st.integers(0, 30), SNIPPETS), max_size=3))
def test_any_mutation(file: Path, text: str, cuts: list[tuple[float, int, str]]) -> None:
    for place, length, snippet in cuts:
        start = int(place * len(text))
        text = text[:start] + snippet + text[start + length :]
    file.write_bytes(text.encode())
    assert is_loop_or_line(outcome(file))


VALUES = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(max_size=12),
        st.sampled_from(
            ["40 bar", "6 kg", "PI", "TSMC", "Sine", "Recorded", "5/7", "1e99 m", "10 %", "/dev/null"]
        ),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3), st.dictionaries(st.sampled_from(["type", "mass", "a"]), inner)
    ),
    max_leaves=5,
)
PATHS = st.lists(
    st.sampled_from(
        [
            "plant",
            "controller",
            "type",
            "model",
            "mass",
            "uncertainty",
            "scale",
            "load",
            "series",
            "file",
            "reference",
            "title",
            "base",
            "tune",
            "vary",
        ]
    ),
    min_size=1,
    max_size=4,
).map(".".join)


@given(changes=st.dictionaries(PATHS, VALUES, max_size=4))
def test_any_changes(changes: dict[str, object]) -> None:
    assert is_loop_or_line(outcome("paper/sine-tsmc", changes))
