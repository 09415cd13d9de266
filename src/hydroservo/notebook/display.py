"""Teaches a notebook to show results, which are Datasets of xarray, with what an engineer asks first."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


def show_results_in(shell: Any) -> None:
    """Have IPython show runs, tables of many and frequency responses by :func:`result_html`.

    Datasets of other origin look as ever, and xarray is not imported before there is one.

    Args:
        shell: IPython's, as ``get_ipython()`` returns it.
    """
    formatter = shell.display_formatter.formatters["text/html"]
    formatter.for_type_by_name("xarray.core.dataset", "Dataset", result_html)


def result_html(data: "xr.Dataset") -> str:
    """A Dataset as HTML; of a result first what was run, its metrics, and what a user should know.

    What is left of a result after a selection may lack its metrics; then it is shown as any Dataset is.
    """
    from hydroservo.notebook.cards import card_of

    card, whole = card_of(data), str(data._repr_html_())
    return f"{card}<details><summary>data</summary>{whole}</details>" if card else whole
