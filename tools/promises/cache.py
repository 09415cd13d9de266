"""Damages what is kept of compiled loops, and looks whether it is loaded.

Each attempt asks for a file as a run does before it loads it. After some of them a whole command runs too: it
must compile anew and print the bytes of one that compiled in an empty folder, and the next one must find what
that one kept.
"""

import os
import random
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from hydroservo.engine import disk_cache
from hydroservo.engine.disk_cache import ENDING
from tools.promises.forked import Ended, start, warm_up

SCENARIO = ("paper/sine-pi", "--set", "simulation.duration=50 ms", "--json", "--verbose")
OTHER = ("paper/sine-tsmc", *SCENARIO[1:])
WHOLE = 250  # attempts, after each of which a command runs
STRANGER = 12345

Say = Callable[[str], None]
Prepare = Callable[[], Any]
Draw = random.Random


class Cache(NamedTuple):
    """A folder with the kernels of two loops, as it is before it is damaged.

    Attributes:
        place: the folder.
        file: the kernel of a run.
        other: that of another loop's.
        kept: all that is in the folder, by name.
        printed: what the first run prints.
    """

    place: Path
    file: Path
    other: Path
    kept: Mapping[str, bytes]
    printed: str

    def restore(self) -> None:
        """Have it as it was."""
        shutil.rmtree(self.place, ignore_errors=True)
        self.place.mkdir(mode=0o700)
        for name, content in self.kept.items():
            (self.place / name).write_bytes(content)
            (self.place / name).chmod(0o600)


