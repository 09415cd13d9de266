"""The tables that the documentation and the terminal show, made from the file of results."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.peer import TOLERANCE
from benchmarks.peers import ALL, DEVICE_YARDSTICK, YARDSTICK
from benchmarks.results import Results
from hydroservo.engine.lanes import LANES

__all__ = [
    "ROOT",
    "Line",
    "Section",
    "details",
    "device_table",
    "filled",
    "job_table",
    "machines_table",
    "notes",
    "put",
    "summary",
    "write",
]

ROOT = Path(__file__).parents[1]
MARKERS = ("<!-- benchmarks: begin -->", "<!-- benchmarks: end -->")
BASELINE = "C scalar"
DEVICE = "device"  # its section of the results
DEVICE_BASELINE = "CUDA C"
PART = "*"

Section = dict[str, Any]  # the results with one instruction set
Line = Sequence[str]


def write(results: Results) -> None:
    """Puts the tables where they are shown."""
    put("docs/benchmarks.md", details(results))


def put(name: str, text: str) -> None:
    """Shows a text between the markers of a page, by its path in the repository."""
    page = ROOT / name
    page.write_text(filled(page.read_text(encoding="utf-8"), text), encoding="utf-8")


def filled(page: str, text: str) -> str:
    """A page with other text between its two markers.

    Raises:
        ValueError: the page does not have both.
    """
    begin, end = MARKERS
    before, found, rest = page.partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"the page has no {begin} ... {end}")
    return f"{before}{begin}\n{text.strip()}\n{end}{after}"


def details(results: Results) -> str:
    """What the documentation shows."""
    processors = [section for name, section in results.items() if name != DEVICE]
    found = [chapter for section in processors for chapter in chapters(section)]
    on_device = device_chapters(results[DEVICE]) if DEVICE in results else ()
    return "\n\n".join([*found, *on_device])


def chapters(section: Section) -> Iterator[str]:
    machine = section["machine"]
    yield f"## With {machine['instructions']}, on {machine['processor']}"
    yield markdown(*summary(section))
    yield from notes(section)
    for job in section["jobs"]:
        yield f"### {job['name']}: {job['title']}"
        yield markdown(*job_table(job))
    if "profile" in section:
        yield "### Where the time goes"
        yield markdown(*profile_table(section["profile"]))
        yield limit(section["profile"])
    if "start_up" in section:
        yield "### The first result"
        yield markdown(*start_up_table(section["start_up"]))
    if "machines" in section:
        yield "### Each machine"
        yield markdown(*machines_table(section["machines"]))
        yield on(section["machines"])
    yield "### The machine"
    yield markdown(("", ""), machine.items())


def device_chapters(section: Section) -> Iterator[str]:
    (job,) = section["jobs"]
    yield "## On a CUDA device"
    yield f"{job['name']}: {job['title']}, on one {section['machine']['device']}."
    yield markdown(*device_table(section))
    yield markdown(("", ""), section["machine"].items())


def device_table(section: Section) -> tuple[Line, list[Line]]:
    """All that was measured on a device."""
    return job_table(section["jobs"][0], DEVICE_YARDSTICK.name, DEVICE_BASELINE)


def summary(section: Section) -> tuple[Line, list[Line]]:
    """One row a contender, one column a job: the time, and how many times hydroservo's it is."""
    jobs = section["jobs"]
    header = ("", *(f"{job['name']}: {job['title']}" for job in jobs))
    rows = [(peer.name, *(cell(job, peer.name) for job in jobs)) for peer in ALL]
    return header, [row for row in rows if any(row[1:])]


def cell(job: Section, name: str) -> str:
    entry = found(job, name)
    if entry is None:
        return ""
    part = PART if entry["share"] < 1.0 else ""
    return f"{seconds(entry['seconds'])}{part} ({ratio(job, entry, YARDSTICK.name)})"


def notes(section: Section) -> Iterator[str]:
    """What the table leaves unsaid."""
    shortened = any(entry["share"] < 1.0 for job in section["jobs"] for entry in job["entries"])
    scaled = f" {PART} A part of the job was run, and its time scaled by the number of steps."
    yield f"Median time, and in brackets how many times hydroservo's it is.{scaled if shortened else ''}"
    missing = {one["name"]: one["reason"] for job in section["jobs"] for one in job["missing"]}
    if missing:
        yield "Left out: " + "; ".join(f"{name} ({reason})" for name, reason in missing.items()) + "."


def on(section: Section) -> str:
    """The machine in one line."""
    machine = section["machine"]
    return (
        f"On {machine['processor']}, {machine['cores']} cores, {machine['instructions']}; "
        f"Python {machine['Python']}, numba {machine['numba']}, gcc {machine['gcc']}; {machine['date']}."
    )


