"""Static maps of a machine from logs of it."""

from collections.abc import Iterator, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any

from hydroservo.control.loop import Loop
from hydroservo.core.command_scale import VOLTS, commands_in
from hydroservo.core.errors import ParameterError, one_of
from hydroservo.core.formatting import plain_quantity
from hydroservo.core.hooks import line_pressures
from hydroservo.identification.log import COMMAND, EXTERNAL_FORCE, TIME, LogSource, log_mapping, read_logs
from hydroservo.identification.log_check import check_balance, check_positions, check_pressures, stroke_of
from hydroservo.identification.maps.characteristic import characteristic_map
from hydroservo.identification.maps.decay import decay_map
from hydroservo.identification.maps.friction import friction_map
from hydroservo.identification.maps.piston import piston_of
from hydroservo.identification.maps.played import tables_with_curve
from hydroservo.identification.maps.pressure_gain import pressure_gain_map
from hydroservo.identification.maps.result import Interval, MapContents, StaticMap
from hydroservo.identification.maps.valve_flow import valve_flow_map
from hydroservo.identification.result import Estimate, tables_or_remark
from hydroservo.identification.segments import UnderstoodLog, understand_log
from hydroservo.scenario.load import Assembly, assemble
from hydroservo.scenario.scenario_files import nest_changes


class MapKind(StrEnum):
    """The maps that there are."""

    VALVE_FLOW = "valve-flow"
    CHARACTERISTIC = "characteristic"
    PRESSURE_GAIN = "pressure-gain"
    FRICTION = "friction"
    DECAY = "decay"


def map_logs(
    kind: str,
    logs: LogSource | Sequence[LogSource],
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
            ``characteristic``, from those or from stairs of the command, for a valve of any curve;
            ``pressure-gain``, from slow sweeps with blocked ports; ``friction``, from moves at constant
            speed; ``decay``, of pressures in blocked ports, for leakage and bulk modulus.
        logs: one or several: files (CSV, Parquet, MATLAB, NetCDF, HDF5, MDF, TDMS), or mappings of ``time``,
            ``command`` and measured signals to arrays of shape (n,) in SI units. Friction and decay need no
            command.
        scenario: whose areas, volumes and supply count, by name or path; its table ``[identify.columns]``
            says which column of a log holds which signal. A pressure gain, a characteristic of speed, and
            friction from the hydraulic force need none.
        changes: values by dotted path that override those of the scenario.
        plugins: Python files with blocks that it names; they are executed.

    Returns:
        The curve with scatter and intervals, the numbers that it gives, and a scenario with these.

    Raises:
        ScenarioError: in one line, the log or scenario, and what is wrong there: a signal is missing, a sweep
            is too fast, nothing moves at constant speed, nothing decays.
        ParameterError: an argument is not what it must be.

    Source: as the function of each kind has it.
    Fails where the machine is not in the steady state that a map supposes; each kind says what it needs.
    """
    if kind not in [*MapKind]:
        raise ParameterError("kind", kind, one_of(str(kind), [*map(str, MapKind)]))
    if scenario is None and (changes or plugins):
        raise ParameterError("changes" if changes else "plugins", changes or plugins, "need a scenario")
    assembly = None if scenario is None else assemble(scenario, changes, plugins)
    needed = () if kind in (MapKind.FRICTION, MapKind.DECAY) else (COMMAND,)
    with commands_in(VOLTS if assembly is None else assembly.loop.command):
        mapping = log_mapping({} if assembly is None else assembly.log_columns)
        given = [logs] if isinstance(logs, str | Path | Mapping) else list(logs)
        recorded = read_logs(given, mapping, (TIME, *needed))
    taken = [understand_log(log, i) for i, log in enumerate(recorded)]
    found = measure_map(MapKind(kind), taken, assembly, str(scenario))
    load = () if assembly is None or kind != MapKind.FRICTION else load_remarks(taken, assembly.loop)
    remarks = list(dict.fromkeys([*load, *(line for log in taken for line in log.remarks), *found.remarks]))
    tables: dict[str, Any] = nest_changes(changes or {})
    if scenario is not None and found.values:
        tables, problems = tables_or_remark(
            scenario, changes or {}, plugins, estimates_of_values(found.values)
        )
        remarks += problems
    if scenario is not None and found.characteristic is not None and found.changes:
        tables, problems = tables_with_curve(
            scenario, changes or {}, plugins, found.changes, found.characteristic
        )
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
        found.characteristic,
    )


def measure_map(
    kind: MapKind, logs: Sequence[UnderstoodLog], assembly: Assembly | None, scenario: str
) -> MapContents:
    """What a kind of map finds."""
    loop: Loop | None = None if assembly is None else assembly.loop
    piston = None if loop is None else piston_of(loop.plant, scenario)
    if kind == MapKind.PRESSURE_GAIN:
        return pressure_gain_map(logs, loop, piston)
    if kind != MapKind.DECAY:
        check_balance(logs, loop, driven=kind != MapKind.FRICTION)
    if kind == MapKind.FRICTION:
        return friction_map(logs, loop, piston)
    if loop is not None:
        check_positions(logs, stroke_of(loop.plant))
        check_pressures(logs, line_pressures(loop).supply)
    if kind == MapKind.CHARACTERISTIC:
        return characteristic_map(logs, loop, piston)
    if loop is None or piston is None:
        raise ParameterError("scenario", "none", f"a {kind} map needs one, for areas, volumes and supply")
    return valve_flow_map(logs, loop, piston) if kind == MapKind.VALVE_FLOW else decay_map(logs, piston)


def load_remarks(logs: Sequence[UnderstoodLog], loop: Loop) -> Iterator[str]:
    """That the scenario's load is taken off where no log has one of its own."""
    measured = {name for log in logs for name in log.log.signals}
    forces = [loop.load.force(t) for log in logs for t in log.log.time[:: max(log.log.time.size // 100, 1)]]
    if not measured & {EXTERNAL_FORCE, "force"} and any(forces):
        most = plain_quantity(max(forces, key=abs), "N")
        yield f"the scenario's load, up to {most}, counts as acting on the rod: the log has no external_force"


def estimates_of_values(values: Mapping[str, Interval]) -> dict[str, Estimate]:
    """Numbers of a scenario, of which those with an interval are uncertain."""
    return {
        path: Estimate(one.value, one.low, one.high, one.high > one.low, 1.0, False, one.unit, one.meaning)
        for path, one in values.items()
    }
