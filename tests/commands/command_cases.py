"""Command lines that a hurried, a careless or a hostile user may type: a number determines each."""

import random
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.block import leaves
from hydroservo.scenario import builtin_scenarios, load_scenario, scenario_source

__all__ = ["KINDS", "Case", "case"]

Words = list[str]

SCENARIOS = tuple(builtin_scenarios())
COSTLY = {"export": 0.1, "steps": 0.15, "written": 0.05}  # the share of what takes long, where others have 1
SHORT = ("--set", "simulation.duration=0.02 s", "--set", "simulation.record_period=1 ms")
NUMBERS = (
    *(
        "nan",
        "inf",
        "-inf",
        "0",
        "-0.0",
        "-1",
        "1",
        "0.5",
        "2",
        "1e-300",
        "5e-324",
        "1e300",
        "1.8446744073709552e14",
    ),
    *(
        "1e15",
        "9223372036854775807",
        "-9223372036854775808",
        "1e400",
        "007",
        "1_000",
        "0x10",
        "1e",
        "--1",
        "1,5",
    ),
)
UNITS = (
    *(
        "",
        "s",
        "ms",
        "us",
        "m",
        "mm",
        "bar",
        "Pa",
        "kg",
        "V",
        "mV",
        "m/s",
        "mm/s",
        "N",
        "kN",
        "Hz",
        "1/s",
        "%",
        "deg",
    ),
    *(
        "V s/m",
        "m^3/(s Pa)",
        "m^(2/7)/s^(9/7)",
        "furlong",
        "°C",
        "bar/",
        "/s",
        "m^99",
        "(m",
        "L/min",
        "kWh",
        "µm",
        "mm ",
    ),
)
TEXTS = (
    *(
        "",
        " ",
        "auto",
        "true",
        "false",
        "True",
        "None",
        "[]",
        "{}",
        "[1, 2]",
        "{a = 1}",
        "PI",
        "TSMC",
        "Cylinder",
    ),
    *(
        "Cylinder.from_diameters",
        "hydroservo",
        "../..",
        "/dev/null",
        "/dev/zero",
        "a" * 5000,
        "\x00",
        "\n",
        "ß",
        "\U0001f600",
    ),
    *(
        "__class__",
        "__import__('os')",
        "'",
        '"',
        "\\",
        "= 1",
        "a.b.c",
        "\x1b[31m",
        "[bold]",
        "-",
        "--help",
        "%s",
        "{0}",
    ),
)
PATHS = (
    "",
    ".",
    "a",
    "plant",
    "plant.",
    ".mass",
    "plant..mass",
    "plant.mass.x",
    "title",
    "nominal.plant.mass",
    "uncertainty.scale",
)
FILES = (
    "",
    ".",
    "nope.toml",
    "folder",
    "/dev/null",
    "/dev/full",
    "missing/deep/file.csv",
    "a" * 300,
    "file\x00.csv",
    "taken",
)
ENDINGS = (
    ".csv",
    ".parquet",
    ".nc",
    ".mat",
    ".png",
    ".svg",
    ".pdf",
    ".fmu",
    ".toml",
    ".exe",
    "",
    ".CSV",
    ".c",
)
GOOD_RANGES = (
    "plant.mass=4..8kg",
    "controller.proportional_gain=1..100",
    "load.amplitude=-50%..+50%",
    "supply.supply_pressure=30..50bar",
)
CELLS = (
    "",
    "nan",
    "inf",
    "1e400",
    "abc",
    "1,5",
    "1.5",
    "-0",
    '"',
    '"1',
    ";",
    "\t",
    "1e-320",
    "1_0",
    "\u0661",
    "0x1p3",
    " 2 ",
)
HEADERS = ("t|v", "t [ms]|v [m/s]", "t (s)|v [", "t [s]|t [s]", "1|2", "t [s]", "t [s]|v [kg]", "|")
SERIES = (
    *['file = "log.csv"'] * 4,
    'file = "log.csv", column = "v"',
    'file = "log.csv", time = "v"',
    'file = ""',
    "file = 3",
)
RECORDED = """
[simulation]
duration = "0.02 s"
period = "1 ms"
substeps = 20
[{role}]
type = "Recorded"
series = {{{keys}}}
[controller]
type = "PI"
"""
PLUGIN = '''
from typing import Annotated, NamedTuple
from hydroservo import Field, ops

class OwnState(NamedTuple):
    u: Annotated[float, Field("V", "command")]

class Own(NamedTuple):
    """A law."""
    gain: Annotated[float, Field("V s/m", "gain", "chosen", above=0)] = 1.0

    def init(self):
        {init}

    def step(self, s, y, r, dt):
        {step}
'''
INITS = (
    "return OwnState(0.0)",
    "return OwnState(0)",
    "return 1.0",
    "return None",
    "raise ValueError('no')",
    "pass",
    "return self",
)
STEPS = (
    "return OwnState(self.gain * (r.value - y.velocity))",
    "return OwnState(self.gian * r.value)",
    "return OwnState(1.0 / (r.value * 0.0))",
    "return OwnState(float('nan'))",
    "return OwnState(1e308 * 1e308)",
    "return OwnState('u')",
    "return s.u",
    "return None",
    "return OwnState(ops.power(-1.0, 0.5))",
    "return OwnState(ops.nothing(1.0))",
    "return self.step(s, y, r, dt)",
    "import os; return OwnState(0.0)",
    "raise RuntimeError('line one\\nline two')",
    "return OwnState(y.pressure_a)",
    "return OwnState(y.position * 0.0 + [1.0][5])",
    "return",
)
ENDS = (
    "",
    "\n1/0",
    "\nraise SystemExit(3)",
    "\nimport nothing_of_that_name",
    "\nclass Own: pass",
    "\n)",
    "\nOwn = 3",
    "\n\x00",
)