def job_table(
    job: Section, yardstick: str = YARDSTICK.name, baseline: str = BASELINE
) -> tuple[Line, list[Line]]:
    """All that was measured of one job."""
    header = (
        "",
        "how",
        "median",
        "spread",
        f"times {yardstick}",
        f"times {baseline}",
        "first result",
        "memory",
        "differs by",
        "part run",
    )
    return header, [row(job, entry, yardstick, baseline) for entry in job["entries"]]


def row(job: Section, entry: Section, yardstick: str, baseline: str) -> Line:
    spread = (max(entry["rounds"]) - min(entry["rounds"])) / (2.0 * entry["seconds"] * entry["share"])
    return (
        entry["name"],
        entry["how"],
        seconds(entry["seconds"]),
        f"±{100.0 * spread:.0f} %" if len(entry["rounds"]) > 2 else "",
        ratio(job, entry, yardstick),
        ratio(job, entry, baseline),
        seconds(entry["first"]),
        "" if entry["memory"] is None else f"{entry['memory'] / 2**20:.0f} MiB",
        agreement(entry["difference"]),
        "all" if entry["share"] == 1.0 else f"{entry['runs']:,} x {entry['steps']:,} steps",
    )


def agreement(difference: float) -> str:
    """How far a result is from the answer, and whether that is too far."""
    text = f"{difference:.0e}" if difference else "nothing"
    return text if difference <= TOLERANCE else f"**{text}: not the same result**"


def ratio(job: Section, entry: Section, name: str) -> str:
    """How many times another contender's time it is; "-" where that is missing or the results disagree."""
    other = found(job, name)
    if other is None or not entry["difference"] <= TOLERANCE:
        return "-"
    return digits(entry["seconds"] / other["seconds"])


def profile_table(measured: Section) -> tuple[Line, list[Line]]:
    """What a sample period takes without each part."""
    header = ("left out", "one run", "runs side by side, each")
    parts = measured["parts"].items()
    return header, [(name, f"{one['single']:.0f} ns", f"{one['lanes']:.1f} ns") for name, one in parts]


def limit(measured: Section) -> str:
    """How far runs side by side are from what the processor can do."""
    costs, operations, whole = (
        measured["limits"],
        measured["operations"],
        measured["parts"]["nothing"]["lanes"],
    )
    least = sum(operations.get(kind, 0) * cost for kind, cost in costs.items()) / LANES
    return (
        f"The longest loop over {LANES} runs in a sample period takes {operations['multiply_add']:,} "
        f"multiplications (most with an addition), {operations['divide']} divisions and {operations['root']} "
        f"roots of whole vectors. Independent ones take {costs['multiply_add']:.2f}, {costs['divide']:.2f} "
        f"and {costs['root']:.2f} ns on this processor; so these alone would take {least:.1f} ns for each "
        f"run, and all of a sample period takes {whole:.1f} ns."
    )


def machines_table(measured: Section) -> tuple[Line, list[Line]]:
    """What a simulated second of each machine takes alone, and how many of them a second gives in a batch."""
    rows = measured["rows"]
    ways = list(rows[0]["seconds"])
    columns = [(f"{way}: alone, for 1 s", f"{way}: side by side, in 1 s") for way in ways]
    header = ("", "states", *(name for pair in columns for name in pair))
    return header, [
        (row["name"], str(row["states"]), *(text for way in ways for text in costs(row["seconds"][way])))
        for row in rows
    ]


def costs(measured: Section) -> tuple[str, str]:
    """Time per simulated second of one run, and simulated seconds per second of many."""
    return seconds(measured["single"]), f"{digits(1.0 / measured['batch'])} s"


def start_up_table(measured: Section) -> tuple[Line, list[Line]]:
    lines = {"cold": "with an empty cache", "warm": "with a filled cache"}
    header = ("`hydroservo run paper/sine-tsmc --json` in a fresh process", "median")
    return header, [(text, seconds(measured[name])) for name, text in lines.items()]


def found(job: Section, name: str) -> Section | None:
    """What a contender did of a job."""
    return next((entry for entry in job["entries"] if entry["name"] == name), None)


def seconds(value: float) -> str:
    """A time in three digits and a unit that fits."""
    unit, factor = next(
        (unit, factor) for unit, factor, least in UNITS if value >= least or unit == UNITS[-1][0]
    )
    return f"{digits(factor * value)} {unit}"


def digits(value: float) -> str:
    """Three digits, and no power of ten."""
    return f"{float(f'{value:.3g}'):,.0f}" if value >= 99.95 else f"{value:#.3g}"


UNITS = (("s", 1.0, 1.0), ("ms", 1e3, 1e-3), ("µs", 1e6, 0.0))


def markdown(header: Line, rows: Iterable[Line], left: int = 1) -> str:
    """A table as Markdown; so many columns to the left, numbers to the right."""
    cells = [header, ["---"] * left + ["---:"] * (len(header) - left), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in cells)
