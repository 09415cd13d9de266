"""The runs of a batch: what is drawn for each, one of them alone, and loops that differ in one number."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hydroservo.control.loop import Loop
from hydroservo.control.wiring import wired
from hydroservo.core.block import field_at, leaves, replace, value_at
from hydroservo.core.command_scale import commands_in
from hydroservo.core.errors import ParameterError, ScenarioError
from hydroservo.core.validation import checked, whole_number
from hydroservo.runs.arguments import checked_loop, checked_mapping, checked_table
from hydroservo.runs.columns import SEED
from hydroservo.runs.provenance import scenario_hash
from hydroservo.runs.run import complete_loop
from hydroservo.scenario.datasheets import made_columns
from hydroservo.scenario.load import Assembly, MachineBlocks, assemble, load_scenario
from hydroservo.scenario.other_tables import Truth
from hydroservo.scenario.ranges import as_entries, both_ends, check_path
from hydroservo.scenario.tables import TableEntry
from hydroservo.scenario.tune_table import SearchSettings

if TYPE_CHECKING:
    import xarray as xr

MOST = 10_000_000  # runs; their table alone takes 2 GB
LARGEST_SEED = 2**63 - 1
BLOCK = 4  # numbers that Philox4x64 makes of each value of its counter

Numbers = NDArray[np.float64]
Columns = Mapping[str, NDArray[Any]]  # arrays of shape (runs,) by path


class Variation(NamedTuple):
    """A number that is drawn evenly between two values, in SI units."""

    path: str
    low: float
    high: float
    nominal: float | None  # what a parameter of the machine deviates from; None where it has no such value
    entry: TableEntry  # where that is said


class Drawn(NamedTuple):
    """What the runs of a batch do not share.

    Attributes:
        parameters: in SI units by the path in the loop: what :func:`~hydroservo.simulate_batch` takes.
        values: in SI units by the path that was asked for, which may be one that a constructor takes.
        deviations: from the nominal value, relative, by the path of a number of the machine.
        ranges: both ends, in SI units, by the path that was asked for.
    """

    parameters: Columns
    values: Columns
    deviations: Columns
    ranges: Mapping[str, tuple[float, float]]

    def changes(self, run: int) -> dict[str, float]:
        """What :func:`~hydroservo.scenario.load_scenario` and ``--set`` take to make the loop of one run.

        Numbers of the machine are set as its truth, in which nobody else believes.
        """
        return {
            f"truth.{path}" if path.partition(".")[0] in MachineBlocks._fields else path: values[run].item()
            for path, values in self.values.items()
        }


def draws(
    source: Loop | Assembly,
    ranges: Mapping[str, str | tuple[float, float]],
    runs: int,
    *,
    seed: int = 0,
    seeds: bool = False,
) -> Drawn:
    """Draw the numbers in which the runs of a batch differ, evenly between two values::

        drawn = draws(loop, {"plant.mass": relative(-0.3, 0.3), "load.offset": (-50.0, 50.0)}, runs=1000)
        table = simulate_batch(loop, drawn.parameters)

    A number is a function of the seed, its path and the number of the run alone: run i is the same whatever
    the number of runs and whatever else varies. Those of the machine (plant, valve, supply, load) are its
    truth: the controller goes on believing in the nominal machine.

    Args:
        source: the loop, or what :func:`~hydroservo.scenario.assemble` makes of a scenario. Relative ranges
            are around the values that the loop has; of a scenario around those before its ``[uncertainty]``
            and ``[truth]``, and what its constructors take may vary too.
        ranges: by path two numbers in SI units, ``hs.relative(low, high)``, or a text as ``--vary`` takes
            it, such as ``"4..8 kg"`` or ``"-30%..+30%"``.
        runs: how many.
        seed: of the draws.
        seeds: whether each run has random numbers of its own: the seed of the loop plus the run's number.

    Returns:
        What the runs do not share; its ``parameters`` are what :func:`~hydroservo.simulate_batch` takes.

    Raises:
        ScenarioError: the path of no number that can vary, or no range of it.
        ParameterError: a number of runs or a seed out of its range, or nothing varies.

    Source: Philox4x64-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    ranges = checked_mapping("ranges", ranges, "paths to ranges")
    if not ranges and not seeds:
        raise ParameterError("ranges", "{}", "must name a number that varies, or seeds be True")
    check_size(runs, seed)
    whole = assembly_of_loop(source)
    return draw_runs(whole, variations(whole, as_entries(ranges)), runs, seed=seed, seeds=seeds)


