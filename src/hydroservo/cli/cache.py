"""The command that says what is kept on disk."""

from typing import TYPE_CHECKING, Annotated

import typer

from hydroservo.cli.options import Json

if TYPE_CHECKING:
    from hydroservo.engine.kept import Kept

__all__ = ["cache"]

MIB = 2**20  # bytes


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Remove all that is kept.")] = False,
    json: Json = False,
) -> None:
    """Show where compiled loops are kept, how much they take, and whether they are trusted.

    A compiled loop is kept in this user's cache directory (HYDROSERVO_CACHE_DIR names another), so that the
    next command need not compile it. What others may have written there is not loaded, nor what is damaged;
    it is compiled again. To clear it costs nothing but that time.

    Examples:

    - `hydroservo cache`
    - `hydroservo cache --clear`
    """
    from hydroservo.engine.kept import clear as cleared
    from hydroservo.engine.kept import kept
    from hydroservo.runs.results import as_json

    removed = cleared() if clear else 0
    found = kept()
    if json:
        said = {**found._asdict(), "place": str(found.place), "trusted": not found.problem}
        typer.echo(as_json({**said, "removed": removed}))
    elif clear:
        typer.echo(f"{found.place}: {removed} kernel{'s' * (removed != 1)} removed")
    else:
        typer.echo("\n".join(lines_of(found)))


def lines_of(found: "Kept") -> list[str]:
    """What is said of the cache."""
    if not found.exists:
        return [f"folder   {found.place}, not made yet"]
    lines = [
        f"folder   {found.place}",
        f"kernels  {found.kernels}, {found.bytes / MIB:.3g} MiB",
        f"owner    {found.owner or 'unknown'}",
        f"trusted  {f'no: {found.problem}; --clear removes what is in it' if found.problem else 'yes'}",
    ]
    return [*lines, *(f"refused  {name}: {why}" for name, why in found.refused.items())]
