"""The report and the pictures of verdicts, made from a study whose numbers are made up."""

import html
import json
import math
import re
import zlib

import numpy as np
import pandas as pd
import pytest

from hydroservo.core.formatting import MINUS, TIMES
from hydroservo.papers.tsmc_eha_2021.claims import (
    CLAIMS,
    LITERAL,
    REPRODUCED,
    Claim,
    Condition,
    Judgement,
    PaperRun,
    RunOutcome,
    all_runs,
    condition_runs,
)
from hydroservo.papers.tsmc_eha_2021.report.figures import FIGURES
from hydroservo.papers.tsmc_eha_2021.report.folder import paper_report_files, write_paper_report
from hydroservo.papers.tsmc_eha_2021.report.names import html_symbols
from hydroservo.papers.tsmc_eha_2021.report.tables import best_marks, worst_case
from hydroservo.papers.tsmc_eha_2021.report.verdict_map import (
    BINS,
    claim_cells,
    claim_shares,
    colour_class,
    draw_map,
    draw_overview,
)
from hydroservo.papers.tsmc_eha_2021.study import PaperStudy, judge_claims, metrics_frame
from hydroservo.papers.tsmc_eha_2021.study import claim_verdicts as judge
from hydroservo.show.files import foreign_files
from tests.support.study import METRIC_FIELDS, lost, made_up_runs

REPORT = "hydroservo.papers.tsmc_eha_2021.report"
SETTLED = ("error", "s1", "s2", "xi1", "xi2", "miss1", "miss2")


def made_up_outcome(run):
    """Numbers between 1/100 and 100 of their usual size that only the run decides; one in five diverged."""
    random = np.random.default_rng(zlib.crc32(repr(tuple(run)).encode()))
    metrics = {name: float(1e-3 * 10 ** random.uniform(-2, 2)) for name in METRIC_FIELDS[run.controller]}
    metrics |= {"stroke_left": float(random.random() < 0.3), "diverged": float(random.random() < 0.2)}
    if metrics["diverged"]:
        metrics |= {"steady_rms_error": math.nan, "max_error": math.inf}
        metrics |= {name: math.nan for name in metrics if name.startswith("estimate")}
    settled = {name: float(1e-3 * 10 ** random.uniform(-2, 2)) for name in SETTLED}
    return RunOutcome(metrics, settled if run.realisation else {"error": settled["error"]})


def made_up_study(trajectories):
    outcomes = {run: made_up_outcome(run) for run in all_runs()}
    claims = judge_claims(outcomes)
    return PaperStudy(trajectories, metrics_frame(outcomes), claims, judge(claims), outcomes)


@pytest.fixture(scope="module")
def study():
    return made_up_study(made_up_runs())


@pytest.fixture(scope="module")
def folder(study, tmp_path_factory):
    """A written report, of which two figures are drawn: the others have tests of their own."""
    out = tmp_path_factory.mktemp("report")
    with pytest.MonkeyPatch.context() as patch:
        two_figures(patch)
        steps = []
        assert write_paper_report(study, out, lambda *step: steps.append(step)) == out / "report.html"
    assert steps
    return out


def two_figures(patch):
    patch.setattr(f"{REPORT}.figures.FIGURES", FIGURES[:2])
    patch.setattr(f"{REPORT}.folder.FIGURES", FIGURES[:2])


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def text_of(folder):
    """What the page says, without tags and pictures."""
    page = (folder / "report.html").read_text(encoding="utf-8")
    page = re.sub(r"<style>.*?</style>|<[^>]*>", "", page, flags=re.DOTALL)
    return " ".join(html.unescape(page).split())


def test_the_folder_holds_everything(folder):
    pictures = [
        f"{stem}.{ending}" for stem in ("fig03", "fig04", "overview", "verdicts") for ending in ("png", "svg")
    ]
    trajectories = [
        f"trajectories/{demand}-{name}.nc"
        for demand in ("sine", "square")
        for name in ("backstepping", "pi", "tsmc")
    ]
    assert sorted(contents(folder)) == sorted(
        [*pictures, *trajectories, "metrics.csv", "metrics.json", "report.html"]
    )
    assert foreign_files(folder) == []


def test_what_will_be_written_is_known_beforehand(folder, monkeypatch):
    monkeypatch.setattr(f"{REPORT}.folder.FIGURES", FIGURES[:2])
    assert sorted(paper_report_files(folder)) == sorted(folder / name for name in contents(folder))


