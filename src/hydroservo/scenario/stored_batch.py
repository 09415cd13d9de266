"""A batch of any number of runs, in parts that are simulated once and kept on disk."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from hydroservo.core.block import replace
from hydroservo.core.errors import HydroservoError, short
from hydroservo.core.validation import checked
from hydroservo.runs.arguments import checked_loop
from hydroservo.runs.batch import BatchOptions, loop_with_steps, simulate_part
from hydroservo.runs.cautions import with_warning
from hydroservo.runs.cautions.loop import loop_cautions
from hydroservo.runs.cautions.records import check_records
from hydroservo.runs.cautions.run import pressure_caution
from hydroservo.runs.columns import hardest_loop, number_per_run, start_columns
from hydroservo.runs.fitting import first_state
from hydroservo.runs.provenance import block_tables, canonical_toml, provenance, toml_of_json
from hydroservo.runs.results import arrow_table
from hydroservo.runs.run import complete_loop, runnable_loop
from hydroservo.runs.trace import plan_of
from hydroservo.scenario.build import ConstructorArgument
from hydroservo.scenario.load import Assembly
from hydroservo.scenario.parameter_draws import Columns, Drawn, Variation, check_size, draw_runs, drawn_ranges
from hydroservo.show.files import as_json
from hydroservo.work.cores import checked_count
from hydroservo.work.execution import do_units
from hydroservo.work.units import PARTS, Say, UnitStore, WorkUnit, manifest_in, unit_address

if TYPE_CHECKING:
    import pyarrow as pa

MANIFEST = "batch.json"
STEPS = 10**8  # integration steps of a part: some seconds of a core
LEAST, MOST = 2**8, 2**14  # runs of a part
MOST_IN_PARTS = 10**9  # runs; one column of their table takes 8 GB where it is used
CUDA_RUNS = 2**17  # of a part for a device, which takes as many at once


class Workers(NamedTuple):
    """Who computes the parts.

    Attributes:
        processes: of this machine; 1 is this process.
        scheduler: address of a Dask scheduler whose workers do it instead; None for none.
        threads: for each part; None for all cores.
    """

    processes: int | None = 1
    scheduler: str | None = None
    threads: int | None = None


class StoredBatch(NamedTuple):
    """A batch on disk.

    Attributes:
        table: of all runs, whose columns are read when they are used.
        computed: how many runs were not there before.
    """

    table: xr.Dataset
    computed: int


class SampledBatch(NamedTuple):
    """What all parts of a batch share.

    Attributes:
        assembly: the loop that all runs start from, and what it is made of.
        varied: what is drawn for each run.
        seed: of the draws.
        seeds: whether each run has random numbers of its own.
        strict: whether each operation is rounded by itself.
        cuda: whether a device computes.
    """

    assembly: Assembly
    varied: Sequence[Variation]
    seed: int
    seeds: bool
    strict: bool
    cuda: bool

    def drawn(self, first: int, runs: int) -> Drawn:
        """What some runs set."""
        return draw_runs(self.assembly, self.varied, runs, seed=self.seed, seeds=self.seeds, first=first)

    def ranges(self, runs: int) -> dict[str, tuple[float, float]]:
        """Both ends of what differs between so many runs."""
        return drawn_ranges(self.assembly, self.varied, runs, self.seeds)


def simulate_in_parts(
    sampled: SampledBatch,
    runs: int,
    folder: Path | str,
    *,
    workers: Workers = Workers(),  # noqa: B008, for it is a tuple
    size: int | None = None,
    progress: Callable[[float], None] | None = None,
    say: Say = lambda _: None,
) -> StoredBatch:
    """Simulate a batch part by part into a folder, from where it was left.

    Memory does not grow with the number of runs. Each row is that of one table of all runs, bit for bit,
    whatever the size of the parts and whoever computes them; that needs strict runs where processors differ.

    ::

        FOLDER/batch.json           what the batch is
        FOLDER/parts/KEY.parquet    the parameters and metrics of some runs; all of them are a dataset

    Args:
        sampled: what the runs start from, and what varies; its substeps may be automatic.
        runs: how many.
        folder: made if it is not there, else of the same batch.
        workers: who computes the parts.
        size: runs of a part; chosen if None.
        progress: called now and then with the fraction of parts done.
        say: is told what a user should know meanwhile, in a line each.

    Returns:
        The table, whose columns are read when they are used, and how many of its runs were computed now.

    Raises:
        HydroservoError: the folder holds another batch, or cannot be read or written.
        UnitsError: parts failed; the others are done.
        ParameterError, ScenarioError, LoopError: as :func:`~hydroservo.simulate_batch`.
    """
    check_size(runs, sampled.seed, most=MOST_IN_PARTS)
    asked = complete_loop(sampled.assembly.loop)
    sampled, about = with_chosen_steps(sampled, runs)
    loop = runnable_loop(sampled.assembly.loop)
    size = size or part_size(
        plan_of(loop, first_state(loop), ()).samples * loop.simulation.substeps, sampled.cuda
    )
    store = open_batch_store(
        Path(folder), {**batch_identity(sampled), **about, "runs": runs, "runs_of_a_part": size}
    )
    units, before = work_units(sampled, runs, size, workers), store.done()
    new = [i for i, unit in enumerate(units) if unit.key not in before]
    do_units(units, store, workers=workers.processes, scheduler=workers.scheduler, progress=progress, say=say)
    drawn = {"drawn_with_seed": sampled.seed, "varied": as_json(sampled.ranges(runs))}
    attrs = provenance(loop, asked) | about | drawn

    table = table_on_disk(store, [unit.key for unit in units], "run", runs, attrs)
    lines = [*check_records(loop), *loop_cautions(loop), pressure_caution(table)]
    return StoredBatch(with_warning(table, lines), sum(min(size, runs - i * size) for i in new))


def work_units(sampled: SampledBatch, runs: int, size: int, workers: Workers) -> list[WorkUnit]:
    shared, units = batch_identity(sampled), []
    for first in range(0, runs, size):
        count = min(size, runs - first)
        key = unit_address({**shared, "first": first, "count": count})
        does = partial(simulate_stored_part, sampled, first, count, workers.threads)
        units.append(WorkUnit(key, does, f"runs {first:,} to {first + count - 1:,}"))
    return units


def simulate_stored_part(sampled: SampledBatch, first: int, runs: int, threads: int | None) -> "pa.Table":
    """The table of some runs of a batch."""

    drawn = sampled.drawn(first, runs)
    how = BatchOptions(sampled.strict, checked_count(threads, "threads"), sampled.cuda)
    found = simulate_part(sampled.assembly.loop, drawn.parameters, first, how)
    table = table_of_runs(found, drawn, sampled.seed, sampled.assembly.arguments)
    return arrow_table(table.drop_attrs(deep=False).assign_attrs(found.attrs))


def with_chosen_steps(sampled: SampledBatch, runs: int) -> tuple[SampledBatch, dict[str, Any]]:
    """The batch with a number of substeps, and what is to be said of it, as of one table of all runs."""
    given = checked_loop(sampled.assembly.loop)
    loop = runnable_loop(given)
    check_records(loop)
    first_state(loop)
    whole = checked(given)

    def started() -> Iterator[Columns]:
        for first in range(0, runs, MOST):
            drawn = sampled.drawn(first, min(MOST, runs - first))
            columns = {path: number_per_run(path, values) for path, values in drawn.parameters.items()}
            yield columns | start_columns(whole, columns, first)

    chosen, said = loop_with_steps(loop, hardest_loop(loop, started()), sampled.strict)
    steps = {"simulation.substeps": chosen.simulation.substeps}
    return sampled._replace(assembly=sampled.assembly._replace(loop=replace(given, steps))), said


def part_size(steps: int, cuda: bool) -> int:
    """How many runs a part has."""
    if cuda:
        return CUDA_RUNS
    return min(MOST, max(LEAST, 1 << (max(1, STEPS // steps).bit_length() - 1)))


def batch_identity(sampled: SampledBatch) -> dict[str, Any]:
    """All that the rows of a batch depend on, but for which runs they are."""
    assembly = sampled.assembly
    found = {
        "scenario": canonical_toml(runnable_loop(assembly.loop)),
        "metrics": toml_of_json(json.dumps(block_tables(assembly.loop.metrics))),
        "vary": [[one.path, one.low, one.high, one.nominal] for one in sampled.varied],
        "seed": sampled.seed,
        "seeds": sampled.seeds,
        "strict": sampled.strict,
        "cuda": sampled.cuda,
    }
    if any(one.path in assembly.arguments for one in sampled.varied):
        found["constructors"] = {path: repr(one.value) for path, one in assembly.arguments.items()}
        found["truth"] = {path: repr(one[-2:]) for path, one in assembly.truth.arguments.items()}
    return found


def open_batch_store(folder: Path, content: Mapping[str, Any]) -> UnitStore:
    """The folder of a batch, which goes on if there is something of it."""
    wanted = json.loads(json.dumps(content))
    found = manifest_in(folder, MANIFEST)
    if found is None or not any((folder / PARTS).glob("*.parquet")):
        return UnitStore(folder, MANIFEST, content)
    for name in wanted:
        if found.get(name) != wanted[name]:
            theirs, ours = short(found.get(name)), short(wanted[name])
            other = f"another {name}" if theirs == ours else f"{name} {theirs}, and not {ours}"
            raise HydroservoError(f"{folder / MANIFEST}: belongs to a batch with {other}; give another --out")
    return UnitStore(folder, MANIFEST, content)


def table_of_runs(
    found: xr.Dataset, drawn: Drawn, seed: int, arguments: Mapping[str, ConstructorArgument]
) -> xr.Dataset:
    """The table of a batch, with all that it takes to run each of its runs again."""
    deviations = {
        f"uncertainty.{path}": ("run", column, {"units": "", "long_name": f"relative deviation of {path}"})
        for path, column in drawn.deviations.items()
    }
    taken = {
        path: ("run", column, {"units": field.unit, "long_name": field.meaning})
        for path, column in drawn.values.items()
        if path in arguments and (field := arguments[path].field)
    }
    made = [path for path in drawn.parameters if path not in drawn.values]
    about = {"drawn_with_seed": seed, "varied": as_json(drawn.ranges)}
    table = found.drop_vars(made).assign(taken | deviations).assign_attrs(about)
    return table[[*drawn.values, *deviations, *(name for name in found if name not in drawn.parameters)]]


def table_on_disk(
    store: UnitStore, keys: Sequence[str], index: str, rows: int, about: Mapping[str, Any]
) -> xr.Dataset:
    """The parts of a store as one table, of which nothing is in memory.

    Each use of a column reads it anew: memory holds what is in use.
    """
    schema = store.read(keys[0]).schema
    columns = {
        field.name: xr.Variable(
            (index,),
            indexing.LazilyIndexedArray(StoredColumn(store, keys, field.name, rows, numpy_kind(field.type))),
            {name.decode(): text.decode() for name, text in (field.metadata or {}).items()},
        )
        for field in schema
        if field.name != index
    }
    return xr.Dataset(columns, attrs=dict(about))


class StoredColumn(BackendArray):
    """A column of a store's parts, as xarray reads what is on disk."""

    def __init__(
        self, store: UnitStore, keys: Sequence[str], name: str, rows: int, kind: "np.dtype[Any]"
    ) -> None:
        self.store, self.keys, self.name = store, keys, name
        self.shape, self.dtype = (rows,), kind

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.VECTORIZED, self.rows
        )

    def rows(self, key: Any) -> NDArray[Any]:
        """Some rows of it."""
        found = self.store.table(self.keys, [self.name]).column(self.name).to_numpy()
        chosen: NDArray[Any] = found.astype(self.dtype, copy=False)[key]
        return chosen


def numpy_kind(arrow: Any) -> "np.dtype[Any]":
    """Which numpy type a column of Arrow is read as."""
    kind: np.dtype[Any] = np.dtype(arrow.to_pandas_dtype())
    return kind
