"""The files of a finding: a page that opens offline, its pictures, its tables and its numbers."""

import base64
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError
from hydroservo.core.outputs import digests, file_names_in, staged, write_text
from hydroservo.show.finding import Finding, Picture
from hydroservo.show.journal import NO_JOURNAL, Journal, with_decimal_commas
from hydroservo.show.table import Table, csv_of, latex_of, note_of, texts_of

if TYPE_CHECKING:
    import jinja2

    from hydroservo.figures.style import Plot

REPORT = "report.html"
TABLES = "tables"
FIGURES = "figures"
WIDEST = 6.3  # inch, a picture as wide as the text


class PagePicture(NamedTuple):
    """A picture on the page."""

    picture: Picture  # what is shown
    source: str  # its content, as an address that needs no file
    share: float  # of the text's width, so that letters are as large in all pictures


def write_finding(folder: Path, finding: Finding, command: str, journal: Journal = NO_JOURNAL) -> list[Path]:
    """Write what a result says into a folder, all or nothing; equal findings give equal bytes.

    That is the page ``report.html``, which holds its pictures; each picture as PNG and SVG, and for a journal
    in ``figures``; each table as CSV and LaTeX in ``tables``; the finding's own files; and ``metrics.json``,
    the numbers with the SHA-256 of every other file.

    Returns:
        What was written.
    """
    with staged(folder, last=METRICS) as stage:
        for name, write in finding.files.items():
            write(stage / name)
        pictures = [write_picture(stage, one, origin_in(finding), journal) for one in finding.pictures]
        write_tables(stage, finding.filled)
        template = template_environment("hydroservo.show").get_template("report.html.j2")
        content = {
            "finding": finding,
            "pictures": pictures,
            "tables": [(table, texts_of(table), note_of(table, "Bold:")) for table in finding.filled],
            "command": command,
            "version": __version__,
        }
        write_text(stage / REPORT, template.render(content))
        if journal.decimal_comma:
            with_decimal_commas(stage)
        write_metrics(stage, finding.numbers)
        names = file_names_in(stage)
    return [folder / name for name in names]


def origin_in(finding: Finding) -> str:
    """What the metadata of pictures say: the hashes of the scenarios, or else the title."""
    return " ".join(one.hash for one in finding.origins) or finding.title


def write_picture(stage: Path, picture: Picture, origin: str, journal: Journal) -> PagePicture:
    """Write a picture as PNG and SVG, and as a journal wants it; returns it as the page has it."""
    figure = picture.draw()
    write_figure(figure, stage / picture.name, origin)
    share = min(float(figure.get_figwidth()) / WIDEST, 1.0)
    journal.save(figure, stage / FIGURES / picture.name, origin)
    return PagePicture(picture, data_address(stage / f"{picture.name}.svg"), share)


def write_figure(figure: "Plot", stem: Path, origin: str) -> list[Path]:
    """Write ``stem.png`` and ``stem.svg``, and return their paths."""
    return [figure.save(stem.with_name(stem.name + ending), origin=origin) for ending in (".png", ".svg")]


def data_address(path: Path) -> str:
    """An SVG as an address that holds the picture itself."""
    return "data:image/svg+xml;base64," + base64.b64encode(path.read_bytes()).decode()


def write_tables(stage: Path, tables: Sequence[Table]) -> None:
    """Write each table as CSV and LaTeX into the folder ``tables`` of another."""
    for table in tables:
        write_text(stage / TABLES / f"{table.name}.csv", csv_of(table))
        write_text(stage / TABLES / f"{table.name}.tex", latex_of(table))


def template_environment(package: str) -> "jinja2.Environment":
    """The templates in a package's folder ``templates``, which may extend ``frame.html.j2``.

    The frame has the page's look, in the light, in the dark and in print, and refers to no other file. What
    is put into a template is escaped, and a name that is not there is an error.
    """
    import jinja2

    places = dict.fromkeys([package, "hydroservo.show"])
    return jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(place) for place in places]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


METRICS = "metrics.json"
"""The file of a folder of results that names all others."""


def as_json(value: Any) -> str:
    """Text of a JSON object; null for a number that is not finite."""
    return json.dumps(json_value(value), indent=2, allow_nan=False)


def write_metrics(folder: Path, content: Mapping[str, Any]) -> Path:
    """Write ``metrics.json`` beside the other files of a result, with the SHA-256 of each of them."""
    return write_text(folder / METRICS, as_json({**content, "files": digests(folder)}) + "\n")


def foreign_files(folder: Path | str) -> list[str]:
    """Which files that a folder's ``metrics.json`` names are missing, or are not those of its run.

    There are some where files were changed, where two commands wrote at the same time, or where one was
    killed in the instant in which its files took their places. Files that ``metrics.json`` does not name are
    left out.

    Raises:
        HydroservoError: there is no such file, or it cannot be read.
    """
    folder = Path(folder)
    try:
        named = dict(json.loads((folder / METRICS).read_text(encoding="utf-8"))["files"])
        found = digests(folder, [name for name in named if (folder / name).is_file()])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise HydroservoError(f"{folder / METRICS}: cannot be read as that of a result: {error}") from None
    return [name for name, digest in named.items() if found.get(name) != digest]


def json_value(value: Any) -> Any:
    """The value as JSON can hold it: None for every number in it that is not finite."""
    if isinstance(value, Mapping):
        return {key: json_value(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
