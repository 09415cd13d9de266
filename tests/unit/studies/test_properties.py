"""What no run says of a law: margins that hold, its price on the target, and how both are shown."""

import json
import math

import pytest

from hydroservo import load_scenario
from hydroservo.core.block import replace, value_at
from hydroservo.linear import Margins, margins
from hydroservo.studies.properties import (
    ENDLESS,
    UNTRANSLATED,
    LawMargins,
    OnTarget,
    Properties,
    law_margins,
    least_margins,
    target_price,
)
from hydroservo.studies.report.folder import write_study_report
from hydroservo.studies.report.pictures import study_pictures
from hydroservo.studies.report.sentences import sentences
from hydroservo.studies.report.tables import cell_tables, law_tables
from hydroservo.studies.report.view import study_view
from hydroservo.studies.trials import Rules
from hydroservo.studies.verdicts import as_json_value, study_verdicts
from tests.support.export.small_laws import law
from tests.support.study_data import made_up_manifest, made_up_table, part_of

LAWS, CELLS = ["PI+ESO", "PI+Kalman", "TSMC+Kalman"], ["fast-low-quick", "fast-high-quick"]
STABLE = Margins(True, 3.0, 0.0, 1.0, 0.01, 0.9, 1.6, (20.0,), (90.0,), 0.0)


def test_each_margin_is_the_least_of_all_points() -> None:
    other = STABLE._replace(
        gain_margin=2.0, gain_reduction_margin=0.5, sensitivity_peak=2.2, phase_margin=1.2
    )
    found = least_margins([STABLE, other])
    assert found == LawMargins(2, 2, True, 2.0, 0.5, 1.0, 0.01, 0.9, 2.2, "")


def test_a_loop_that_is_unstable_somewhere_has_no_margins() -> None:
    found = least_margins([STABLE, Margins(False, *[math.nan] * 6, (), (), 0.0)])
    assert not found.stable
    assert found.linear == 2
    assert math.isnan(found.gain_margin)
    assert as_json_value(found)["sensitivity_peak"] is None


def test_what_differs_behind_the_fifth_digit_is_the_same() -> None:
    close = STABLE._replace(gain_margin=3.0 * (1.0 + 1e-9), delay_margin=0.01 * (1.0 - 1e-9))
    assert least_margins([close]) == least_margins([STABLE])


def test_a_gain_beyond_the_margin_makes_a_loop_unstable() -> None:
    loop = load_scenario("laws/pi-sine", {"sensors.type": "IdealSensors"})
    found = law_margins([loop])
    assert (found.points, found.linear, found.stable) == (2, 2, True)

    def stable(factor: float) -> bool:
        names = ("controller.proportional_gain", "controller.integral_gain")
        return law_margins([replace(loop, {name: factor * value_at(loop, name) for name in names})]).stable

    assert stable(0.99 * found.gain_margin)
    assert not stable(1.01 * found.gain_margin)


def test_the_rest_of_a_machine_is_one_of_the_points() -> None:
    loop = load_scenario("laws/pi-sine")
    at_rest = margins(loop, command=0.0)
    found = law_margins([loop])
    assert found.gain_margin <= at_rest.gain_margin * (1.0 + 1e-4)
    assert found.sensitivity_peak >= at_rest.sensitivity_peak * (1.0 - 1e-4)


def test_a_law_that_rises_without_bound_has_no_margins() -> None:
    found = law_margins([load_scenario("laws/terminal-sine")])
    assert (found.points, found.linear, found.stable) == (2, 0, False)
    assert math.isnan(found.gain_margin)
    assert "ValveInversion" in found.nonlinear


def test_the_price_of_a_pi_is_what_its_text_says() -> None:
    found = target_price(load_scenario("laws/pi-sine"))
    assert found == OnTarget(15, 5, 4, 0, 0, 6, 0, 24, 40)  # docs/target.md has the same bytes


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("u = y.velocity\nwhile u > 1.0:\n    u = 0.5 * u\nreturn LawState(u, 0.0)", ENDLESS),
        ("return LawState(outside(y.velocity), 0.0)", UNTRANSLATED),
    ],
)
def test_a_law_that_cannot_be_counted_says_why(body: str, why: str, tmp_path) -> None:
    found = target_price(law(tmp_path, body))
    assert found.uncounted == why
    assert found.operations is None


def test_a_report_shows_margins_and_prices_and_says_what_has_none(tmp_path) -> None:
    manifest = part_of(made_up_manifest(), LAWS, CELLS)
    table = made_up_table(manifest)
    rough = least_margins([])._replace(points=3, nonlinear="it switches")
    one = least_margins([STABLE])._replace(points=3)
    target = OnTarget(1234, 600, 500, 30, 4, 100, 2, 64, 216)
    own = {LAWS[0]: Properties(one, target), LAWS[1]: Properties(one, target._replace(operations=12))}
    own[LAWS[2]] = Properties(rough, OnTarget(uncounted=ENDLESS))
    properties = {"1": dict.fromkeys(CELLS, own)}
    verdicts = study_verdicts(table, manifest, Rules(resamples=100), properties=properties)
    found = study_view(manifest, verdicts)
    assert "target" in [picture.name for picture in study_pictures(found)]
    said = " ".join(sentences(found))
    assert "In small motions 2 of the 6 pairs of law and cell are not linear, and 0 unstable" in said
    write_study_report(table, manifest, verdicts, tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert page.count('<td class="quiet">not linear</td>') == len(CELLS)
    assert page.count('<td class="n">1,234</td>') == len(CELLS) + 1
    _, prices = law_tables(found)
    columns = [column.heading for column in prices.columns]
    counts = {row[0].value: row[columns.index("not linear")].value for row in prices.rows}
    assert counts == dict.fromkeys(LAWS, 0) | {LAWS[2]: len(CELLS)}
    rows = {row[0].value: row for row in cell_tables(found, CELLS[0])[-1].rows}
    assert [cell.value for cell in rows[LAWS[0]][2:6]] == [1, 3, 0.0, 3.0]
    assert rows[LAWS[0]][9].value == 20.0 * math.log10(1.6)
    assert all(math.isnan(cell.value) for cell in rows[LAWS[2]][4:10])
    assert [cell.value for cell in rows[LAWS[1]][10:]] == [12, 30, 4, 2, 64, 216]
    levels = json.loads((tmp_path / "verdicts.json").read_text("utf-8"))["levels"]
    cell = levels["1"]["cells"][CELLS[0]]
    assert cell["properties"][LAWS[2]]["margins"]["nonlinear"] == "it switches"
    assert cell["properties"][LAWS[1]]["target"]["operations"] == 12
