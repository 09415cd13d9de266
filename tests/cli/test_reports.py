"""The reports that commands leave: the page, its tables, and figures for a journal."""

import html
import json
import re
import shlex
import subprocess

import pandas as pd
import pytest

from hydroservo import load_scenario, simulate
from hydroservo.figures.run import plot_comparison
from hydroservo.figures.style import fit_width, style
from hydroservo.show.files import foreign_files
from hydroservo.show.table import latex_label
from tests.support.commands.runner import QUICK, SHORT, failed, succeeded
from tests.support.needs import needs
from tests.support.reports import check_report, page, text_of

pytestmark = pytest.mark.slow  # it runs and draws

RUN = ("run", "paper/sine-pi", *QUICK)
COMPARE = ("compare", "paper/sine-pi", "paper/sine-backstepping", *SHORT)
LINEARIZE = ("linearize", "axis/force")
BODE = ("bode", "rig/1khz-pi-sine", "--linear")
BATCH = ("batch", "paper/sine-pi", *SHORT, "--runs", "20", "--vary", "plant.mass=4..8kg")
TUNE = (
    *("tune", "paper/sine-pi", *SHORT, "--candidates", "64"),
    *("--vary", "controller.proportional_gain=1..10"),
)
POINT = 1.0 / 72.0  # inch


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("words", [RUN, COMPARE, BODE, TUNE])
def test_a_folder_has_a_page_that_needs_no_other_and_all_that_json_says(tmp_path, words):
    check_report(tmp_path, json.loads(succeeded(*words, "--json", "--out", tmp_path)))


@pytest.mark.parametrize(
    "words", [(*RUN, "--set", "load.amplitude=150N"), LINEARIZE, BATCH, (*TUNE, "--unbounded")]
)
def test_the_command_of_a_page_makes_the_same_folder_again(tmp_path, words):
    succeeded(*words, "--out", f"{tmp_path}/first/")
    (command,) = re.findall(r"<pre><code>(hydroservo .*?)</code>", page(tmp_path / "first"), re.DOTALL)
    program, *words = shlex.split(html.unescape(command))
    assert program == "hydroservo"
    again = [word.replace("DIR", f"{tmp_path}/again") for word in words if word.strip()]
    succeeded(*again)
    assert contents(tmp_path / "again") == contents(tmp_path / "first")


def test_the_page_has_what_the_terminal_shows(tmp_path):
    said = succeeded("compare", "paper/sine-pi", "paper/sine-backstepping", *SHORT, "--out", tmp_path)
    shown = [
        [cell.strip() for cell in line.split("│")[1:-1]] for line in said.splitlines() if line[:1] == "│"
    ]
    rows = re.findall(r"<tr>(<td.*)</tr>", page(tmp_path))
    cells = [[html.unescape(cell) for cell in re.findall(r"<td[^>]*>([^<]*)</td>", row)] for row in rows]
    assert [[cell.removesuffix(" *") for cell in row] for row in shown] == cells[: len(shown)]
    best = sum(cell.endswith(" *") for row in shown for cell in row)
    assert best > 0
    assert page(tmp_path).count('<td class="n best">') == best
    assert (tmp_path / "tables" / "metrics.tex").read_text().count(r"\textbf{") == best


def test_a_table_for_a_spreadsheet_has_the_numbers_of_json(tmp_path):
    said = json.loads(
        succeeded("compare", "paper/sine-pi", "paper/sine-tsmc", *SHORT, "--json", "--out", tmp_path)
    )
    table = pd.read_csv(tmp_path / "tables" / "metrics.csv", index_col="metric")
    for name, run in zip(("paper/sine-pi", "paper/sine-tsmc"), said["runs"], strict=True):
        assert float(table[name]["rms_error"]) == run["metrics"]["rms_error"]
    assert table["unit"]["rms_error"] == "m/s"


def test_a_page_says_what_is_wrong(tmp_path):
    words = ("paper/sine-pi", "rig/1khz-pi-sine")
    succeeded("compare", *words, *SHORT, "--out", tmp_path)
    assert "for they differ in more than the controller" in text_of(tmp_path)


def test_names_in_a_page_are_text_and_no_tags(tmp_path):
    file = tmp_path / "a&b<i>[bold].toml"
    file.write_text('base = "paper/sine-pi"\n')
    succeeded("run", file, *QUICK, "--out", tmp_path / "out")
    assert f"Run of {file}" in text_of(tmp_path / "out")
    assert "<i>" not in page(tmp_path / "out")


@pytest.mark.parametrize(("size", "inch"), [("one-column", 3.5), ("two-column", 7.16)])
def test_figures_are_as_wide_as_a_journal_wants_them(tmp_path, size, inch):
    succeeded(*RUN, "--out", tmp_path, "--figure-size", size)
    (width,) = re.findall(r'<svg [^>]*width="([0-9.]+)pt"', (tmp_path / "figures" / "run.svg").read_text())
    assert float(width) * POINT == pytest.approx(inch, abs=1e-4)
    (box,) = re.findall(rb"/MediaBox \[ 0 0 ([0-9.]+) ", (tmp_path / "figures" / "run.pdf").read_bytes())
    assert float(box) * POINT == pytest.approx(inch, abs=1e-4)