@pytest.mark.slow
def test_equal_studies_give_equal_bytes(folder, tmp_path, monkeypatch):
    two_figures(monkeypatch)
    write_paper_report(made_up_study(made_up_runs()), tmp_path)
    again = contents(tmp_path)
    assert [name for name, data in contents(folder).items() if again[name] != data] == []


def test_the_page_needs_no_other_file(folder):
    page = (folder / "report.html").read_text(encoding="utf-8")
    addresses = re.findall(r"""(?:src|href|srcset|data|action)\s*=\s*["']([^"']*)""", page)
    inside = [address for address in addresses if address.startswith(("data:image/svg+xml;base64,", "#"))]
    assert set(addresses) - set(inside) == {"https://doi.org/10.1007/s42401-021-00087-w"}
    assert not re.search(r"<script|<link|@import|url\(", page)
    assert len(page) < 5e6
    anchors = set(re.findall(r'id="([^"]*)"', page))
    assert {address[1:] for address in inside if address.startswith("#")} <= anchors


def test_the_page_is_well_formed(folder):
    page = (folder / "report.html").read_text(encoding="utf-8")
    for tag in ("table", "tr", "td", "th", "figure", "div", "section", "span", "sub", "sup", "i", "code"):
        assert len(re.findall(rf"<{tag}[ >]", page)) == page.count(f"</{tag}>"), tag
    assert "{{" not in page
    assert "&lt;sub" not in page


def test_nothing_but_the_contents_is_left_out_in_print(folder):
    page = (folder / "report.html").read_text(encoding="utf-8")
    printed = page.partition("@media print")[2].partition("</style>")[0]
    assert re.findall(r"([^{}]*)\{ display: none; \}", printed) == ["\n  nav "]
    assert "<details" not in page  # which is printed folded


def test_the_page_says_each_verdict_with_its_numbers(folder, study):
    text = text_of(folder)
    for claim, verdict in zip(CLAIMS, study.verdicts, strict=True):
        assert f"holds in {verdict.holds} of {verdict.total}" in text
        results = {key: study.outcomes[run] for key, run in condition_runs(REPRODUCED).items()}
        said = html.unescape(re.sub("<[^>]*>", "", str(html_symbols(worst_case(claim, results)))))
        assert said in text


def test_the_page_counts_the_verdicts(folder, study):
    assert sum(verdict.reproduced for verdict in study.verdicts) not in (0, len(CLAIMS))
    reproduced = sum(verdict.reproduced for verdict in study.verdicts)
    literal = sum(verdict.to_the_letter for verdict in study.verdicts)
    assert f"{reproduced} hold as reproduced and {literal} to the letter" in text_of(folder)
    assert f"{MINUS}Δ" in text_of(folder)
    assert f"slips mended: corrected, +Δ, {REPRODUCED.realisation}, static, 10 µs." in text_of(folder)


def test_the_stroke_is_reported(folder, study):
    left = int(study.metrics["stroke_left"].sum())
    assert (
        f"{left} of the {len(study.metrics)} runs left the stroke of 78 mm; of the six shown: none."
        in text_of(folder)
    )


def test_metrics_csv_names_units_and_holds_every_run(folder, study):
    table = pd.read_csv(folder / "metrics.csv", keep_default_na=False, na_values=["nan"])
    assert "rms_error [m/s]" in table.columns
    assert len(table) == len(all_runs())
    assert list(table.columns[: len(PaperRun._fields)]) == list(PaperRun._fields)
    assert table["rms_error [m/s]"].tolist() == study.metrics["rms_error"].tolist()
    assert set(table["diverged"]) == {0, 1}


