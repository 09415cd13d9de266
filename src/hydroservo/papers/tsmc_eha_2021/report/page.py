"""The report as one page of HTML that refers to no other file."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hydroservo.formatting import quantity
from hydroservo.papers import tsmc_eha_2021 as paper
from hydroservo.papers.tsmc_eha_2021 import conditions
from hydroservo.papers.tsmc_eha_2021.claims import CLAIMS
from hydroservo.papers.tsmc_eha_2021.errata import ERRATA
from hydroservo.papers.tsmc_eha_2021.machine import COMMAND_LIMIT, DURATION
from hydroservo.papers.tsmc_eha_2021.report import tables, theory
from hydroservo.papers.tsmc_eha_2021.report.figures import FIGURES
from hydroservo.papers.tsmc_eha_2021.report.names import Trajectories, condition_name
from hydroservo.papers.tsmc_eha_2021.report.typeset import symbols
from hydroservo.papers.tsmc_eha_2021.report.verdict_map import BINS, FILLS
from hydroservo.papers.tsmc_eha_2021.study import Study
from hydroservo.show.page import address, environment

if TYPE_CHECKING:
    import jinja2


def page(study: Study, out: Path, fingerprint: str) -> str:
    """The report's HTML.

    Args:
        study: what is reported.
        out: the folder that holds the figures and pictures of verdicts as SVG.
        fingerprint: names the results.
    """
    data = study.trajectories
    return template().render(
        paper=paper,
        version=next(iter(data.values())).attrs["version"],
        fingerprint=fingerprint,
        scenarios=[{"name": f"paper/{name}", "hash": one.attrs["hash"]} for name, one in data.items()],
        grid=tables.grid(),
        runs=len(study.outcomes),
        duration=quantity(DURATION, "s"),
        limit=quantity(COMMAND_LIMIT.limit, "V"),
        step=f"{1e6 * conditions.STEP:g} µs",
        summary=tables.summary(study),
        reproduced=", ".join(condition_name(conditions.REPRODUCED)),
        literal=", ".join(condition_name(conditions.LITERAL)),
        overview=address(out / "overview.svg"),
        map=address(out / "verdicts.svg"),
        verdicts=tables.verdict_rows(study),
        figures=figures(data, out),
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
    templates = environment("hydroservo.papers.tsmc_eha_2021.report")
    templates.filters["symbols"] = symbols
    return templates.get_template("report.html.j2")


def figures(trajectories: Trajectories, out: Path) -> list[dict[str, Any]]:
    return [
        {
            "number": one.number,
            "caption": one.caption,
            "seen": one.seen(trajectories),
            "picture": address(out / f"fig{one.number:02d}.svg"),
        }
        for one in FIGURES
    ]