def test_no_legend_sticks_out_of_a_narrow_figure():
    runs = [simulate(load_scenario(name, {"simulation.duration": 0.02})) for name in ("paper/sine-pi",) * 3]
    drawn = plot_comparison(runs, [f"a name of some length {i}" for i in range(3)])
    with style():
        fit_width(drawn, 3.5)
        drawn.draw_without_rendering()
    box = drawn.axes[0].get_legend().get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= drawn.bbox.x1
    assert drawn.axes[0].get_window_extent().width > 0.7 * drawn.bbox.width


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--figure-format", "pdf,tiff"), "must be of svg, pdf, pgf, png, with commas between them"),
        (("--figure-format", ","), "must be of svg, pdf, pgf, png, with commas between them"),
        (("--figure-format", "pgf"), "needs one of xelatex, lualatex, pdflatex for pgf, to measure text;"),
    ],
)
def test_formats_that_cannot_be_are_refused_before_the_run(tmp_path, monkeypatch, options, problem):
    monkeypatch.setattr("shutil.which", lambda _name: None)
    said = failed(*RUN, "--out", tmp_path, *options)
    assert problem in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_figures_without_a_folder_are_refused():
    assert "is of figures in a folder; add --out DIR" in failed(*RUN, "--figure-size", "one-column")


@pytest.mark.parametrize("words", [RUN, COMPARE, LINEARIZE, BODE, BATCH, TUNE])
def test_tables_with_decimal_commas_have_the_same_numbers(tmp_path, words):
    for folder, options in (("points", ()), ("commas", ("--decimal-comma",))):
        succeeded(*words, "--out", f"{tmp_path}/{folder}/", *options)
    tables = sorted((tmp_path / "points").rglob("*.csv"))
    assert any(re.search(r"\d,\d", one.read_text("utf-8")) for one in (tmp_path / "commas").rglob("*.csv"))
    for table in tables:
        other = tmp_path / "commas" / table.relative_to(tmp_path / "points")
        points, commas = (
            pd.read_csv(file, sep=sep, dtype=str, keep_default_na=False).map(
                lambda cell: cell.replace(",", ".")
            )
            for file, sep in ((table, ","), (other, ";"))
        )
        pd.testing.assert_frame_equal(commas, points)
    assert foreign_files(tmp_path / "commas") == []
    again = text_of(tmp_path / "commas").replace(" \\\n    --decimal-comma", "")
    assert again == text_of(tmp_path / "points")


def test_a_trajectory_with_decimal_commas_is_read_back(tmp_path):
    succeeded(*RUN, "--out", tmp_path / "points")
    succeeded(*RUN, "--out", tmp_path / "commas", "--decimal-comma")
    hashes = []
    for folder in ("points", "commas"):
        series = f'{{ file = "{folder}/trajectory.csv", time = "time", column = "reference.value" }}'
        scenario = tmp_path / f"{folder}.toml"
        scenario.write_text(
            f'base = "paper/sine-pi"\nreference = {{ type = "Recorded", series = {series} }}\n'
        )
        hashes.append(json.loads(succeeded("run", scenario, *QUICK, "--json"))["hash"])
    assert hashes[0] == hashes[1]


def test_the_table_of_a_batch_has_decimal_commas(tmp_path):
    succeeded(*BATCH, "--out", tmp_path / "points.csv")
    succeeded(*BATCH, "--out", tmp_path / "commas.csv", "--decimal-comma")
    commas = pd.read_csv(tmp_path / "commas.csv", sep=";", decimal=",")
    pd.testing.assert_frame_equal(commas, pd.read_csv(tmp_path / "points.csv"))


@pytest.mark.parametrize("words", [RUN, BATCH, (*BATCH, "--out", "runs.parquet")])
def test_decimal_commas_of_no_table_are_refused(words):
    assert "--decimal-comma changes CSV files, and this command writes none" in failed(
        *words, "--decimal-comma"
    )


def test_three_panels_side_by_side_are_as_wide_as_two_columns(tmp_path):
    succeeded(*BODE, "--out", f"{tmp_path}/", "--figure-size", "one-column", "--figure-format", "svg")
    (width,) = re.findall(r'<svg [^>]*width="([0-9.]+)pt"', (tmp_path / "figures" / "bode.svg").read_text())
    assert float(width) * POINT == pytest.approx(7.16, abs=1e-4)


PAPER = r"""
\documentclass[twocolumn]{article}
\usepackage{booktabs}
\usepackage{pgf}
\begin{document}
\input{figures/margins.pgf}
\input{tables/assumptions.tex}
\end{document}
"""


@pytest.mark.nightly
def test_figures_and_tables_are_set_by_a_latex_that_has_only_pgf_and_booktabs(tmp_path):
    needs("pdflatex")
    words = ("--figure-format", "pgf", "--figure-size", "one-column", "--out", tmp_path)
    succeeded("audit", "paper/sine-tsmc", *SHORT, *words)
    (tmp_path / "paper.tex").write_text(PAPER)
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "mu\\_1" in (tmp_path / "figures" / "margins.pgf").read_text()


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        ("plant_mass & co #1", r"plant\_mass \& co \#1"),
        (r"mass $m_\mathrm{eq}$ [kg]", r"mass $m_\mathrm{eq}$ {[}kg]"),
        (r"$\mathdefault{10^{-1}}$", "${10^{-1}}$"),
        (r"5 \$ of 10⁵", r"5 \$ of 10\ensuremath{^5}"),
    ],
)
def test_labels_keep_their_maths_and_nothing_else_that_latex_would_read(text, tex):
    assert latex_label(text) == tex
