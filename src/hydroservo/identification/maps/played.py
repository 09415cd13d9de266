"""A measured characteristic in the valve of a scenario."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.core.errors import HydroservoError, ScenarioError
from hydroservo.core.formatting import plain_quantity
from hydroservo.core.hooks import line_pressures
from hydroservo.identification.maps.result import Interval
from hydroservo.scenario.load import assemble
from hydroservo.scenario.scenario_files import nest_changes

if TYPE_CHECKING:
    import xarray as xr

PLAYED = 0.01  # of the largest flow, within which the written valve has the table's
OTHER = 30.0  # times the flow of the scenario's valve, beyond which a unit is wrong
BEYOND = 1.05  # times the table's end, to which a valve may open without a remark
LAPS = ("lap", "extra_lap_pa", "extra_lap_at", "extra_lap_pb", "extra_lap_bt")
KEPT = ("discharge_coefficient", "density", "transition_drop", "area_ratio_b")


def played_curve(
    table: "xr.Dataset", hysteresis: Interval | None, loop: Loop | None
) -> tuple[dict[str, Any], list[str]]:
    """The changes with which a scenario's valve plays a table, and why there are none.

    The flow at half of the supply's drop is that of ``FourEdges.rated`` at the whole of it as rated drop. Its
    rated opening is that at the nearer end of the table.
    """
    if loop is None:
        return {}, []
    if "flow" not in table:
        return {}, ["a speed has the load and the areas in it: the scenario's valve stays as it is"]
    if not has_edges(loop):
        return {}, [f"{type(loop.valve).__name__} has no gain and edges that would play the table"]
    if getattr(loop.valve.orifice, "regeneration", False):
        return {}, ["a regenerative valve does not pass the table's flow at port A: its edges stay"]
    valve: Any = loop.valve
    edges = valve.orifice
    command, flow = table["command"].values, table["flow"].values
    full = float(min(-command[0], command[-1]))
    if full <= 0.0:
        return {}, ["the table has one sign of the command only, and a valve's curve needs both"]
    line = line_pressures(loop)
    shares = zip((100.0 * command / full).tolist(), flow.tolist(), strict=True)
    orifice = {
        "type": "FourEdges.rated",
        "rated_flow": "auto",
        "rated_drop": f"{line.supply - line.tank!r} Pa",
        "rated_opening": f"{valve.gain * full!r} m",
        "flow_curve": {"points": [[f"{share!r} %", f"{q!r} m^3/s"] for share, q in shares]},
        **{name: float(value) for name, value in edges._asdict().items() if name in KEPT},
        **{name: 0.0 for name, value in edges._asdict().items() if name in LAPS and value},
    }
    changes: dict[str, Any] = {"valve.orifice": orifice}
    if hysteresis is not None and hasattr(valve, "hysteresis"):
        changes["valve.hysteresis"] = hysteresis.value * valve.gain
    ends = plain_quantity(full, "V")
    opens = valve.max_opening / valve.gain
    beyond = f"the table ends at {ends}, beyond which the written valve opens no further"
    return changes, [beyond] if opens > BEYOND * full else []


def tables_with_curve(
    scenario: str | Path,
    changes: Mapping[str, object],
    plugins: Sequence[str | Path],
    found: Mapping[str, Any],
    table: "xr.Dataset",
) -> tuple[dict[str, Any], list[str]]:
    """The tables of a scenario whose valve plays a table; those without, and why, where it cannot."""
    own = {**changes, **found}
    try:
        loop = assemble(scenario, own, plugins).loop
        check_played(loop, table)
    except HydroservoError as error:
        return nest_changes(changes), [f"the scenario is written without the table: {error}"]
    return nest_changes(own), []


def check_played(loop: Loop, table: "xr.Dataset") -> None:
    """Refuse a valve that does not pass the table's flows."""
    flow, passed = table["flow"].values, passed_flows(loop, table)
    apart = np.abs(passed - flow)
    worst = int(apart.argmax())
    if apart[worst] > PLAYED * np.abs(flow).max():
        at = plain_quantity(float(table["command"].values[worst]), "V")
        has, wants = (plain_quantity(float(one[worst]), "m^3/s") for one in (passed, flow))
        raise HydroservoError(f"its valve would pass {has} at {at}, and the table has {wants}")


def check_size(table: "xr.Dataset", loop: Loop | None, name: str) -> None:
    """Refuse flows so far from those of the scenario's valve that a unit must be wrong."""
    if loop is None or "flow" not in table or not has_edges(loop):
        return
    flow, passed = (float(np.abs(one).max()) for one in (table["flow"].values, passed_flows(loop, table)))
    if not passed / OTHER < flow < passed * OTHER:
        has, wants = (plain_quantity(one, "m^3/s") for one in (flow, passed))
        problem = f"gives a flow of {has}, where the scenario's valve passes {wants}: is its unit right?"
        raise ScenarioError(name, "velocity or position", problem)


def has_edges(loop: Loop) -> bool:
    """Whether a loop's valve is one of edges that a spool opens in proportion to its command."""
    return hasattr(loop.valve, "gain") and hasattr(getattr(loop.valve, "orifice", None), "flow")


def passed_flows(loop: Loop, table: "xr.Dataset") -> NDArray[np.float64]:
    """The flows of a loop's valve at half of its supply's drop, at the commands of a table [m^3/s]."""
    valve: Any = loop.valve
    line = line_pressures(loop)
    drop = line.supply - line.tank
    return np.array([valve.orifice.flow(valve.gain * u, drop, 0.0) for u in table["command"].values.tolist()])
