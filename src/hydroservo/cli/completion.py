"""What a shell offers for what is typed so far: built-in names, files and types."""

from collections.abc import Iterable, Iterator
from glob import escape
from pathlib import Path

from hydroservo.core.builtin import titles


def scenarios_like(incomplete: str) -> list[str]:
    """Built-in scenarios, and TOML files and folders, whose names begin so."""
    return [*names_starting(titles("scenario"), incomplete), *files_like(incomplete)]


def studies_like(incomplete: str) -> list[str]:
    """Built-in studies, and TOML files and folders, whose names begin so."""
    return [*names_starting(titles("studies"), incomplete), *files_like(incomplete)]


def types_like(incomplete: str) -> list[str]:
    """Roles and types whose names begin so."""
    from hydroservo.scenario.keys import types_by_role

    roles = types_by_role()
    types = {name for names in roles.values() for name in names}
    return sorted(names_starting({"simulation", *roles, *types}, incomplete))


def names_starting(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def files_like(incomplete: str) -> Iterator[str]:
    typed = Path(incomplete)
    folder, name = (typed, "") if incomplete.endswith("/") or not incomplete else (typed.parent, typed.name)
    for path in sorted(folder.glob(f"{escape(name)}*")):
        if path.is_dir():
            yield f"{path}/"
        elif path.suffix == ".toml":
            yield str(path)
