"""A workbench for servo-hydraulic axes: ``import hydroservo as hs``.

What it offers is imported when it is first asked for, so that the package itself is there at once.
"""

import sys


def _homes() -> dict[str, str]:
    """The module of each name that is offered, as ``__init__.pyi`` says it to type checkers too."""
    with open(f"{__path__[0]}/__init__.pyi", encoding="utf-8") as stub:  # noqa: PTH123 - pathlib takes longer
        lines = [line.split() for line in stub if line.startswith("from ")]
    return {name: home for _, home, _, name, *_ in lines}


_HOMES = _homes()
__all__ = list(_HOMES)


def __getattr__(name: str) -> object:
    """What the package offers, imported when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    home = import_module(_HOMES[name])
    return vars(home)[name] if name in vars(home) else import_module(f"{home.__name__}.{name}")


def __dir__() -> list[str]:
    return __all__


def _show_in_notebooks() -> None:
    """Where IPython runs, results are shown there as ``hydroservo.notebook`` has them."""
    from importlib import import_module

    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        import_module(f"{__name__}.notebook").show_results_in(shell)


_show_in_notebooks()
