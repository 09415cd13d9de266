"""development.lock holds what pyproject.toml asks of development, by hash; scripts/lock makes it."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
REMEDY = "scripts/lock makes development.lock anew"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
LOCK = (ROOT / "development.lock").read_text("utf-8")
ENTRY = re.compile(r"^(\S+==\S+)((?: ;[^\\\n]+)?(?: \\\n    --hash=\S+)*)\n((?:    #.*\n)*)", re.MULTILINE)


def declared(extra: str) -> Iterator[Requirement]:
    """The requirements of an extra and of those that it includes."""
    for one in map(Requirement, PROJECT["project"]["optional-dependencies"][extra]):
        if one.name == PROJECT["project"]["name"]:
            for included in one.extras:
                yield from declared(included)
        else:
            yield one


ASKED = [
    *map(Requirement, PROJECT["project"]["dependencies"] + PROJECT["build-system"]["requires"]),
    *declared("dev"),
]
ENTRIES = [(Requirement(pin), hashes, why) for pin, hashes, why in ENTRY.findall(LOCK)]


def test_every_line_of_the_lock_is_a_comment_or_a_pin_with_hashes_from_no_named_place():
    assert ENTRY.sub("", LOCK).splitlines() == LOCK.splitlines()[:2]
    assert [str(pin) for pin, hashes, _ in ENTRIES if "--hash=sha256:" not in hashes] == []
    assert "://" not in LOCK


def test_what_is_asked_is_pinned_within_its_bounds():
    for asked in ASKED:
        pins = [pin for pin, *_ in ENTRIES if canonicalize_name(pin.name) == canonicalize_name(asked.name)]
        assert pins, f"{asked}: not in development.lock; {REMEDY}"
        for pin in pins:
            (version,) = (one.version for one in pin.specifier)
            assert version in asked.specifier, f"{pin} is not {asked}; {REMEDY}"


def test_what_is_pinned_as_asked_is_asked():
    pinned = {
        canonicalize_name(pin.name)
        for pin, _, why in ENTRIES
        if not why or "hydroservo (pyproject.toml)" in why  # nothing is said of what builds the package
    }
    assert pinned == {canonicalize_name(one.name) for one in ASKED}, REMEDY
