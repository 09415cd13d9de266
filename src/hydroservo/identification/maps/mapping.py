"""Static maps of a machine from logs of it."""

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.command_scale import VOLTS, commands_in
from hydroservo.core.errors import ParameterError
from hydroservo.core.formatting import MINUS, quantity
from hydroservo.core.nearest import one_of
from hydroservo.identification.log import COMMAND, EXTERNAL_FORCE, Given, log_mapping
from hydroservo.identification.log_check import check_balance, check_positions, stroke_of
from hydroservo.identification.maps.decay import decay
from hydroservo.identification.maps.friction import friction
from hydroservo.identification.maps.pressure_gain import pressure_gain
from hydroservo.identification.maps.reading import logs_of, piston_of
from hydroservo.identification.maps.result import Found, Interval, StaticMap
from hydroservo.identification.maps.valve_flow import valve_flow
from hydroservo.identification.result import Estimate, tables_or_remark
from hydroservo.identification.segments import Understood
from hydroservo.scenario.load import Assembly, assemble
from hydroservo.scenario.scenario_files import nest_changes


class Kind(StrEnum):
    """The maps that there are."""

    VALVE_FLOW = "valve-flow"
    PRESSURE_GAIN = "pressure-gain"
    FRICTION = "friction"
    DECAY = "decay"


def map_logs(
    kind: str,
    logs: Given | Sequence[Given],
    scenario: str | Path | None = None,
    *,
    changes: Mapping[str, object] | None = None,
    plugins: Sequence[str | Path] = (),
) -> StaticMap:
    """A static map of a machine from logs, as ``hydroservo map`` measures it::

        found = hs.map_logs("valve-flow", "sweep.csv", "axis.toml")
        found.numbers["dead_band"].low

    Args:
        kind: ``valve-flow``, from slow sweeps of the command with a piston that moves freely;
            ``pressure-gain``, from slow sweeps with blocked ports; ``friction``, from moves at constant
            speed; ``decay``, of pressures in blocked ports, for leakage and bulk modulus.
        logs: one or several: files (CSV, Parquet, MATLAB, NetCDF, HDF5, MDF, TDMS), or mappings of ``time``,
            ``command`` and measured signals to arrays of shape (n,) in SI units. Friction and decay need no
            command.
        scenario: whose areas, volumes and supply count, by name or path; its table ``[identify.columns]``
            says which column of a log holds which signal. A pressure gain, and friction from the hydraulic
            force, need none.
        changes: values by dotted path that override those of the scenario.
        plugins: Python files with blocks that it names; they are executed.

    Returns:
        The curve with scatter and intervals, the numbers that it gives, and a scenario with these.

    Raises:
        ScenarioError: in one line, the log or scenario, and what is wrong there: a signal is missing, a sweep
            is too fast, nothing moves at constant speed, nothing decays.
        ParameterError: an argument is not what it must be.

    Source: see the four functions in ``hydroservo.identification.maps``.
    Fails where the machine is not in the steady state that a map supposes; each kind says what it needs.
    """
    if kind not in [*Kind]:
        raise ParameterError("kind", kind, one_of(str(kind), [*map(str, Kind)]))
    if scenario is None and (changes or plugins):
        given = "changes" if changes else "plugins"
        raise ParameterError(given, changes or plugins, "need a scenario")
    assembly = None if scenario is None else assemble(scenario, changes, plugins)
    needed = (COMMAND,) if kind in (Kind.VALVE_FLOW, Kind.PRESSURE_GAIN) else ()
    with commands_in(VOLTS if assembly is None else assembly.loop.command):
        taken = logs_of(logs, log_mapping({} if assembly is None else assembly.log_columns), needed)
    found = measured(Kind(kind), taken, assembly, str(scenario))
    load = () if assembly is None or kind != Kind.FRICTION else load_taken(taken, assembly.loop)
    remarks = list(dict.fromkeys([*load, *(line for log in taken for line in log.remarks), *found.remarks]))
    tables: dict[str, Any] = nest_changes(changes or {})
    if scenario is not None and found.values:
        tables, problems = tables_or_remark(scenario, changes or {}, plugins, estimates(found.values))
        remarks += problems
    return StaticMap(
        str(kind),
        "" if scenario is None else str(scenario),
        [log.log.name for log in taken],
        found.curve,
        found.numbers,
        found.lines,
        remarks,
        tables,
        found.undetermined,
        None if assembly is None else assembly.loop,
    )


def measured(kind: Kind, logs: Sequence[Understood], assembly: Assembly | None, scenario: str) -> Found:
    """What a kind of map finds."""
    loop: Loop | None = None if assembly is None else assembly.loop
    piston = None if loop is None else piston_of(loop.plant, scenario)
    if kind == Kind.PRESSURE_GAIN:
        return pressure_gain(logs, loop, piston)
    if kind != Kind.DECAY:
        check_balance(logs, loop, driven=kind == Kind.VALVE_FLOW)
    if kind == Kind.FRICTION:
        return friction(logs, loop, piston)
    if loop is None or piston is None:
        raise ParameterError("scenario", "none", f"a {kind} map needs one, for areas, volumes and supply")
    check_positions(logs, stroke_of(loop.plant))
    return valve_flow(logs, loop, piston) if kind == Kind.VALVE_FLOW else decay(logs, piston)


def load_taken(logs: Sequence[Understood], loop: Loop) -> Iterator[str]:
    """That the scenario's load is taken off where no log has one of its own."""
    measured = {name for log in logs for name in log.log.signals}
    forces = [loop.load.force(t) for log in logs for t in log.log.time[:: max(log.log.time.size // 100, 1)]]
    if not measured & {EXTERNAL_FORCE, "force"} and any(forces):
        most = quantity(max(forces, key=abs), "N").replace(MINUS, "-")
        yield f"the scenario's load, up to {most}, counts as acting on the rod: the log has no external_force"


def estimates(values: Mapping[str, Interval]) -> dict[str, Estimate]:
    """Numbers of a scenario, of which those with an interval are uncertain."""
    return {
        path: Estimate(one.value, one.low, one.high, one.high > one.low, 1.0, False, one.unit, one.meaning)
        for path, one in values.items()
    }
