"""Teaches a notebook to show results, which are Datasets of xarray, with what an engineer asks first."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


def show_results_in(shell: Any) -> None:
    """Have IPython show runs, tables of many and frequency responses by :func:`result_html`.

    Datasets of other origin look as ever, and xarray is not imported before there is one.
    """
    formatter = shell.display_formatter.formatters["text/html"]
    formatter.for_type_by_name("xarray.core.dataset", "Dataset", result_html)


def result_html(data: "xr.Dataset") -> str:
    """A Dataset as HTML; of a result first what it says.

    What is left of a result after a selection may lack its metrics; then it is shown as any Dataset is.
    """
    from hydroservo.findings import finding
    from hydroservo.show.html import html_of

    whole = str(data._repr_html_())
    if not has_all_it_says(data):
        return whole
    card = html_of(finding(data))
    return f"{card}<details><summary>data</summary>{whole}</details>"


def has_all_it_says(data: "xr.Dataset") -> bool:
    """Whether a Dataset is a result with all that a finding needs."""
    from hydroservo.linear.margins import MARGIN_LABELS
    from hydroservo.runs.arguments import is_result
    from hydroservo.runs.results import metric_fields

    if not is_result(data):
        return False
    if "frequency" in data.dims:
        return set(MARGIN_LABELS) <= set(data.data_vars)
    return "diverged" in data and bool(metric_fields(data))
