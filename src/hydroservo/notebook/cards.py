"""The part of a result that one wants at a glance, as HTML."""

import math
from typing import TYPE_CHECKING, Any

from hydroservo.formatting import NONE, cells_of, column, number, quantity, readable_unit, scales_of
from hydroservo.html_tables import Strong, html_heading, html_remarks, html_table
from hydroservo.linear.reading import READ, read_as
from hydroservo.metrics import Divergence
from hydroservo.runs.arguments import is_result
from hydroservo.runs.behaviour import behaviour
from hydroservo.runs.cautions import warnings_of
from hydroservo.runs.results import metric_fields, metrics_of, scenario_of
from hydroservo.runs.spreads import spreads_of
from hydroservo.runs.titles import controller_title

if TYPE_CHECKING:
    import xarray as xr


def card_of(data: "xr.Dataset") -> str:
    """A result at a glance; empty for what is none, or has no longer what a card shows.

    Args:
        data: what ``simulate``, ``simulate_batch`` or ``bode`` returned, or any other Dataset.
    """
    if not is_result(data):
        return ""
    if "frequency" in data.dims:
        return "" if "point" in data.dims or not set(READ) <= set(data.data_vars) else bode_card(data)
    if "diverged" not in data or not metric_fields(data):
        return ""
    return batch_card(data) if "run" in data.dims else run_card(data)


def run_card(data: "xr.Dataset") -> str:
    """A run: what was run, each metric in its unit, and whether it diverged."""
    rows = []
    for name, field in metric_fields(data).items():
        if name in Divergence._fields:  # which the verdict says
            continue
        value = data[name].values.item()
        rows.append((name, shown(value, field.unit), field.meaning))
    at = quantity(float(data["diverged_at"]), "s")
    lost = Strong(f"diverged at {at}, by {data.attrs.get('diverged_by', NONE)}")
    verdict = lost if bool(data["diverged"]) else "did not diverge"
    said = map(Strong, behaviour(metrics_of(data), metric_fields(data)))
    return (
        heading("run", data)
        + html_remarks([verdict, *said, *warnings_of(data)])
        + html_table(("metric", "value", "meaning"), rows)
    )


def shown(value: float | bool, unit: str) -> str:
    """A metric as it is read."""
    if isinstance(value, bool):
        return Strong("yes") if value else "no"
    return NONE if math.isnan(value) else Strong(quantity(value, unit))


def batch_card(data: "xr.Dataset") -> str:
    """Many runs: what varied, how each metric is spread, and how many diverged."""
    runs, lost = data.sizes["run"], int(data["diverged"].sum())
    varied = [name for name in map(str, data.data_vars) if "." in name]
    ranges = [range_row(data, name) for name in varied if runs]
    fields = metric_fields(data)
    found = {name: one for name, one in spreads_of(data).items() if name not in Divergence._fields}
    scales = scales_of((fields[name].unit, spread) for name, spread in found.items())
    spreads = []
    for name, spread in found.items():
        scale = scales[fields[name].unit]
        spreads.append((name, *cells_of(spread, scale), scale.label, fields[name].meaning))
    verdict = Strong(f"{lost:,} of {runs:,} runs diverged") if lost else f"none of {runs:,} runs diverged"
    return (
        heading(f"{runs:,} runs", data)
        + html_remarks([verdict, *warnings_of(data)])
        + html_table(("varied", "from", "to", "unit", "meaning"), ranges)
        + html_table(("metric", "5 %", "median", "95 %", "worst", "unit", "meaning"), spreads)
    )


def range_row(data: "xr.Dataset", name: str) -> tuple[str, ...]:
    """Between what a number varied."""
    values, about = data[name].values, data[name].attrs
    unit, ends = column([float(values.min()), float(values.max())], about.get("units", ""))
    return name, *ends, unit, about.get("long_name", "")


def bode_card(data: "xr.Dataset") -> str:
    """Frequency responses: margins and bandwidths."""
    rows = [
        (label, Strong(read_as(float(data[name]), unit, NONE)), data[name].attrs.get("long_name", ""))
        for name, (label, unit) in READ.items()
    ]
    verdict = [] if bool(data["stable"]) else [Strong("the loop is unstable here")]
    return (
        heading("frequency response", data)
        + html_remarks([*verdict, *warnings_of(data)])
        + html_table(("of the loop", "value", "meaning"), rows)
    )


def heading(what: str, data: "xr.Dataset") -> str:
    """What was run: its law, machine and demand, how long and how often."""
    tables = scenario_of(data)
    machine = ", ".join(kind(tables, name) for name in ("plant", "valve", "supply", "reference"))
    times = tables["simulation"]
    rate, factor = readable_unit("Hz", 1.0 / times["period"])
    lasting = f"{quantity(times['duration'], 's')} at {number(factor / times['period'])} {rate}"
    about = f"{machine}; {lasting}; {data.attrs['hash']}"
    return html_heading(f"{what}, {controller_title(data)}", about)


def kind(tables: dict[str, Any], name: str) -> str:
    """The type of a block."""
    return str(tables.get(name, {}).get("type", name))
