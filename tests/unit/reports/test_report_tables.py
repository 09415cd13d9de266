"""A report's tables, as a spreadsheet and as LaTeX read them."""

import io
import re

import pandas as pd
import pytest

from hydroservo.figures.latex_text import SPECIAL, escaped
from hydroservo.reports.latex import in_one_line, latex_text
from hydroservo.reports.table import Column, Table, csv_text

TABLE = Table(
    "metrics",
    [Column("metric"), Column("value [%]", number=True)],
    [["rms_error, all", "1.5"], ['a "quoted" one', "-2"]],
    "Title\nin 100 % of two lines",
    marked=frozenset({(1, 1)}),
)


def test_a_spreadsheet_reads_what_was_written():
    found = pd.read_csv(io.StringIO(csv_text(TABLE)))
    assert list(found) == ["metric", "value [%]"]
    assert found["metric"].tolist() == ["rms_error, all", 'a "quoted" one']
    assert found["value [%]"].tolist() == [1.5, -2.0]


def test_latex_has_the_rules_of_booktabs_and_a_line_for_each_row():
    lines = latex_text(TABLE).splitlines()
    assert lines == [
        "% Title in 100 % of two lines",
        r"% needs \usepackage{booktabs}",
        r"\begin{tabular}{lr}",
        r"\toprule",
        r"metric & value {[}\%] \\",
        r"\midrule",
        r"rms\_error, all & 1.5 \\",
        r"a \textquotedbl{}quoted\textquotedbl{} one & \textbf{{-}2} \\",
        r"\bottomrule",
        r"\end{tabular}",
    ]


@pytest.mark.parametrize("sign", [*"\\&%$#_{}~^", "\n"])
def test_no_sign_that_latex_reads_as_a_command_is_left(sign):
    text = in_one_line(f"a{sign}b")
    bare = re.sub(r"\\[a-zA-Z]+\{\}|\\.|\{[^\\]\}", "", text)
    assert not set(bare) & set("\\&%$#_{}~^\n")


def test_every_sign_beyond_ascii_becomes_ascii():
    beyond = "".join(sign for sign in SPECIAL if not sign.isascii())
    assert escaped(beyond).isascii()
    assert escaped("3 m/s²") == r"3 m/s\ensuremath{^2}"
