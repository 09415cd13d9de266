"""The report on the paper's study: a folder with its figures, its data and one page that opens offline."""

import hashlib
from pathlib import Path

from hydroservo.figures.overview import draw_overview
from hydroservo.figures.paper import draw_figures
from hydroservo.figures.report_page import page
from hydroservo.figures.style import save_figure
from hydroservo.figures.verdicts import draw_map
from hydroservo.metrics import FLAGS, METRIC_FIELDS
from hydroservo.papers import tsmc_eha_2021 as paper
from hydroservo.papers.tsmc_eha_2021.study import Progress, Study
from hydroservo.results import as_json, metrics_csv, save, write_text

__all__ = ["write_report"]


def write_report(study: Study, out: Path, progress: Progress | None = None) -> Path:
    """Write the study's figures, pictures of verdicts, data and report into a folder.

    The folder then holds ``report.html``, ``fig03`` to ``fig10``, ``verdicts`` and ``overview`` (PNG and
    SVG), ``metrics.csv``, ``metrics.json`` and ``trajectories/NAME.parquet``. Equal studies give equal bytes.

    Args:
        study: what ``run_study`` returned.
        out: the folder; missing ones are made.
        progress: called after each figure.

    Returns:
        The path of ``report.html``.

    Raises:
        HydroservoError: a file cannot be written.
    """
    draw_figures(study.trajectories, out, progress)
    save_figure(draw_map(study.claims), out / "verdicts")
    save_figure(draw_overview(study.claims, study.verdicts), out / "overview")
    for name, dataset in study.trajectories.items():
        save(dataset, out / "trajectories" / f"{name}.parquet")
    table = metrics_csv(study.metrics)
    write_text(out / "metrics.csv", table)
    write_text(out / "metrics.json", metrics_json(study))
    fingerprint = hashlib.sha256(table.encode()).hexdigest()[:12]
    return write_text(out / "report.html", page(study, out, fingerprint))


def metrics_json(study: Study) -> str:
    """All runs, all ratios and all verdicts; null where a number is not finite."""
    runs = study.metrics.astype(dict.fromkeys(FLAGS, bool))
    first = next(iter(study.trajectories.values()))
    content = {
        "paper": f"doi:{paper.DOI}",
        "version": first.attrs["version"],
        "scenarios": {f"paper/{name}": data.attrs["hash"] for name, data in study.trajectories.items()},
        "units": {name: field.unit for name, field in METRIC_FIELDS.items()},
        "runs": runs.to_dict("records"),
        "claims": study.claims.to_dict("records"),
        "verdicts": [verdict._asdict() for verdict in study.verdicts],
    }
    return as_json(content) + "\n"