def run_of(loop: Loop, table: "xr.Dataset", run: int) -> Loop:
    """The loop of one run of a batch, to be simulated alone and with its trajectory.

    ``simulate(run_of(loop, table, i), strict=True)`` has the bits of run i of a strict batch.

    Args:
        loop: the loop that the batch started from.
        table: what :func:`~hydroservo.simulate_batch` returned.
        run: its number, from 0 on.

    Raises:
        ParameterError: there is no such run, or the table is that of another loop.
    """
    asked, table = complete_loop(loop), checked_table(table)
    whole_number("run", run, 0, table.sizes["run"] - 1)
    steps = {"simulation.substeps": table.attrs["substeps"]} if "substeps" in table.attrs else {}
    own = scenario_hash(asked)
    if table.attrs["hash"] != own:
        raise ParameterError("table", f"hash {table.attrs['hash']}", f"must be of this loop, with hash {own}")
    parameters = {path: table[path].values[run].item() for path, _ in leaves(asked) if path in table}
    found: Loop = replace(asked, parameters | steps)
    return found


def assembly_of_loop(source: Loop | Assembly) -> Assembly:
    """A loop as if a scenario had described it, with nothing but its numbers."""
    if isinstance(source, Assembly):
        return source
    loop = wired(checked(checked_loop(source, "source")))
    machine = MachineBlocks(*(getattr(loop, name) for name in MachineBlocks._fields))
    return Assembly(loop, machine, {}, Truth({}, {}), {}, SearchSettings())


def variations(assembly: Assembly, ranges: Mapping[str, TableEntry]) -> list[Variation]:
    """What is asked to vary."""
    return [variation_at(assembly, path, entry) for path, entry in ranges.items()]


def variation_at(assembly: Assembly, path: str, entry: TableEntry) -> Variation:
    """A number that is asked to vary."""
    loop, arguments = assembly.loop, assembly.arguments
    check_path(path, entry, loop, arguments)
    nominal = loop._replace(**assembly.nominal._asdict())
    field, middle = arguments.get(path) or (field_at(loop, path), float(value_at(nominal, path)))
    with commands_in(loop.command):
        low, high = both_ends(entry, field, middle)
    known = middle not in (0.0, field.auto)
    machine = path.partition(".")[0] in MachineBlocks._fields
    return Variation(path, low, high, middle if machine and known else None, entry)


def draw_runs(
    assembly: Assembly,
    varied: Sequence[Variation],
    runs: int,
    *,
    seed: int = 0,
    seeds: bool = False,
    first: int = 0,
) -> Drawn:
    """As :func:`draws`, of what :func:`variations` made, for the runs from number ``first`` on."""
    values: dict[str, NDArray[Any]] = {}
    deviations: dict[str, NDArray[Any]] = {}
    for one in varied:
        values[one.path], relative = draw_values(one, uniform_numbers(seed, one.path, runs, first))
        if relative is not None:
            deviations[one.path] = relative
    if seeds:
        values[SEED] = assembly.loop.simulation.seed + np.arange(first, first + runs)
    ranges = drawn_ranges(assembly, varied, first + runs, seeds)
    return Drawn(loop_parameters(assembly, varied, values, first), values, deviations, ranges)


def drawn_ranges(
    assembly: Assembly, varied: Sequence[Variation], runs: int, seeds: bool
) -> dict[str, tuple[float, float]]:
    """Both ends of what differs between the runs of a batch, in SI units, by path."""
    ranges = {one.path: (one.low, one.high) for one in varied}
    own = assembly.loop.simulation.seed
    return ranges | ({SEED: (own, own + runs - 1)} if seeds else {})


