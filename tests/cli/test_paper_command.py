"""Reproducing the paper."""

import pytest

from hydroservo.papers.tsmc_eha_2021 import study as paper_study
from tests.support.commands.runner import succeeded

pytestmark = pytest.mark.slow  # it runs and draws


def test_paper_runs_the_study_writes_the_report_and_shows_verdicts(tmp_path, monkeypatch):
    from hydroservo.papers.tsmc_eha_2021.report import folder

    one = paper_study.Verdict(
        **dict.fromkeys(paper_study.Verdict._fields, ""),
    )._replace(claim="1", title="All track", reproduced=True, to_the_letter=False, holds=7, total=9)
    steps = []

    class Study:
        verdicts = (one,)

    def run_study(progress):
        progress(1, 2, "half")
        return Study

    def write_report(study, out, progress):
        progress(2, 2, "all")
        steps.append((study, out))
        return out / "report.html"

    monkeypatch.setattr(paper_study, "run_study", run_study)
    monkeypatch.setattr(folder, "write_paper_report", write_report)
    text = succeeded("paper", "--out", tmp_path / "report")
    assert steps == [(Study, tmp_path / "report")]
    row = next(line for line in text.splitlines() if "All track" in line)
    assert row.index("holds") < row.index("fails") < row.index("holds in 7 of 9")
    assert text.splitlines()[-1] == f"report: {tmp_path / 'report' / 'report.html'}"
