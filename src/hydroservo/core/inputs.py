"""Files that a user names, read without trusting them."""

import stat
from contextlib import suppress
from pathlib import Path

from hydroservo.core.errors import ScenarioError

UTF_16 = (b"\xff\xfe", b"\xfe\xff")
KINDS = {  # by the first bytes
    b"\xff\xfe": 'is UTF-16 text, in spreadsheets "Unicode text"; save it as UTF-8',
    b"\xfe\xff": "is UTF-16 text; save it as UTF-8",
    b"\x1f\x8b": "is compressed by gzip; unpack it",
    b"PK\x03\x04": "is a zip archive or a workbook; save it as CSV",
    b"MATLAB": "is a MAT file; name it .mat",
    b"\x89HDF": "is an HDF5 file; name it .h5, or .mat or .nc as it is one of these",
    b"CDF": "is a NetCDF file; name it .nc",
    b"PAR1": "is a Parquet file; name it .parquet",
    b"MDF": "is an MDF file; name it .mf4",
    b"TDSm": "is a TDMS file; name it .tdms",
}


def exists(path: Path) -> bool:
    """False only where there is nothing; a path that cannot be examined is for the reader to refuse."""
    try:
        return path.exists()
    except (OSError, ValueError):  # ValueError: a null character in the path
        return True


def read_text(path: Path, most: int, name: str) -> str:
    """The UTF-8 text of a file, without its byte order mark; ``name`` is what errors call the file."""
    content = read_bytes(path, most, name)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        problem = file_kind(content) or f"is not UTF-8 text (line {line}); save it as UTF-8"
        raise ScenarioError(name, "", problem) from None


def read_record_text(path: Path, most: int, name: str) -> str:
    """The text of a record, in UTF-8, else in UTF-16 or Windows' code page 1252, as loggers write it."""
    content = read_bytes(path, most, name)
    utf_16 = content.startswith(UTF_16)
    if not utf_16 and (kind := file_kind(content)):
        raise ScenarioError(name, "", kind)
    for encoding in ("utf-16",) if utf_16 else ("utf-8-sig", "cp1252"):
        with suppress(UnicodeDecodeError):
            return content.decode(encoding)
    raise ScenarioError(name, "", "is not text in UTF-8, UTF-16 or Windows' code page 1252")


def read_bytes(path: Path, most: int, name: str) -> bytes:
    """The content of a regular file of at most ``most`` bytes."""
    check_regular(path, most, name)
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        raise ScenarioError(name, "", f"cannot be read: {reason(error)}") from None
    if len(content) > most:
        raise ScenarioError(name, "", f"is larger than {size(most)}")
    return content


def file_kind(content: bytes) -> str:
    """What a file is that is not UTF-8 text, by its first bytes; "" where they do not tell."""
    return next((kind for start, kind in KINDS.items() if content.startswith(start)), "")


def check_regular(path: Path, most: int, name: str) -> None:
    """Refuse what is not a regular file of at most ``most`` bytes."""
    if problem := irregularity(path, most):
        raise ScenarioError(name, "", problem)


def irregularity(path: Path, most: int) -> str:
    """Why a path is not that of a regular file of at most ``most`` bytes; "" where it is."""
    try:
        found = path.stat()
    except (OSError, ValueError) as error:
        return f"cannot be read: {reason(error)}"
    if stat.S_ISDIR(found.st_mode):
        return "is a directory, not a file"
    if not stat.S_ISREG(found.st_mode):  # a pipe or a device may never end
        return "is not a regular file"
    return f"is larger than {size(most)}" if found.st_size > most else ""


def reason(error: Exception) -> str:
    return error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)


def size(number: int) -> str:
    return f"{number >> 20} MiB" if number >= 1 << 20 else f"{number >> 10} KiB"
