"""The command that holds laws against each other."""

from pathlib import Path
from typing import Annotated

import typer

from hydroservo.cli.interrupts import acknowledge_interrupt
from hydroservo.cli.messages import progress_bar, say_warning
from hydroservo.cli.options import (
    WHERE,
    DecimalComma,
    FigureFormat,
    Json,
    Plugins,
    check_one_place,
    folder_at,
    list_option,
    studies_like,
)
from hydroservo.show.journal import journal_of


def study_command(
    context: typer.Context,
    file: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A study's file (TOML), or the name of a built-in one.",
            autocompletion=studies_like,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            metavar="DIR",
            parser=folder_at,
            show_default=False,
            help=f"The folder of the study; what is done there already is not done again. {WHERE}",
        ),
    ],
    changes: Annotated[
        list[str],
        list_option(
            "--set",
            "a.b=VALUE",
            "Change one entry of the study: `search.candidates=512`, `conditions.test=50`.",
        ),
    ],
    plugins: Plugins,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", min=1, show_default="all cores", help="Processes to use."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            show_default=False,
            help="Let the workers of this Dask scheduler do it, such as `tcp://head:8786`.",
        ),
    ] = None,
    figure_format: FigureFormat = None,
    decimal_comma: DecimalComma = False,
    json: Json = False,
) -> None:
    """Search and judge laws alike, and print the error of each at equal activity of its command.

    The folder has the table of all runs as Parquet (parts), margins and prices on the target (properties),
    what they say (verdicts.json, report.html, its tables as CSV and LaTeX in tables), a scenario for each law
    in each cell, and the limits of its conditions where the study asks for them, which needs CasADi. Stopped
    at any instant, the same command carries on; with another file or --set it does only what is new.

    Built in are `small`, which takes about a minute on two idle cores, and `velocity`, which takes an hour
    and a half.

    Examples:

    - `hydroservo study small --out small-study`
    - `hydroservo study my-study.toml --out my-study --set search.candidates=512 --json`
    """
    from hydroservo.cli.frame import repeat_command, try_outputs
    from hydroservo.scenario import parse_override
    from hydroservo.show.files import as_json
    from hydroservo.show.terminal import show_finding
    from hydroservo.studies.report.finding import study_finding
    from hydroservo.studies.report.folder import study_report_files, write_study_report
    from hydroservo.studies.study import MANIFEST, study

    check_one_place(workers, scheduler)
    journal = journal_of(figure_format, None, out, decimal_comma)
    try_outputs([out / MANIFEST, *study_report_files(out)])
    with progress_bar("reading the study") as report:
        try:
            found = study(
                file,
                out,
                changes=dict(map(parse_override, changes)),
                plugins=plugins,
                workers=workers,
                scheduler=scheduler,
                progress=lambda fraction: report(fraction, file),
                say=lambda text: say_warning(file, text),
            )
        except KeyboardInterrupt:
            acknowledge_interrupt(f"; what is done is in {out}, and the same command goes on from there")
            raise
        report(1.0, "drawing")
        page = write_study_report(
            found.table,
            found.manifest,
            found.verdicts,
            found.folder,
            journal=journal,
            command=repeat_command(context),
        )
    finding = study_finding(found)
    if json:
        typer.echo(as_json(finding.numbers))
    else:
        show_finding(finding)
        typer.echo(f"written: {page}")


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
    from hydroservo.papers.tsmc_eha_2021.report.folder import paper_report_files, write_paper_report
    from hydroservo.papers.tsmc_eha_2021.report.tables import verdict_table
    from hydroservo.papers.tsmc_eha_2021.study import run_study
    from hydroservo.show.terminal import show_table

    try_outputs(paper_report_files(out))
    with progress_bar("preparing") as report:

        def progress(done: int, total: int, what: str) -> None:
            report(done / total, what)

        study = run_study(progress)
        left = write_or_keep(out, lambda place: [write_paper_report(study, place, progress)])
    show_table(verdict_table(study.verdicts))
    left.check()
    typer.echo(f"report: {left.files[0]}")