def check_size(runs: int, seed: int, start: str = "", most: int = MOST) -> None:
    """Refuse a number of runs or a seed out of its range."""
    whole_number(f"{start}runs", runs, 1, most)
    whole_number(f"{start}seed", seed, 0, LARGEST_SEED)


def draw_values(one: Variation, u: Numbers) -> tuple[Numbers, Numbers | None]:
    """The value of each run, and its relative deviation where there is a nominal value."""
    if one.nominal is None:
        return np.minimum(one.low + (one.high - one.low) * u, one.high, dtype=np.float64), None
    first, last = one.low / one.nominal - 1.0, one.high / one.nominal - 1.0
    deviations = first + (last - first) * u
    return one.nominal * (1.0 + deviations), deviations


def loop_parameters(
    assembly: Assembly,
    varied: Sequence[Variation],
    values: Columns,
    first: int = 0,
    always: Collection[str] = (),
) -> Columns:
    """The numbers of the loop that follow from those drawn: these, or what constructors make of them.

    Of the latter only those that are not the loop's own in all runs, and those of the paths ``always``.
    """
    taken = {path: column for path, column in values.items() if path in assembly.arguments}
    own = {path: column for path, column in values.items() if path not in taken}
    if not taken:
        return own
    origin, made = varied[0].entry.origin.name, made_columns(assembly, taken, first, always)
    if not made:
        problem = "changes nothing: no number of the loop follows from it here"
        raise ScenarioError(origin, ", ".join(taken), problem)
    for path in made:
        if path in own:
            causes = causes_of(assembly, taken, path, first)
            verb = "varies" if len(causes) == 1 else "vary"
            raise ScenarioError(origin, path, f"follows from {' and '.join(causes)}, which {verb} too")
    return {**own, **made}


def causes_of(assembly: Assembly, taken: Columns, path: str, first: int) -> list[str]:
    """Which of the varied constructor arguments change a number; all of its block's if none does alone."""
    above = [name for name in taken if name.partition(".")[0] == path.partition(".")[0]]
    causes = []
    for name in above:
        with suppress(ScenarioError):  # of numbers that go together with others alone
            causes += [name] if path in made_columns(assembly, {name: taken[name]}, first) else []
    return causes or above


def uniform_numbers(seed: int, path: str, runs: int, first: int = 0) -> Numbers:
    """Numbers in [0, 1) that are functions of the seed, the path and the number of the run, from one on.

    Source: Philox4x64-10, Salmon, Moraes, Dror, Shaw 2011, doi:10.1145/2063384.2063405.
    """
    stream = int.from_bytes(sha256(path.encode()).digest()[:8], "little")
    block, skipped = divmod(first, BLOCK)
    philox = np.random.Philox(key=np.array([seed, stream], dtype=np.uint64), counter=block)
    bits = philox.random_raw(skipped + runs)[skipped:]
    return np.ldexp((bits >> np.uint64(11)).astype(np.float64), -53)


def loops_over(
    source: str,
    path: str,
    entry: TableEntry,
    count: int,
    changes: Mapping[str, object],
    plugins: Sequence[Path],
    load: Callable[[str, Mapping[str, object], Sequence[Path]], Loop] = load_scenario,
) -> tuple[dict[float, Loop], str]:
    """The loops of a scenario by values of a number, and its SI unit; a law believes what it believed."""
    whole = assemble(source, changes, plugins)
    ends = variation_at(whole, path, entry)
    field = whole.arguments[path].field if path in whole.arguments else field_at(whole.loop, path)
    name = f"truth.{path}" if path.partition(".")[0] in MachineBlocks._fields else path
    values = np.linspace(ends.low, ends.high, count).tolist()
    return {value: load(source, {**changes, name: value}, plugins) for value in values}, field.unit
