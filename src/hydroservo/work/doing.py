"""Does the units that are not done yet: here, in processes, or on a cluster."""

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from threading import Event

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError, clipped
from hydroservo.work.cores import checked_count
from hydroservo.work.processes import in_processes
from hydroservo.work.store import Store
from hydroservo.work.unit import Answer, Failure, Say, Unit, answer_to

MOST_SAID = 10  # failures that are said as they happen


class UnitsError(HydroservoError):
    """Some units failed; the others are done."""


def do(
    units: Sequence[Unit],
    store: Store,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[float], None] | None = None,
    say: Say = lambda _: None,
    stop: Event | None = None,
) -> None:
    """Do the units that are not done, and keep what they come to.

    What is done is kept whatever happens, and the same call goes on from there. Neither where nor by how many
    units are done changes a bit of a part, nor does a worker that dies: its unit is done again.

    Args:
        units: what is to be done; those of one address once.
        store: where their tables are kept.
        workers: processes of this machine; with 1 it is this process, with None one for each core.
        scheduler: address of a Dask scheduler, whose workers do it instead, such as ``tcp://head:8786``. They
            need hydroservo of the same version, and no folder.
        progress: called now and then with the fraction of units done.
        say: is told, in a line each, of damaged parts, of workers that ended, and of the first units that
            failed.
        stop: once it is set, no more is done.
    """
    count = checked_count(workers, "workers")
    for part in store.damaged:
        say(f"{part}: is damaged, and done again if it is needed")
    done = store.done()
    left = list({unit.key: unit for unit in units if unit.key not in done}.values())
    failures = []
    with closing(answers(left, count, scheduler, say)) as found:
        for number, (unit, answer) in enumerate(found, len(units) - len(left) + 1):
            if isinstance(answer, Failure):
                failures.append(failed(unit, answer))
                if len(failures) <= MOST_SAID:
                    say(failures[-1])
            else:
                store.write(unit.key, answer)
            if progress is not None:
                progress(number / len(units))
            if stop is not None and stop.is_set():
                break
    if failures:
        raise UnitsError(f"{len(failures):,} of {len(units):,} units failed, such as {clipped(failures[0])}")


def answers(
    units: Sequence[Unit], workers: int, scheduler: str | None, say: Say
) -> Generator[tuple[Unit, Answer]]:
    """What each unit came to, as they are done."""
    if not units:
        return
    if scheduler is not None:
        from hydroservo.work.cluster import on_scheduler

        yield from on_scheduler(units, scheduler, say)
    elif workers == 1:
        for unit in units:
            yield unit, answer_to(unit.do, __version__)
    else:
        yield from in_processes(units, min(workers, len(units)), say)


def failed(unit: Unit, failure: Failure) -> str:
    """What is to be said of a unit that failed."""
    if failure.defect:
        raise RuntimeError(f"{unit.name}: {failure.text}")
    return f"{unit.name}: {failure.text}"
