"""The report on the paper's study: a folder with its figures, its data and one page that opens offline."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo.control.metrics import METRIC_FIELDS
from hydroservo.core.formatting import quantity
from hydroservo.core.outputs import staged, write_text
from hydroservo.papers import tsmc_eha_2021 as paper
from hydroservo.papers.tsmc_eha_2021.claims import CLAIMS, CONTROLLERS, DEMANDS, LITERAL, REPRODUCED, STEP
from hydroservo.papers.tsmc_eha_2021.errata import ERRATA
from hydroservo.papers.tsmc_eha_2021.machine import COMMAND_LIMIT, DURATION
from hydroservo.papers.tsmc_eha_2021.report import tables, theory
from hydroservo.papers.tsmc_eha_2021.report.figures import FIGURES, draw_figures
from hydroservo.papers.tsmc_eha_2021.report.names import FLAGS, Trajectories, condition_name, html_symbols
from hydroservo.papers.tsmc_eha_2021.report.verdict_map import BINS, FILLS, draw_map, draw_overview
from hydroservo.papers.tsmc_eha_2021.study import PaperProgress, PaperStudy
from hydroservo.runs.results import metrics_csv, save
from hydroservo.show.files import METRICS, data_address, template_environment, write_figure, write_metrics

if TYPE_CHECKING:
    import jinja2

REPORT = "report.html"


def paper_page(study: PaperStudy, out: Path, fingerprint: str) -> str:
    """The report's HTML."""
    data = study.trajectories
    return template().render(
        paper=paper,
        version=next(iter(data.values())).attrs["version"],
        fingerprint=fingerprint,
        scenarios=[{"name": f"paper/{name}", "hash": one.attrs["hash"]} for name, one in data.items()],
        grid=tables.condition_grid(),
        runs=len(study.outcomes),
        duration=quantity(DURATION, "s"),
        limit=quantity(COMMAND_LIMIT.limit, "V"),
        step=f"{1e6 * STEP:g} µs",
        summary=tables.verdict_summary(study),
        reproduced=", ".join(condition_name(REPRODUCED)),
        literal=", ".join(condition_name(LITERAL)),
        overview=data_address(out / "overview.svg"),
        map=data_address(out / "verdicts.svg"),
        verdicts=tables.verdict_rows(study),
        figures=figure_rows(data, out),
        metrics=tables.metric_rows(data),
        stroke=tables.stroke(study),
        errata=ERRATA,
        bounds=theory.bound_rows(data),
        gains=theory.gain_rows(data),
        decreases=theory.decrease_rows(data),
        least_xi2=quantity(theory.LEAST_XI2, "m/s^2"),
        fills=list(zip(FILLS, BINS, strict=True)),
        claims=CLAIMS,
        ratios=tables.ratio_rows(study),
        listed=tables.listed_rows(study),
    )


def template() -> "jinja2.Template":
    templates = template_environment("hydroservo.papers.tsmc_eha_2021.report")
    templates.filters["symbols"] = html_symbols
    return templates.get_template("report.html.j2")


def figure_rows(trajectories: Trajectories, out: Path) -> list[dict[str, Any]]:
    return [
        {
            "number": one.number,
            "caption": one.caption,
            "seen": one.seen(trajectories),
            "picture": data_address(out / f"fig{one.number:02d}.svg"),
        }
        for one in FIGURES
    ]


def write_paper_report(study: PaperStudy, out: Path, progress: PaperProgress | None = None) -> Path:
    """Write the study's figures, pictures of verdicts, data and report into a folder.

    The folder then holds ``report.html``, ``fig03`` to ``fig10``, ``verdicts`` and ``overview`` (PNG and
    SVG), ``metrics.csv``, ``metrics.json`` and ``trajectories/NAME.nc``. The files take their
    places together, and equal studies give equal bytes. Returns the path of ``report.html``.
    """
    table = metrics_csv(study.metrics.astype(dict.fromkeys(FLAGS, bool)), METRIC_FIELDS)
    fingerprint = hashlib.sha256(table.encode()).hexdigest()[:12]
    with staged(out, last=METRICS) as stage:
        draw_figures(study.trajectories, stage, fingerprint, progress)
        write_figure(draw_map(study.claims), stage / "verdicts", fingerprint)
        write_figure(draw_overview(study.claims, study.verdicts), stage / "overview", fingerprint)
        for name, dataset in study.trajectories.items():
            save(dataset, stage / "trajectories" / f"{name}.nc")
        write_text(stage / "metrics.csv", table)
        write_text(stage / REPORT, paper_page(study, stage, fingerprint))
        write_metrics(stage, {"fingerprint": fingerprint, **paper_numbers(study)})
    return out / REPORT


def paper_report_files(out: Path) -> list[Path]:
    """What :func:`write_paper_report` writes into a folder."""
    stems = [*(f"fig{one.number:02d}" for one in FIGURES), "verdicts", "overview"]
    pictures = [f"{stem}{ending}" for stem in stems for ending in (".png", ".svg")]
    trajectories = [f"trajectories/{demand}-{law}.nc" for demand in DEMANDS for law in CONTROLLERS]
    return [out / name for name in (*pictures, *trajectories, "metrics.csv", REPORT, METRICS)]


def paper_numbers(study: PaperStudy) -> dict[str, Any]:
    """All runs, all ratios and all verdicts."""
    runs = study.metrics.astype(dict.fromkeys(FLAGS, bool))
    first = next(iter(study.trajectories.values()))
    return {
        "paper": f"doi:{paper.DOI}",
        "version": first.attrs["version"],
        "scenarios": {f"paper/{name}": data.attrs["hash"] for name, data in study.trajectories.items()},
        "units": {name: METRIC_FIELDS[name].unit for name in study.metrics if name in METRIC_FIELDS},
        "runs": runs.to_dict("records"),
        "claims": study.claims.to_dict("records"),
        "verdicts": [verdict._asdict() for verdict in study.verdicts],
    }
