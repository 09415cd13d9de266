"""What commands say of integration steps."""

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["say_steps"]


def say_steps(scenario: str, dataset: "xr.Dataset") -> None:
    """What there is to say of a run's integration steps, on stderr."""
    about = dataset.attrs
    if "substeps" in about:
        typer.echo(
            f"{scenario}: {about['substeps']} substeps a sample; twice as many differ by "
            f"{about['step_error']:.1e} of the machine's largest values",
            err=True,
        )
    if "warning" in about:
        typer.echo(f"hydroservo: warning: {scenario}: {about['warning']}", err=True)
