"""The command that reproduces the paper's study."""

from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.places import WHERE, folder_at


def paper_command(
    out: Annotated[
        Path,
        typer.Option(
            "--out", metavar="DIR", parser=folder_at, help=f"Write the report to this folder. {WHERE}"
        ),
    ] = Path("hydroservo-paper"),
) -> None:
    """Reproduce the terminal sliding mode study of doi:10.1007/s42401-021-00087-w and judge its claims.

    It leaves the figures (PNG, SVG), the metrics (CSV, JSON), the trajectories and a report (report.html)
    that opens in any browser, offline.
    """
    from hydroservo.cli.frame import try_outputs, write_or_keep
    from hydroservo.cli.progress import progress_bar
    from hydroservo.papers.tsmc_eha_2021.report.folder import report_files, write_report
    from hydroservo.papers.tsmc_eha_2021.report.tables import verdict_table
    from hydroservo.papers.tsmc_eha_2021.study import run_study
    from hydroservo.show.terminal import show_table

    try_outputs(report_files(out))
    with progress_bar("preparing") as report:

        def progress(done: int, total: int, what: str) -> None:
            report(done / total, what)

        study = run_study(progress)
        left = write_or_keep(out, lambda place: [write_report(study, place, progress)])
    show_table(verdict_table(study.verdicts))
    left.check()
    typer.echo(f"report: {left.files[0]}")
