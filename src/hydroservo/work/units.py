"""Units of work, each done once and addressed by what it is, and the folder of what they came to."""

import json
import math
import os
import re
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from traceback import format_exc
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError, ParameterError, require, system_problem
from hydroservo.core.inputs import exists, irregularity
from hydroservo.core.outputs import OutputError, staged

if TYPE_CHECKING:
    import pyarrow as pa

DIGITS = 24  # of an address, 96 bits: among a billion units no two are alike

UnitAnswer: TypeAlias = "pa.Table | Failure"
UnitAnswers: TypeAlias = "Generator[tuple[WorkUnit, UnitAnswer]]"
Say = Callable[[str], None]  # a line of what a user should know


class WorkUnit(NamedTuple):
    """Something to be done once."""

    key: str  # its address, as :func:`unit_address` makes it of all that its table depends on
    # computes its table; ``functools.partial`` of a function of a module with plain data, so that another
    # process can, or another machine
    do: "Callable[[], pa.Table]"
    name: str  # what progress and errors call it


def unit_address(what: Mapping[str, Any]) -> str:
    """Hexadecimal digits that name what a unit is: of the SHA-256 of its canonical JSON.

    Keys are sorted, and floats have all their digits: 1.0 is not 1, 0.1 + 0.2 not 0.3.
    """
    text = json.dumps(exact_json(what, ""), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return sha256(text.encode()).hexdigest()[:DIGITS]


def exact_json(value: Any, path: str) -> Any:
    """A value as JSON holds it exactly."""
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise ParameterError(
                    path or "what", key, "must be a string, like all keys of what is addressed"
                )
        return {key: exact_json(one, f"{path}.{key}" if path else key) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [exact_json(one, f"{path}[{i}]") for i, one in enumerate(value)]
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    raise ParameterError(
        path, value, "must be a string, a finite number, True, False, None, or groups of them"
    )


class Failure(NamedTuple):
    """Why a unit has no table."""

    text: str  # in one line, or the traceback of a defect
    defect: bool = False  # whether it is nothing that a user can mend


def answer_to(do: "Callable[[], pa.Table]", version: str) -> UnitAnswer:
    """What a unit comes to, here."""
    if version != __version__:
        return Failure(f"a worker has version {__version__} of hydroservo, and this is version {version}")
    try:
        return do()
    except HydroservoError as error:
        return Failure(str(error))
    except OSError as error:
        return Failure(system_problem(error))
    except Exception:  # whatever it is, it goes back to whoever asked
        return Failure(format_exc(), defect=True)


FORMAT = 1  # of the folder
PARTS = "parts"
OTHERS = "others"  # those that wait
NAME = re.compile(rf"([0-9a-f]{{{DIGITS}}})\.parquet")
MOST_MANIFEST = 1 << 28  # bytes
MAGIC = b"PAR1"  # at both ends of a Parquet file, and before the last its footer's length in 4 bytes


class UnitStore:
    """A folder of what units came to, which any number of processes may write to at once.

    ::

        FOLDER/NAME                 the manifest: JSON with sorted keys
        FOLDER/parts/KEY.parquet    the table of a unit; all of them are a dataset
        FOLDER/others/KEY.parquet   those of units that :meth:`keep` was not told of

    Units whose tables have other columns are a dataset of their own: a store of the same folder with another
    name of ``parts``.

    A part is there whole or not at all, and its bytes depend on its table and the version of pyarrow alone.
    Nothing is ever removed.

    Args:
        folder: made if it is not there. What killed processes left half-written in it is removed.
        name: of the manifest, such as ``study.json``.
        content: what the manifest says besides the versions of this format and of hydroservo; None reads a
            folder that is there, and writes nothing.
        parts: the name of the folder in it that has the tables.

    Attributes:
        folder: where it is.
        parts: the folder of the tables.
        content: what its manifest says besides the versions.
        damaged: parts that are not whole, as after a power failure; they count as not done.

    Raises:
        HydroservoError: it is the folder of another version or of something else, or cannot be read.
        OutputError: it cannot be written.
    """

    def __init__(
        self, folder: Path | str, name: str, content: Mapping[str, Any] | None = None, parts: str = PARTS
    ) -> None:
        require("pyarrow", "parquet", "Parquet")
        self.folder, self.parts = Path(folder), Path(folder) / parts
        found = manifest_in(self.folder, name)
        if found is None and self.parts.exists():
            raise HydroservoError(f"{self.folder}: has {parts} and no {name}; give another --out")
        if content is None:
            if found is None:
                raise HydroservoError(f"{self.folder}: has no {name}")
            content = found
        else:
            with staged(self.folder) as stage:
                if found is None or manifest_bytes(found) != manifest_bytes(content):
                    (stage / name).write_bytes(manifest_bytes(content))
                    sync(stage / name)
        self.content: Mapping[str, Any] = content
        self.damaged = tuple(
            self.part(key) for key in sorted(self.keys()) if not is_whole_part(self.part(key))
        )

    def part(self, key: str) -> Path:
        """The file of a unit's table, whether it is there or not."""
        return self.parts / f"{key}.parquet"

    def keys(self) -> set[str]:
        """The addresses of all parts, damaged ones among them."""
        try:
            names = os.listdir(self.parts)  # noqa: PTH208, as names alone are quick
        except FileNotFoundError:
            return set()
        except OSError as error:
            raise HydroservoError(f"{self.parts}: cannot be read: {error.strerror}") from None
        return {found[1] for name in names if (found := NAME.fullmatch(name))}

    def keep(self, keys: Iterable[str]) -> None:
        """Have the parts of these units in the dataset, and of no other; the rest wait beside it."""
        wanted, others = set(keys), self.folder / OTHERS
        try:
            for key in self.keys() - wanted:
                others.mkdir(exist_ok=True)
                self.part(key).replace(others / self.part(key).name)
            for part in others.glob("*.parquet"):
                if part.stem in wanted and not self.part(part.stem).exists():
                    part.replace(self.part(part.stem))
        except OSError as error:
            raise OutputError(f"{self.folder}: cannot be written: {error.strerror}") from None

    def done(self) -> set[str]:
        """The addresses of the units that are done."""
        return self.keys() - {one.stem for one in self.damaged}

    def write(self, key: str, table: "pa.Table") -> None:
        """Keep the table of a unit, on the disk once this returns."""
        with staged(self.folder) as stage:
            file = stage / self.parts.name / f"{key}.parquet"
            file.parent.mkdir()
            try:
                write_parquet(table, file)
                sync(file)
            except OSError as error:  # of pyarrow, which says more words and not which file
                reason = os.strerror(error.errno) if error.errno else str(error)
                raise OutputError(f"{self.part(key)}: cannot be written: {reason}") from None
        sync(self.parts)
        self.damaged = tuple(one for one in self.damaged if one.stem != key)

    def table(self, keys: Sequence[str], columns: Sequence[str] | None = None) -> "pa.Table":
        """The tables of some units, one below the other in the order of their addresses here."""
        import pyarrow as pa

        return pa.concat_tables([self.read(key, columns) for key in keys])

    def read(self, key: str, columns: Sequence[str] | None = None) -> "pa.Table":
        """The table of one unit."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        file = self.part(key)
        try:
            with pq.ParquetFile(file, page_checksum_verification=True) as part:
                return part.read(None if columns is None else list(columns))
        except FileNotFoundError:
            raise HydroservoError(f"{file}: is not there") from None
        except (OSError, pa.ArrowException) as error:
            problem = f"is damaged ({error}); remove it, and the same command makes it again"
            raise HydroservoError(f"{file}: {problem}") from None


def manifest_in(folder: Path | str, name: str) -> dict[str, Any] | None:
    """What the manifest in a folder says besides the versions; None if there is none."""
    file = Path(folder) / name
    if exists(file) and (problem := irregularity(file, MOST_MANIFEST)):
        raise HydroservoError(f"{file}: {problem}; give another --out")
    try:
        found = json.loads(file.read_bytes())
        kind, version = found.pop("format"), found.pop("hydroservo")
    except FileNotFoundError:
        return None
    except NotADirectoryError:
        raise OutputError(f"{folder}: cannot be written: Not a directory") from None
    except OSError as error:
        raise HydroservoError(f"{file}: cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, AttributeError, TypeError, RecursionError):
        raise HydroservoError(f"{file}: is not what hydroservo writes there; give another --out") from None
    for what, theirs, ours in (("the format", kind, FORMAT), ("hydroservo", version, __version__)):
        if theirs != ours:
            problem = f"is of version {theirs} of {what}, and this is version {ours}; give another --out"
            raise HydroservoError(f"{file}: {problem}")
    content: dict[str, Any] = found
    return content


def manifest_bytes(content: Mapping[str, Any]) -> bytes:
    """A manifest, the same bytes for the same content."""
    about = {**content, "format": FORMAT, "hydroservo": __version__}
    return (json.dumps(about, indent=2, sort_keys=True, allow_nan=False) + "\n").encode()


def write_parquet(table: "pa.Table", file: Path) -> None:
    """Write a table, the same bytes for the same table, with a checksum for each page of it."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    texts = [field.name for field in table.schema if pa.types.is_string(field.type)]
    pq.write_table(
        table.combine_chunks(),
        file,
        row_group_size=max(1, table.num_rows),
        version="2.6",
        compression="zstd",
        compression_level=1,
        use_dictionary=texts,
        write_page_checksum=True,
    )


def is_whole_part(file: Path) -> bool:
    """Whether a Parquet file was not cut off, by its two ends."""
    if not file.is_file():
        return False
    try:
        with file.open("rb") as part:
            head, size = part.read(4), part.seek(0, os.SEEK_END)
            if size < 12:
                return False
            part.seek(size - 8)
            footer, tail = int.from_bytes(part.read(4), "little"), part.read(4)
    except OSError:
        return False
    return head == tail == MAGIC and 0 < footer <= size - 12


def sync(path: Path) -> None:
    """Have a file, or the names in a folder, on the disk and not in the system's memory alone."""
    if path.is_dir() and os.name == "nt":
        return  # where folders cannot be opened
    handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