class Case(NamedTuple):
    """A command and the files that it finds in its folder."""

    kind: str
    words: Words
    files: dict[str, bytes]


def case(number: int) -> Case:
    """The case of a number, the same everywhere."""
    draw = random.Random(f"hydroservo {number}")  # noqa: S311 - it shall be repeatable
    kind = draw.choices(list(KINDS), [COSTLY.get(name, 1.0) for name in KINDS])[0]
    words, files = KINDS[kind](draw)
    return Case(kind, words, {"taken/file": b"", **files})


def settings(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Numbers of a scenario that are out of range, of another unit, or nothing like a number."""
    name = draw.choice(SCENARIOS)
    words = ["run", name, "--interpreted", *SHORT]
    for _ in range(draw.randint(1, 3)):
        words += ["--set", setting(draw, name)]
    return words + draw.choice([[], [], ["--json"], ["--strict"]]), {}


def types(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Blocks that are put where others were."""
    name = draw.choice(SCENARIOS)
    table = draw.choice(sorted({path.rpartition(".")[0] for path in known_paths(name)}))
    rooms = block_names()
    room = {"supply": "supplies"}.get(table, f"{table}s")
    names = rooms[room if room in rooms and draw.random() < 0.7 else draw.choice(list(rooms))]
    words = ["run", name, "--interpreted", *SHORT, "--set", f"{table}.type={draw.choice(names)}"]
    if draw.random() < 0.5:
        words += ["--set", setting(draw, name)]
    return words, {}


def steps(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Times, steps and counts, compiled: what a kernel is told."""
    name = draw.choice(["paper/sine-pi", "rig/1khz-tsmc-square"])
    words = ["run", name, "--set", "simulation.duration=0.01 s"]
    keys = ("duration", "period", "substeps", "record_period", "seed", "tolerance", "integrator.tolerance")
    for key in draw.sample(keys, draw.randint(1, 3)):
        words += ["--set", f"simulation.{key}={draw.choice([value, number])(draw)}"]
    return words, {}


def scenario_file(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """A scenario's text, cut, doubled, shuffled and scribbled on."""
    lines = scenario_source(draw.choice(SCENARIOS)).splitlines()
    for _ in range(draw.randint(1, 4)):
        draw.choice(EDITS)(draw, lines)
    content = "\n".join(lines).encode("utf-8", "surrogatepass")
    if draw.random() < 0.1:
        content = scribbled(draw, content)
    return ["run", "own.toml", "--interpreted", *SHORT], {"own.toml": content}


def recording(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """A recorded demand or load with cells, columns, separators and instants that do not fit."""
    mark, point = draw.choice(
        [(",", "."), (",", "."), (";", ","), (";", "."), ("\t", ","), (" ", "."), (",", ",")]
    )
    start, step = draw.choice([0.0, 0.0, -1.0, 5.0, 1.7e9]), draw.choice([1e-3, 1e-3, 1.0, 1e-6, 0.0, -1e-3])
    role, unit = draw.choice([("reference", "mm/s"), ("load", "kN")])
    header = f"t [s]|v [{unit}]" if draw.random() < 0.6 else draw.choice(HEADERS)
    rows = [header.split("|")]
    for i in range(draw.choice([0, 1, 2, 5, 40])):
        cells = (f"{start + i * step:.9g}", f"{draw.uniform(-30, 30):.3f}")
        rows += [[cell.replace(".", point) for cell in cells]]
    for _ in range(draw.randint(0, 2)):
        row = draw.choice(rows)
        row[draw.randrange(len(row))] = draw.choice(CELLS)
    text = draw.choice(["\n", "\r\n"]).join(mark.join(row) for row in rows)
    content = text.encode(draw.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16"]))
    if draw.random() < 0.1:
        content = scribbled(draw, content)
    scenario = RECORDED.format(role=role, keys=draw.choice(SERIES))
    return ["run", "own.toml", "--interpreted"], {"own.toml": scenario.encode(), "log.csv": content}


def plugin(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """A law of one's own that does not do what it must."""
    own = f"Own{draw.randrange(10**9)}"  # classes of one process must not meet
    text = PLUGIN.format(init=draw.choice(INITS), step=draw.choice(STEPS)) + draw.choice((*[""] * 12, *ENDS))
    text = text.replace("Own", own)
    if draw.random() < 0.2:
        lines = text.splitlines()
        draw.choice(EDITS)(draw, lines)
        text = "\n".join(lines)
    name = draw.choice([own, own, own, own, own.lower(), ""])
    words = ["run", "paper/sine-pi", "--interpreted", *SHORT, "--set", f"controller.type={name}"]
    for file in draw.choice(
        [*[["own.py"]] * 6, ["own.py", "own.py"], ["nope.py"], [], ["folder"], ["own.toml"]]
    ):
        words += ["--plugin", file]
    return words, {"own.py": text.encode("utf-8", "surrogatepass"), "own.toml": b"a = 1"}


def ranges(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Batches over ranges that are none."""
    words = [
        "batch",
        "paper/sine-pi",
        "--set",
        "simulation.duration=1 ms",
        "--runs",
        draw.choice(["1", "3", number(draw)]),
    ]
    for _ in range(draw.randint(0, 2)):
        between = draw.choice(["..", "..", "..", "...", "-", ":", " .. "])
        words += ["--vary", f"{path(draw, 'paper/sine-pi')}={value(draw)}{between}{value(draw)}"]
    if draw.random() < 0.5:
        words += ["--vary", draw.choice(GOOD_RANGES)]
    for option, texts in (
        ("--seed", NUMBERS),
        ("--threads", NUMBERS),
        ("--metric", ("rms_error", "rms", *TEXTS)),
        ("--out", outputs(draw)),
    ):
        if draw.random() < 0.2:
            words += [option, draw.choice(texts)]
    return words + draw.choice([[], ["--seeds"], ["--json"]]), {}


def search(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Searches that cannot be made."""
    words = [
        "tune",
        "paper/sine-pi",
        "--set",
        "simulation.duration=1 ms",
        "--candidates",
        draw.choice(["1", "64", number(draw)]),
    ]
    good = draw.random() < 0.6
    words += [
        "--vary",
        draw.choice(GOOD_RANGES) if good else f"{setting(draw, 'paper/sine-pi')}..{value(draw)}",
    ]
    options = ("--weights", "--scales", "--seeds", "--seed", "--effort", "--metric", "--threads", "--out")
    for option in draw.sample(options, draw.randint(0, 2)):
        words += [option, draw.choice((*NUMBERS, *TEXTS, "1,2", "-1,0,1", *outputs(draw)))]
    return words, {}


def usage(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Words in any order: commands and options that there are, and some that there are not."""
    commands = (
        "run",
        "compare",
        "batch",
        "tune",
        "export",
        "c",
        "fmu",
        "scenarios",
        "show",
        "rnu",
        "help",
        "",
    )
    options = (
        *(
            "--out",
            "--set",
            "--plugin",
            "--json",
            "--strict",
            "--format",
            "--runs",
            "--vary",
            "--seed",
            "--threads",
            "--unit",
        ),
        *(
            "--version",
            "--help",
            "--nope",
            "--outt",
            "-h",
            "-x",
            "--",
            "---",
            "--set=plant.mass=3",
            "--fmi",
            "--prefix",
            "--inline",
        ),
    )
    pool = (*commands, *options, *NUMBERS, *TEXTS, *FILES, *PATHS)
    words = [draw.choice(pool) for _ in range(draw.randint(0, 6))]
    if draw.random() < 0.5:
        words = [draw.choice(commands[:4]), draw.choice(("paper/sine-pi", *FILES)), *words]
    if "paper" in words:  # a minute each
        words.remove("paper")
    return [*words, *SHORT] if words[:1] in (["run"], ["compare"]) else words, {}


def export(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Exports to places and under names that cannot be."""
    words = ["export", draw.choice(["c", "c", "fmu"]), "paper/sine-pi", "--set", "simulation.duration=1 ms"]
    words += ["--out", draw.choice(outputs(draw))]
    options = {
        "--unit": ("controller", "machine", "loop", "valve", ""),
        "--real": ("single", "double", "half"),
        "--prefix": TEXTS,
    }
    for option in draw.sample(sorted(options), draw.randint(0, 2)):
        words += [option, draw.choice(options[option])]
    if draw.random() < 0.5:
        words += ["--set", f"{path(draw, 'paper/sine-pi')}={value(draw)}"]
    return words, {}


def written(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Results to places that cannot be written."""
    words = ["run", "paper/sine-pi", *SHORT, "--interpreted", "--out", draw.choice(outputs(draw))]
    return words + draw.choice([[], ["--format", "mat"], ["--format", "parquet"], ["--format", "xls"]]), {}


def outputs(draw: random.Random) -> Words:
    stem = draw.choice(("out", *FILES))
    return [stem, stem + draw.choice(ENDINGS)]


def setting(draw: random.Random, scenario: str) -> str:
    """What ``--set`` may be given: half of the time a number near the one that is there."""
    name = path(draw, scenario)
    present = known_paths(scenario).get(name)
    if not isinstance(present, float) or draw.random() < 0.5:
        return f"{name}={value(draw)}"
    return f"{name}={present * draw.choice([0.0, -1.0, 0.5, 1.0, 1.5, 10.0, 1e3, 1e-3, 1e9])!r}"


def path(draw: random.Random, scenario: str) -> str:
    """A path of a number in a scenario, or nearly one."""
    if draw.random() < 0.15:
        return draw.choice(PATHS)
    text = draw.choice(list(known_paths(scenario)))
    if draw.random() < 0.1:
        i = draw.randrange(len(text))
        text = text[:i] + draw.choice("abc._ 1=[") + text[i + 1 :]
    return text


@cache
def known_paths(scenario: str) -> dict[str, Any]:
    """The numbers of a scenario by their paths."""
    found = dict(leaves(load_scenario(scenario)))
    return {name: number for name, number in found.items() if not name.startswith("nominal.")}


@cache
def block_names() -> dict[str, Words]:
    """The names of all blocks, by their package."""
    rooms = ("controllers", "integrators", "loads", "mechanics", "observers", "oils", "plants", "references")
    found = {}
    for room in (*rooms, "sensors", "supplies", "valves"):
        found[room] = sorted(import_module(f"hydroservo.{room}").__all__)
    return found


def number(draw: random.Random) -> str:
    if draw.random() < 0.5:
        return draw.choice(NUMBERS)
    return f"{draw.choice([-1, 1, 1, 1]) * 10.0 ** draw.uniform(-12, 12):.{draw.randint(0, 17)}g}"


def value(draw: random.Random) -> str:
    """A quantity, or what is none."""
    if draw.random() < 0.15:
        return draw.choice(TEXTS)
    return number(draw) + draw.choice(["", " "]) + draw.choice(("", "", *UNITS))


def scribbled(draw: random.Random, content: bytes) -> bytes:
    """Bytes with one of them exchanged."""
    if not content:
        return b"\xff"
    i = draw.randrange(len(content))
    return content[:i] + bytes([draw.randrange(256)]) + content[i + 1 :]


def drop(draw: random.Random, lines: Words) -> None:
    if lines:
        del lines[draw.randrange(len(lines))]


def double(draw: random.Random, lines: Words) -> None:
    if lines:
        lines.insert(draw.randrange(len(lines)), draw.choice(lines))


def cut(draw: random.Random, lines: Words) -> None:
    del lines[draw.randint(0, len(lines)) :]


def rewrite(draw: random.Random, lines: Words) -> None:
    """Another value behind one of the equals signs."""
    places = [i for i, line in enumerate(lines) if "=" in line]
    if places:
        i = draw.choice(places)
        quote = draw.choice(['"', '"', "", "'"])
        lines[i] = f"{lines[i].partition('=')[0]}= {quote}{value(draw)}{quote}"


def scribble(draw: random.Random, lines: Words) -> None:
    """One character exchanged."""
    places = [i for i, line in enumerate(lines) if line]
    if places:
        i = draw.choice(places)
        place = draw.randrange(len(lines[i]))
        lines[i] = lines[i][:place] + draw.choice("=[]{}\"'.#,\\\x01é 0z") + lines[i][place + 1 :]


def deepen(draw: random.Random, lines: Words) -> None:
    lines.append(
        draw.choice(
            [f"[{'a.' * 50}b]", f"x = {'[' * 400}{']' * 400}", "[plant.mass]", "[[plant]]", "plant = 3"]
        )
    )


EDITS: tuple[Callable[[random.Random, Words], None], ...] = (
    drop,
    double,
    cut,
    rewrite,
    rewrite,
    scribble,
    deepen,
)

KINDS: dict[str, Callable[[random.Random], tuple[Words, dict[str, bytes]]]] = {
    each.__name__: each
    for each in (
        settings,
        types,
        steps,
        scenario_file,
        recording,
        plugin,
        ranges,
        search,
        usage,
        export,
        written,
    )
}


def lay(folder: Path, one: Case) -> None:
    """Write the files of a case."""
    for name, content in one.files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    (folder / "folder").mkdir(exist_ok=True)