def test_metrics_json_is_strict_and_has_null_for_what_is_not_finite(folder, study):
    def refuse(name):
        raise AssertionError(name)

    data = json.loads((folder / "metrics.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert data["units"]["rms_error"] == "m/s"
    assert len(data["runs"]) == len(all_runs())
    assert len(data["claims"]) == 108 * len(CLAIMS)
    assert [verdict["claim"] for verdict in data["verdicts"]] == [claim.name for claim in CLAIMS]
    for given, kept in zip(study.metrics.to_dict("records"), data["runs"], strict=True):
        assert kept["delta"] == given["delta"]
        assert kept["max_error"] == (given["max_error"] if math.isfinite(given["max_error"]) else None)
        assert kept["diverged"] is bool(given["diverged"])
    infinite = study.claims["ratio"].map(math.isinf)
    assert infinite.any()
    assert [claim["ratio"] is None for claim in data["claims"]] == infinite.tolist()


@pytest.mark.slow
def test_diverged_runs_are_reported(tmp_path, monkeypatch):
    two_figures(monkeypatch)
    study = made_up_study({name: lost(data) for name, data in made_up_runs().items()})
    write_paper_report(study, tmp_path)
    text = text_of(tmp_path)
    assert "TSMC diverged." in text
    assert "of the six shown: PI on the sine, backstepping on the sine" in text


def test_the_map_shows_the_ratios_of_the_claims_table(study):
    fig = draw_map(study.claims)
    for axis, claim in zip(fig.axes, CLAIMS, strict=False):
        (mesh,) = axis.collections
        shown = np.asarray(mesh.get_array()).reshape(6, 18)
        rows = study.claims[study.claims["claim"] == claim.name]
        expected = np.full((6, 18), np.nan)
        for _, row in rows.iterrows():
            y = 3 * ["corrected", "as printed"].index(row["reading"]) + row["delta"] + 1
            x = 9 * ["static", "10 ms lag"].index(row["valve"])
            x += 3 * ["10 us", "100 us", "1 ms"].index(row["period"])
            x += ["explicit", "boundary layer", "implicit"].index(row["realisation"])
            expected[y, x] = row["ratio"]
        finite_ones = np.isfinite(expected)
        np.testing.assert_array_equal(shown[finite_ones], expected[finite_ones])
        assert np.all(shown[~finite_ones] >= 1e300)
        np.testing.assert_array_equal(claim_cells(study.claims, claim.name), expected)
        colours = mesh.cmap(mesh.norm(shown))
        classes = np.vectorize(colour_class)(expected)
        expected_colours = mesh.cmap(classes)
        np.testing.assert_array_equal(colours, expected_colours)


def test_the_map_outlines_both_conditions_that_stand_out(study):
    axis = draw_map(study.claims).axes[0]
    corners = {tuple(patch.get_xy()) for patch in axis.patches}
    assert corners == {(1, 2), (0, 5)}
    assert Condition("corrected", 1, "boundary layer", "static", "10 us") == REPRODUCED
    assert Condition("as printed", 1, "explicit", "static", "10 us") == LITERAL


@pytest.mark.parametrize(
    ("ratio", "bin_"),
    [
        (0.0, 0),
        (0.0099, 0),
        (0.01, 1),
        (0.5, 2),
        (0.9999999, 2),
        (1.0, 3),
        (10.0, 4),
        (1e5, 5),
        (math.inf, 6),
    ],
)
def test_the_colour_changes_where_the_verdict_does(ratio, bin_):
    assert colour_class(ratio) == bin_
    assert BINS[bin_].startswith("holds" if ratio < 1.0 else "fails")


def test_the_overview_counts_as_the_verdicts_do(study):
    bars = draw_overview(study.claims, study.verdicts).axes[2]
    texts = [text.get_text() for text in bars.texts]
    assert texts == [str(verdict.holds) for verdict in study.verdicts]
    widths = [bar.get_width() for bar in bars.patches[len(CLAIMS) :]]
    assert widths == [verdict.holds for verdict in study.verdicts]


def test_shares_are_parts_of_the_conditions_with_one_value(study):
    table = claim_shares(study.claims, "valve")
    rows = study.claims[(study.claims["claim"] == "4 (loop)") & (study.claims["valve"] == "static")]
    assert list(table.columns) == ["static", "10 ms lag"]
    assert table.loc["4 (loop)", "static"] == pytest.approx(rows["holds"].mean())


# --- verdicts in words


def results(**changes):
    """The six outcomes of a condition, all 1, but for what is changed."""
    metrics = dict.fromkeys(METRIC_FIELDS["tsmc"], 1.0) | {"diverged": 0.0, "stroke_left": 0.0}
    every = {
        (demand, controller): RunOutcome(dict(metrics), dict.fromkeys(SETTLED, 1.0))
        for demand in ("sine", "square")
        for controller in ("pi", "backstepping", "tsmc")
    }
    for name, (key, value) in changes.items():
        every[key].metrics[name] = value
    return every


def claim_named(name):
    return next(claim for claim in CLAIMS if claim.name == name)


def test_a_verdict_names_the_worst_run_and_what_is_allowed():
    claim = Claim("", "", "", lambda _: Judgement("square", "backstepping", "steady_rms_error", 2.0, 0.003))
    said = worst_case(claim, results())
    assert said == (
        "backstepping on the square: 2000 mm/s (rms of the velocity error, second half), "
        "667 times the 3.00 mm/s allowed"
    )


def test_a_verdict_against_a_rival_names_the_rival():
    said = worst_case(claim_named("2 (sine)"), results(rms_error=(("sine", "pi"), 0.8)))
    assert said.endswith("1.25 times PI's 800 mm/s")
    assert said.startswith("TSMC on the sine: 1000 mm/s")


def test_a_ratio_near_one_is_said_finely_enough_to_tell_the_verdict():
    said = worst_case(claim_named("2 (sine)"), results(rms_error=(("sine", "pi"), 0.9999)))
    assert "1.0001 times" in said


def test_a_diverged_run_is_what_decides():
    assert (
        worst_case(claim_named("1"), results(diverged=(("square", "pi"), 1.0))) == "PI on the square diverged"
    )


def test_no_rival_left_is_said():
    every = results(diverged=(("sine", "pi"), 1.0))
    every["sine", "backstepping"].metrics["diverged"] = 1.0
    said = worst_case(claim_named("2 (sine)"), every)
    assert said == "PI on the sine, backstepping on the sine diverged, so no rival is left"


def test_a_number_that_is_none_is_said():
    said = worst_case(claim_named("3 (d1)"), results(estimate_rms_error_1=(("sine", "tsmc"), math.nan)))
    assert said == "no finite ratio: a number is missing, or the rival's is 0"


def test_a_rival_without_overshoot_is_not_said_to_have_no_number():
    said = worst_case(claim_named("2 (overshoot)"), results(overshoot=(("square", "pi"), 0.0)))
    assert "the rival's is 0" in said


def test_the_best_of_each_demand_is_marked_and_nothing_where_all_are_alike():
    runs = [{"overshoot": value, "diverged": False} for value in (0.0, 0.0, 0.0, 3.0, 2.0, 1.0)]
    assert best_marks(runs, "overshoot") == [False] * 5 + [True]


def test_what_decides_a_claim_is_a_number_of_the_run_it_names(study):
    for claim in CLAIMS:
        for condition in (REPRODUCED, LITERAL):
            every = {key: study.outcomes[run] for key, run in condition_runs(condition).items()}
            judgement = claim.judge(every)
            run = every[judgement.demand, judgement.controller]
            measured = (dict(run.settled) | dict(run.metrics))[judgement.name]
            assert judgement.measured == measured or run.metrics["diverged"]
            if judgement.rival and math.isfinite(judgement.allowed):
                rival = every[judgement.demand, judgement.rival]
                assert judgement.allowed == rival.metrics[judgement.name]


@pytest.mark.parametrize(
    ("measured", "allowed", "ratio"),
    [
        (1.0, 4.0, 0.25),
        (math.inf, 1.0, math.inf),
        (math.nan, 1.0, math.inf),
        (1.0, 0.0, math.inf),
        (1.0, math.nan, math.inf),
        (1.0, math.inf, 0.0),
        (math.inf, math.inf, math.inf),
    ],
)
def test_a_ratio_is_a_number_or_infinite(measured, allowed, ratio):
    assert Judgement("sine", "tsmc", "rms_error", measured, allowed).ratio == ratio


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("|xi1| below mu_1", "|<i>&xi;</i><sub>1</sub>| below <i>&mu;</i><sub>1</sub>"),
        ("plant.start_position is", "<code>plant.start_position</code> is"),
        (
            "xi1^(p1/q1) < 2",
            "<i>&xi;</i><sub>1</sub><sup><i>p</i><sub>1</sub>/<i>q</i><sub>1</sub></sup> &lt; 2",
        ),
        ("-Delta 3/36, 10 us", f"{MINUS}Δ 3/36, 10 µs"),
        ("f1 = -b x1/m +-D", f"<i>f</i><sub>1</sub> = {MINUS}b <i>x</i><sub>1</sub>/m ±D"),
        ("as it reached us", "as it reached us"),
        ("0.5 mm/s rms error of PI", "0.5 mm/s rms error of PI"),
        (f"8.1 {TIMES} 10⁻⁴ <b>", f"8.1 {TIMES} 10⁻⁴ &lt;b&gt;"),
        ("(20)-(22), half-volume", "(20)-(22), half-volume"),
        ("at least 1 m/s^2", "at least 1 m/s²"),
    ],
)
def test_symbols_look_like_symbols(text, shown):
    assert str(html_symbols(text)) == shown
