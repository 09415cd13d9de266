"""Command lines that a hurried, a careless or a hostile user may type: a number determines each."""

import random
import tomllib
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import hydroservo
from hydroservo.core.block import is_block, leaves
from hydroservo.machine.plants import ThisMachine
from hydroservo.scenario import load_scenario, scenario_source, scenarios
from hydroservo.testing.examples import EXAMPLES

Words = list[str]

SCENARIOS = tuple(scenarios())
COSTLY = {"export": 0.1, "steps": 0.15, "written": 0.05}  # the share of what takes long, where others have 1
TINY = ("paper/sine-pi", "--set", "simulation.duration=1 ms")
SHORT = ("--set", "simulation.duration=0.02 s", "--set", "simulation.record_period=1 ms")
WORDS = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
WORDS["texts"] += ["a" * 5000]
WORDS["files"] += ["a" * 300]


class Case(NamedTuple):
    """A command and the files that it finds in its folder."""

    kind: str
    words: Words
    files: dict[str, bytes]


def case(number: int) -> Case:
    """The case of a number, the same everywhere."""
    draw = random.Random(f"hydroservo {number}")
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
    chosen = room if room in rooms and draw.random() < 0.7 else draw.choice(list(rooms))
    kind = draw.choice(rooms[chosen])
    words = ["run", name, "--interpreted", *SHORT, "--set", f"{table}.type={kind}"]
    if draw.random() < 0.7:  # with all that it takes
        example = EXAMPLES.get(getattr(getattr(hydroservo, chosen), kind))
        words += [word for text in given(example, table) for word in ("--set", text)] if example else []
    if draw.random() < 0.5:
        words += ["--set", setting(draw, name)]
    return words, {}


