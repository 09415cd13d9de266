"""CSV with semicolons and decimal commas."""

import csv
import io

import pytest

from hydroservo.show.journal import decimal_commas


@pytest.mark.parametrize(
    ("given", "wanted"),
    [
        ("0.5", "0,5"),
        ("-1.5e-07", "-1,5e-07"),
        ("12", "12"),
        ("nan", "nan"),
        ("\N{MINUS SIGN}9.498", "\N{MINUS SIGN}9,498"),
        ("1.20 \N{MULTIPLICATION SIGN} 10⁻⁵", "1,20 \N{MULTIPLICATION SIGN} 10⁻⁵"),
        ("0.1.0", "0.1.0"),  # a version
        ("my.toml", "my.toml"),
        ("plant.mass [kg]", "plant.mass [kg]"),
    ],
)
def test_numbers_get_commas_and_nothing_else(given, wanted):
    assert decimal_commas(f"name,{given}\n") == f"name;{wanted}\n"


def test_cells_with_commas_semicolons_and_quotes_stay_what_they_are():
    rows = [["a, b", "c; d", 'e "f"', "g\nh"], ["1.5", "", "-2", "x.5"]]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    back = [*csv.reader(io.StringIO(decimal_commas(text.getvalue()), newline=""), delimiter=";")]
    assert back == [rows[0], ["1,5", "", "-2", "x.5"]]
