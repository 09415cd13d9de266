"""What commands leave in their folder, and what of it is damage."""

import hashlib
from pathlib import Path

from hydroservo.core.outputs import PREFIX

Files = dict[str, str]  # digests by path


def files_in(folder: Path) -> Files:
    """The digest of each file in a folder and below it."""
    found = {}
    for path in sorted(folder.rglob("*")) if folder.exists() else ():
        if path.is_file():
            found[path.relative_to(folder).as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def hidden(files: Files) -> set[str]:
    """Those of a command that was broken off as it wrote them."""
    return {name for name in files if PREFIX in name}


def damage(before: Files, after: Files, wanted: Files, last: str) -> list[str]:
    """What no command may leave, however it ends; hidden files are not looked at.

    Args:
        before: what was there.
        after: what is there.
        wanted: what the command leaves where it ends well.
        last: the file that takes its place after all others, if several belong together.
    """
    old, new = ({name: files[name] for name in files.keys() - hidden(files)} for files in (before, after))
    faults = [
        f"{name} is neither the old nor the new file"
        for name, one in new.items()
        if one not in (old.get(name), wanted.get(name))
    ]
    faults += [f"{name} is gone" for name in old.keys() - new.keys()]
    renewed = last and old.get(last) != new.get(last)
    if renewed and not wanted.items() <= new.items():
        faults.append(f"{last} came before another file")
    return faults