def given(block: Any, table: str) -> Iterator[str]:
    """What ``--set`` takes for a block with all its numbers."""
    for name, value in block._asdict().items():
        if isinstance(value, float | int):
            yield f"{table}.{name}={value!r}"
        elif is_block(value) and not isinstance(value, ThisMachine):
            yield f"{table}.{name}.type={type(value).__name__}"
            yield from given(value, f"{table}.{name}")


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
    header = f"t [s]|v [{unit}]" if draw.random() < 0.6 else draw.choice(WORDS["headers"])
    rows = [header.split("|")]
    for i in range(draw.choice([0, 1, 2, 5, 40])):
        cells = (f"{start + i * step:.9g}", f"{draw.uniform(-30, 30):.3f}")
        rows += [[cell.replace(".", point) for cell in cells]]
    for _ in range(draw.randint(0, 2)):
        row = draw.choice(rows)
        row[draw.randrange(len(row))] = draw.choice(WORDS["cells"])
    text = draw.choice(["\n", "\r\n"]).join(mark.join(row) for row in rows)
    content = text.encode(draw.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16"]))
    if draw.random() < 0.1:
        content = scribbled(draw, content)
    scenario = WORDS["recorded"].format(role=role, keys=draw.choice(WORDS["series"]))
    return ["run", "own.toml", "--interpreted"], {"own.toml": scenario.encode(), "log.csv": content}


def plugin(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """A law of one's own that does not do what it must."""
    own = f"Own{draw.randrange(10**9)}"  # classes of one process must not meet
    text = WORDS["plugin"].format(init=draw.choice(WORDS["inits"]), step=draw.choice(WORDS["steps"]))
    text += draw.choice((*[""] * 12, *WORDS["ends"]))
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
    words = ["batch", *TINY, "--runs", draw.choice(["1", "3", number(draw)])]
    for _ in range(draw.randint(0, 2)):
        between = draw.choice(["..", "..", "..", "...", "-", ":", " .. "])
        words += ["--vary", f"{path(draw, 'paper/sine-pi')}={value(draw)}{between}{value(draw)}"]
    if draw.random() < 0.5:
        words += ["--vary", draw.choice(WORDS["good_ranges"])]
    for option, texts in (
        ("--seed", WORDS["numbers"]),
        ("--threads", WORDS["numbers"]),
        ("--metric", ("rms_error", "rms", *WORDS["texts"])),
        ("--out", outputs(draw)),
    ):
        if draw.random() < 0.2:
            words += [option, draw.choice(texts)]
    return words + draw.choice([[], ["--seeds"], ["--json"]]), {}


def search(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Searches that cannot be made."""
    words = ["tune", *TINY, "--candidates", draw.choice(["1", "64", number(draw)]), "--vary"]
    good = draw.random() < 0.6
    words += [
        draw.choice(WORDS["good_ranges"]) if good else f"{setting(draw, 'paper/sine-pi')}..{value(draw)}"
    ]
    options = ("--weights", "--scales", "--seeds", "--seed", "--effort", "--metric", "--threads", "--out")
    for option in draw.sample(options, draw.randint(0, 2)):
        words += [option, draw.choice((*WORDS["numbers"], *WORDS["texts"], "1,2", "-1,0,1", *outputs(draw)))]
    return words, {}


def usage(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Words in any order: commands and options that there are, and some that there are not."""
    names = ("commands", "options", "numbers", "texts", "files", "paths")
    pool = [word for name in names for word in WORDS[name]]
    words = [draw.choice(pool) for _ in range(draw.randint(0, 6))]
    if draw.random() < 0.5:
        words = [draw.choice(WORDS["commands"][:4]), draw.choice(("paper/sine-pi", *WORDS["files"])), *words]
    if "paper" in words:  # a minute each
        words.remove("paper")
    return [*words, *SHORT] if words[:1] in (["run"], ["compare"]) else words, {}


def export(draw: random.Random) -> tuple[Words, dict[str, bytes]]:
    """Exports to places and under names that cannot be."""
    words = ["export", draw.choice(["c", "c", "fmu"]), *TINY]
    words += ["--out", draw.choice(outputs(draw))]
    options = {
        "--unit": ("controller", "machine", "loop", "valve", ""),
        "--real": ("single", "double", "half"),
        "--prefix": WORDS["texts"],
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
    stem = draw.choice(("out", *WORDS["files"]))
    return [stem, stem + draw.choice(WORDS["endings"])]


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
        return draw.choice(WORDS["paths"])
    text = draw.choice(list(known_paths(scenario)))
    if draw.random() < 0.1:
        i = draw.randrange(len(text))
        text = text[:i] + draw.choice("abc._ 1=[") + text[i + 1 :]
    return text


@cache
def known_paths(scenario: str) -> dict[str, Any]:
    """The numbers of a scenario by their paths."""
    return dict(leaves(load_scenario(scenario)))


@cache
def block_names() -> dict[str, Words]:
    """The names of all blocks, by their package."""
    rooms = ("controllers", "integrators", "loads", "mechanics", "observers", "oils", "plants", "references")
    found = {}
    for room in (*rooms, "sensors", "supplies", "valves"):
        found[room] = sorted(getattr(hydroservo, room).__all__)
    return found


def number(draw: random.Random) -> str:
    if draw.random() < 0.5:
        return draw.choice(WORDS["numbers"])
    return f"{draw.choice([-1, 1, 1, 1]) * 10.0 ** draw.uniform(-12, 12):.{draw.randint(0, 17)}g}"


def value(draw: random.Random) -> str:
    """A quantity, or what is none."""
    if draw.random() < 0.15:
        return draw.choice(WORDS["texts"])
    return number(draw) + draw.choice(["", " "]) + draw.choice(("", "", *WORDS["units"]))


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
    tables = [f"[{'a.' * 50}b]", "[plant.mass]", "[[plant]]", "plant = 3"]
    lines.append(draw.choice([*tables, f"x = {'[' * 400}{']' * 400}"]))


Edit = Callable[[random.Random, Words], None]
Kind = Callable[[random.Random], tuple[Words, dict[str, bytes]]]

EDITS: list[Edit] = [drop, double, cut, rewrite, rewrite, scribble, deepen]
OF_RUNS: list[Kind] = [settings, types, steps, scenario_file, recording, plugin, written]
OF_OTHERS: list[Kind] = [ranges, search, usage, export]
KINDS = {kind.__name__: kind for kind in OF_RUNS + OF_OTHERS}


def lay(folder: Path, one: Case) -> None:
    """Write the files of a case."""
    for name, content in one.files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    (folder / "folder").mkdir(exist_ok=True)