def count_cache(count: int, seed: int, say: Say = print) -> list[dict[str, Any]]:
    """Damage the cache ``count`` times, in each way as often; a row for each way.

    Raises:
        RuntimeError: a command fails where nothing is damaged.
    """
    warm_up()
    rows = []
    with tempfile.TemporaryDirectory(prefix="cache-") as folder:
        cache = filled(Path(folder))
        ways = {way: damage for way, damage in DAMAGES.items() if damage not in BY_ROOT or os.getuid() == 0}
        for way, damage in ways.items():
            tally = Counter[str]()
            for number in range(-(-count // len(ways))):
                draw = Draw(f"{seed} {way} {number}")
                cache.restore()
                damage(cache, draw)
                problems = loaded(cache)
                if number % WHOLE == 0:
                    problems += commands(cache, again=damage not in OF_FOLDER)
                    tally["commands"] += 1
                tally["attempts"] += 1
                tally["broken"] += bool(problems)
                for problem in problems:
                    say(f"{way}, number {number}: {problem}")
            rows.append({"damage": way, **{key: tally[key] for key in ("attempts", "broken", "commands")}})
        rows += made_elsewhere(cache, -(-count // (len(ways) * WHOLE)), seed, say)
    return rows


def filled(folder: Path) -> Cache:
    """A cache with the kernels of two runs, as the commands left them."""
    place = folder / "kernels"
    os.environ["HYDROSERVO_CACHE_DIR"] = str(place)
    printed = run(folder).out
    first = largest(place)
    run(folder, OTHER)
    other = largest(place, {*first})
    kept = {path.name: path.read_bytes() for path in place.iterdir()}
    return Cache(place, first[0], other[0], kept, printed)


def largest(place: Path, before: Collection[Path] = ()) -> list[Path]:
    """The kernels that were not there before; that of a run, not those that ask its machine, first."""
    return sorted({*place.glob(f"*{ENDING}")} - {*before}, key=lambda file: -file.stat().st_size)


def run(folder: Path, words: tuple[str, ...] = SCENARIO, prepare: Prepare = lambda: None) -> Ended:
    """A run, as a command of its own.

    Raises:
        RuntimeError: it failed.
    """
    ended = start(["run", *words], folder / "said", prepare).ended()
    if ended.status:
        raise RuntimeError(f"it ended with {ended.status}: {ended.err[-300:]}")
    return ended


def loaded(cache: Cache) -> list[str]:
    """What is wrong with what a run would load."""
    try:
        found = disk_cache.read_kernel(cache.file.stem)
    except OSError:
        return []
    return [] if found is None else ["it would be loaded"]


def commands(cache: Cache, again: bool) -> list[str]:
    """What is wrong with a command after the damage, and with one ``again``, which need not compile."""
    problems = []
    for expected in ("compiled in", "read from disk in")[: 1 + again]:
        try:
            ended = run(cache.place.parent)
        except RuntimeError as error:
            problems.append(str(error))
            continue
        if f"kernel 'run' {expected}" not in ended.err:
            problems.append(f"it was not {expected[:-3]}: {ended.err!r}")
        if ended.out != cache.printed:
            problems.append("it printed other numbers")
    return problems


def made_elsewhere(cache: Cache, count: int, seed: int, say: Say) -> Iterator[dict[str, Any]]:
    """Rows for kernels of other processors and of other versions of the engine."""
    for way, elsewhere in ELSEWHERE.items():
        broken = 0
        for number in range(count):
            shutil.rmtree(cache.place)
            run(cache.place.parent, prepare=partial(elsewhere, Draw(f"{seed} {number}")))
            if problems := commands(cache, again=True):
                broken += 1
                say(f"{way}, number {number}: {problems}")
        yield {"damage": way, "attempts": count, "broken": broken, "commands": count}


def flipped(cache: Cache, draw: Draw) -> None:
    """Up to eight bits."""
    content = bytearray(cache.file.read_bytes())
    for bit in draw.sample(range(8 * len(content)), draw.randint(1, 8)):
        content[bit // 8] ^= 1 << bit % 8
    cache.file.write_bytes(content)


def cut(cache: Cache, draw: Draw) -> None:
    content = cache.file.read_bytes()
    cache.file.write_bytes(content[: draw.randrange(len(content))])


def lengthened(cache: Cache, draw: Draw) -> None:
    cache.file.write_bytes(cache.file.read_bytes() + draw.randbytes(draw.randint(1, 4096)))


def renamed(cache: Cache, _draw: Draw) -> None:
    cache.other.replace(cache.file)


def linked(cache: Cache, _draw: Draw) -> None:
    elsewhere = cache.place.parent / "elsewhere"
    elsewhere.write_bytes(cache.file.read_bytes())
    cache.file.unlink()
    cache.file.symlink_to(elsewhere)


def writable(cache: Cache, draw: Draw) -> None:
    cache.file.chmod(0o600 | draw.choice((0o020, 0o002, 0o022)) | draw.randrange(0o100))


def writable_folder(cache: Cache, draw: Draw) -> None:
    cache.place.chmod(0o700 | draw.choice((0o020, 0o002, 0o022)) | draw.randrange(0o100))


def foreign(cache: Cache, _draw: Draw) -> None:
    os.chown(cache.file, STRANGER, STRANGER)


def foreign_folder(cache: Cache, _draw: Draw) -> None:
    os.chown(cache.place, STRANGER, STRANGER)


def other_processor(draw: Draw) -> None:
    """Be a processor that lacks something that this one has."""
    from hydroservo.engine.recipe import features

    has = [one for one in features().split(",") if one.startswith("+")]
    lacks = draw.choice([one for one in has if one.startswith(("+avx", "+fma", "+bmi"))] or has)
    os.environ["HYDROSERVO_CPU_FEATURES"] = features().replace(lacks, f"-{lacks[1:]}")


def other_version(draw: Draw) -> None:
    """Be another version of the engine."""
    from hydroservo.engine import recipe

    vars(recipe)["LOADED"] = f"{draw.random()}"


DAMAGES: dict[str, Callable[[Cache, Draw], None]] = {
    "bits flipped": flipped,
    "cut": cut,
    "lengthened": lengthened,
    "renamed to another loop's": renamed,
    "a link": linked,
    "others may write it": writable,
    "others may write the folder": writable_folder,
    "another user's": foreign,
    "another user's folder": foreign_folder,
}
ELSEWHERE = {"of another processor": other_processor, "of another version": other_version}
BY_ROOT = (foreign, foreign_folder)
OF_FOLDER = (writable_folder, foreign_folder)  # nothing is kept there until that is mended
