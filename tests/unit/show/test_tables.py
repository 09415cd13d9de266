"""Tables of numbers in SI units, as a reader, a spreadsheet and LaTeX have them."""

import io
import math
import re

import pandas as pd
import pytest

from hydroservo.core.formatting import MINUS, NONE, TIMES, Scale
from hydroservo.show import UNIT, Cell, Column, Finding, Line, Mark, Table
from hydroservo.show.html import html_of
from hydroservo.show.table import SPECIAL, csv_of, in_one_line, latex_escaped, latex_of, texts_of
from hydroservo.show.terminal import show_finding

METRICS = Table(
    "metrics",
    [Column("metric"), Column("value"), UNIT, Column("share", "%", digits=2), Column("sure")],
    [
        [Cell("rms_error, all"), Cell(1.23456e-3, "m/s", Mark.BEST), Cell(), Cell(12.345, "%"), Cell(True)],
        [Cell('a "quoted" one'), Cell(-2.0), Cell(), Cell(math.nan), Cell(None)],
        [Cell("max_error"), Cell(0.5, "m/s"), Cell(), Cell(100.0), Cell("by far")],
    ],
    "Title\nin 100 % of two lines",
)


def test_a_reader_gets_the_units_of_datasheets_and_one_for_each_quantity():
    texts = texts_of(METRICS)
    assert texts.headings == ["metric", "value", "unit", "share [%]", "sure"]
    assert texts.right == [False, True, False, True, False]
    assert texts.rows == [
        ["rms_error, all", "1.235", "mm/s", "12", "yes"],
        ['a "quoted" one', f"{MINUS}2", "", NONE, ""],
        ["max_error", "500", "mm/s", "100", "by far"],
    ]


def test_units_that_were_typed_go_first_and_cells_without_a_place_for_theirs_say_it():
    rows = [[Cell(0.02, "m"), Cell(0.03)], [Cell(2.0, "m"), Cell(1234)]]
    table = Table("t", [Column("a"), UNIT, Column("n")], [[a, Cell(), n] for a, n in rows])
    typed = table._replace(typed={"m": Scale("in", 1 / 0.0254), "": Scale("%", 100.0)})
    assert [row[:2] for row in texts_of(typed).rows] == [["0.7874", "in"], ["78.74", "in"]]
    assert texts_of(Table("t", [Column("a"), Column("n")], rows)).rows == [
        ["20 mm", "0.03"],
        ["2000 mm", "1,234"],
    ]


def test_a_spreadsheet_reads_all_digits_in_si_units():
    found = pd.read_csv(io.StringIO(csv_of(METRICS)))
    assert list(found) == ["metric", "value", "unit", "share [%]", "sure"]
    assert found["metric"].tolist() == ["rms_error, all", 'a "quoted" one', "max_error"]
    assert found["value"].tolist() == [1.23456e-3, -2.0, 0.5]
    assert found["unit"].tolist()[::2] == ["m/s", "m/s"]
    assert found["sure"].tolist()[::2] == ["1", "by far"]


def test_latex_has_the_rules_of_booktabs_and_a_line_for_each_row():
    assert latex_of(METRICS).splitlines() == [
        "% Title in 100 % of two lines",
        "% Bold: the best.",
        r"% needs \usepackage{booktabs}",
        r"\begin{tabular}{lrlrl}",
        r"\toprule",
        r"metric & value & unit & share {[}\%] & sure \\",
        r"\midrule",
        r"rms\_error, all & \textbf{1.235} & mm/s & 12 & yes \\",
        r"a \textquotedbl{}quoted\textquotedbl{} one & \ensuremath{-}2 &  & -- &  \\",
        r"max\_error & 500 & mm/s & 100 & by far \\",
        r"\bottomrule",
        r"\end{tabular}",
    ]


HOSTILE = Finding(
    "<a>[red]",
    [Line("<b>[red]", " <c>", Mark.BAD), Line("run it:", command="hydroservo <d>")],
    ["<e>"],
    [Table("t", [Column("<f>[red]")], [[Cell("<g>[red]")]]), Table("empty", [Column("h")], [])],
    [],
    {},
)


def test_a_page_escapes_all_and_leaves_out_empty_tables():
    page = html_of(HOSTILE)
    assert not re.search("<(a|c|d|e|f|g)>", page)
    assert "<b>&lt;b&gt;[red]</b> &lt;c&gt;" in page
    assert page.count("<table>") == 1


def test_a_terminal_shows_names_in_brackets_as_they_are(capsys):
    show_finding(HOSTILE)
    said = capsys.readouterr().out
    assert [said.count(f"<{letter}>[red]") for letter in "abfg"] == [1, 1, 1, 1]
    assert "run it: hydroservo <d>\n" in said


@pytest.mark.parametrize("sign", [*"\\&%$#_{}~^", "\n"])
def test_no_sign_that_latex_reads_as_a_command_is_left(sign):
    text = in_one_line(f"a{sign}b")
    bare = re.sub(r"\\[a-zA-Z]+\{\}|\\.|\{[^\\]\}", "", text)
    assert not set(bare) & set("\\&%$#_{}~^\n")


def test_every_sign_beyond_ascii_becomes_ascii():
    beyond = "".join(sign for sign in SPECIAL if not sign.isascii())
    assert latex_escaped(beyond).isascii()
    assert latex_escaped("3 m/s²") == r"3 m/s\ensuremath{^2}"


def test_a_narrow_terminal_loses_what_numbers_mean_and_never_a_digit(capsys, monkeypatch):
    monkeypatch.setattr("hydroservo.show.terminal.PIPED_WIDTH", 40)
    columns = [Column("metric"), *map(Column, "abcd"), UNIT, Column("meaning")]
    row = [Cell("steady_rms_error"), *[Cell(1.234e-9, "m/s")] * 4, Cell(), Cell("rms of the error " * 4)]
    show_finding(HOSTILE._replace(tables=[Table("t", columns, [row])]))
    said = capsys.readouterr().out
    assert "meaning" not in said
    assert said.count(f"1.234 {TIMES} 10⁻⁶") == 4
    assert "mm/s" in said
