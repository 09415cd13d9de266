"""Units of work: what they are addressed by, where they are kept, and that they are done once."""

import json
import math
import os
from functools import partial

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from hydroservo import ParameterError
from hydroservo._version import __version__
from hydroservo.core.errors import HydroservoError
from hydroservo.core.outputs import PREFIX, OutputError, staged
from hydroservo.work import units as module
from hydroservo.work.execution import MOST_DEATHS, UnitsError, do_units
from hydroservo.work.units import DIGITS, UnitStore, manifest_in, unit_address
from tests.support.commands.processes import needs_posix
from tests.support.work.units import (
    MANIFEST,
    contents,
    deadly,
    defective,
    dies_once,
    numbers,
    refused,
    threads_of_algebra,
    unit,
    units,
)


def opened(folder, **content):
    return UnitStore(folder, MANIFEST, content)


# --- addresses


def test_an_address_is_of_the_content_and_of_all_digits():
    first = unit_address({"a": 1.0, "b": [1, "x", None, True], "c": {"d": 0.1 + 0.2}})
    assert first == unit_address({"c": {"d": 0.30000000000000004}, "b": (1, "x", None, True), "a": 1.0})
    assert len(first) == DIGITS
    assert set(first) <= set("0123456789abcdef")
    others = [{"a": 1}, {"a": 1.0}, {"a": np.nextafter(1.0, 2.0)}, {"a": -0.0}, {"a": 0.0}, {"a": "1"}]
    others += [{"a": True}, {"a": None}, {"b": 1}, {}, {"a": {}}, {"a": []}]
    assert len({unit_address(one) for one in others}) == len(others)
    assert unit_address({"a": np.float64(0.1)}) == unit_address({"a": 0.1})


@pytest.mark.parametrize(
    ("what", "path"),
    [
        ({"a": {"b": [0.0, math.nan]}}, "a.b[1] = nan"),
        ({"a": math.inf}, "a = inf"),
        ({"a": np.int64(1)}, "a = np.int64(1)"),
        ({"a": {1, 2}}, "a = {1, 2}"),
        ({"a": {1: 2}}, "a = 1: must be a string"),
    ],
)
def test_what_has_no_canonical_text_has_no_address(what, path):
    with pytest.raises(ParameterError) as caught:
        unit_address(what)
    assert str(caught.value).startswith(path)


# --- the folder


def test_a_part_is_read_as_it_was_written_and_has_the_same_bytes_whoever_writes_it(tmp_path):
    table = numbers(3, 0.0)
    in_pieces = pa.concat_tables([table.slice(0, 7), table.slice(7)])
    for name, one in (("a", table), ("b", in_pieces)):
        store = opened(tmp_path / name, title="t")
        store.write(unit_address({}), one)
        assert store.done() == {unit_address({})}
        assert store.table([unit_address({})]).equals(table)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")
    assert sorted(contents(tmp_path / "a")) == [f"parts/{unit_address({})}.parquet", MANIFEST]
    assert pq.read_table(tmp_path / "a" / "parts").equals(table)


def test_tables_come_in_the_order_asked_for(tmp_path):
    store, made = opened(tmp_path), units(5, seconds=0.0)
    do_units(made, store, workers=1)
    keys = [one.key for one in reversed(made)]
    assert store.table(keys, ["unit"]).column("unit").to_pylist() == [
        n for n in (4, 3, 2, 1, 0) for _ in range(300)
    ]
    assert store.table(keys[:1], ["draw", "unit"]).column_names == ["draw", "unit"]


def test_a_manifest_says_what_it_was_given_and_nothing_of_time_or_place(tmp_path):
    opened(tmp_path, b=1, a={"d": 0.1, "c": "x"})
    text = (tmp_path / MANIFEST).read_text()
    assert json.loads(text) == {
        "a": {"c": "x", "d": 0.1},
        "b": 1,
        "format": module.FORMAT,
        "hydroservo": __version__,
    }
    assert text == json.dumps(json.loads(text), indent=2, sort_keys=True) + "\n"
    assert (
        UnitStore(tmp_path, MANIFEST).content
        == manifest_in(tmp_path, MANIFEST)
        == {"a": {"c": "x", "d": 0.1}, "b": 1}
    )


def test_parts_that_a_later_manifest_does_not_need_stay(tmp_path):
    do_units(units(3, seconds=0.0), opened(tmp_path, laws=3), workers=1)
    before = contents(tmp_path / "parts")
    do_units(units(2, seconds=0.0), opened(tmp_path, laws=2), workers=1)
    assert contents(tmp_path / "parts") == before
    assert UnitStore(tmp_path, MANIFEST).content == {"laws": 2}


@pytest.mark.parametrize(
    ("key", "version", "said"),
    [("format", 99, "version 99 of the format"), ("hydroservo", "0.0.1", "version 0.0.1 of hydroservo")],
)
def test_a_folder_of_another_version_is_refused_and_left(tmp_path, key, version, said):
    do_units(units(1, seconds=0.0), opened(tmp_path), workers=1)
    file = tmp_path / MANIFEST
    file.write_text(json.dumps(json.loads(file.read_text()) | {key: version}))
    before = contents(tmp_path)
    ours = {"format": module.FORMAT, "hydroservo": __version__}[key]
    with pytest.raises(HydroservoError) as caught:
        opened(tmp_path)
    assert str(caught.value) == f"{file}: is of {said}, and this is version {ours}; give another --out"
    assert contents(tmp_path) == before


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"format": 1}', "[" * 100_000, "\xff"])
def test_a_manifest_that_is_none_is_refused(tmp_path, text):
    (tmp_path / MANIFEST).write_text(text, encoding="latin-1")
    with pytest.raises(HydroservoError, match=f"{MANIFEST}: is not what hydroservo writes there"):
        opened(tmp_path)


def test_a_folder_to_read_must_be_there(tmp_path):
    with pytest.raises(HydroservoError, match=f"none: has no {MANIFEST}"):
        UnitStore(tmp_path / "none", MANIFEST)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("size", [0, 3, 11, 12, -1, -8])
def test_a_part_that_was_cut_off_is_found_and_done_again(tmp_path, size):
    made = units(3, seconds=0.0)
    do_units(made, opened(tmp_path), workers=1)
    before = contents(tmp_path)
    file = opened(tmp_path).part(made[1].key)
    os.truncate(file, size if size >= 0 else file.stat().st_size + size)
    store = opened(tmp_path)
    assert store.damaged == (file,)
    assert store.done() == {made[0].key, made[2].key}
    said = []
    do_units(made, store, workers=1, say=said.append)
    assert said == [f"{file}: is damaged, and done again if it is needed"]
    assert contents(tmp_path) == before
    assert store.damaged == opened(tmp_path).damaged == ()


def test_a_flipped_bit_is_found_where_it_is_read(tmp_path):
    (one,) = units(1, seconds=0.0)
    store = opened(tmp_path)
    do_units([one], store, workers=1)
    file = store.part(one.key)
    data = bytearray(file.read_bytes())
    data[200] ^= 1
    file.write_bytes(data)
    with pytest.raises(HydroservoError, match=f"{file}: is damaged .*; remove it, and the same command"):
        opened(tmp_path).table([one.key])
    file.unlink()
    with pytest.raises(HydroservoError, match=f"{file}: is not there"):
        store.table([one.key])


@needs_posix
def test_what_a_killed_process_left_is_removed_and_what_a_live_one_writes_is_not(tmp_path):
    opened(tmp_path)
    dead = tmp_path / f"{PREFIX}0123abcd"
    (dead / "parts").mkdir(parents=True)
    (dead / "parts" / "half.parquet").write_bytes(b"PAR1")
    (dead / "in-use").touch()
    with staged(tmp_path) as live:
        opened(tmp_path)
        assert live.exists()
        assert not dead.exists()
    assert list(tmp_path.iterdir()) == [tmp_path / MANIFEST]


def test_a_folder_that_is_a_file_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(OutputError, match="cannot be written: Not a directory"):
            opened(place)


def test_a_folder_without_permission_is_one_line(tmp_path, monkeypatch):
    store = opened(tmp_path)

    def refusing(path, *_args, **_options):
        raise PermissionError(13, os.strerror(13), str(path))

    monkeypatch.setattr(module.Path, "mkdir", refusing)
    for attempt in (lambda: opened(tmp_path), lambda: store.write(unit_address({}), numbers(1, 0.0))):
        with pytest.raises(OutputError) as caught:
            attempt()
        assert str(caught.value) == f"{tmp_path}: cannot be written: Permission denied"


def test_a_full_disk_is_one_line_and_keeps_what_was_done(tmp_path, monkeypatch):
    write, made, store = module.write_parquet, units(4, seconds=0.0), opened(tmp_path)
    left = [2]

    def filling(table, file):
        if not left[0]:
            file.write_bytes(b"PAR1 half")
            raise OSError(28, "Error writing bytes to file. Detail: [errno 28] No space left on device")
        left[0] -= 1
        write(table, file)

    monkeypatch.setattr(module, "write_parquet", filling)
    with pytest.raises(OutputError) as caught:
        do_units(made, store, workers=1)
    monkeypatch.setattr(module, "write_parquet", write)
    assert str(caught.value) == f"{store.part(made[2].key)}: cannot be written: No space left on device"
    assert opened(tmp_path).done() == {made[0].key, made[1].key}
    assert not list(tmp_path.rglob(f"{PREFIX}*"))
    do_units(made, store, workers=1)
    do_units(made, opened(tmp_path / "undisturbed"), workers=1)
    assert contents(tmp_path / "parts") == contents(tmp_path / "undisturbed" / "parts")


# --- doing


def test_units_are_done_once_and_a_name_twice_is_one_unit(tmp_path):
    store, seen = opened(tmp_path), []
    made = units(4, seconds=0.0)
    do_units([*made[:2], made[0]], store, workers=1, progress=seen.append)
    assert store.done() == {one.key for one in made[:2]}
    times = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*.parquet")}
    do_units(made, store, workers=1, progress=seen.append)
    assert seen == [2 / 3, 1.0, 0.75, 1.0]
    assert all(file.stat().st_mtime_ns == time for file, time in times.items())


@pytest.mark.parametrize("workers", [1, 2])
def test_a_unit_that_fails_does_not_keep_others_from_being_done(tmp_path, workers):
    made, said, store = units(4, seconds=0.0), [], opened(tmp_path)
    made[1] = unit(1, refused)
    with pytest.raises(UnitsError) as caught:
        do_units(made, store, workers=workers, say=said.append)
    assert str(caught.value) == "1 of 4 units failed, such as unit 1: there is no 1"
    assert said == ["unit 1: there is no 1"]
    assert store.done() == {made[0].key, made[2].key, made[3].key}


def test_what_the_system_refuses_a_unit_is_one_line(tmp_path):
    def unread(_):
        raise OSError(28, "No space left on device", "module.py")

    with pytest.raises(UnitsError, match=r"such as unit 3: module.py: No space left on device"):
        do_units([unit(3, unread)], opened(tmp_path), workers=1)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_defect_is_raised_with_its_traceback_and_what_was_done_is_kept(tmp_path, workers):
    made, store = units(2, seconds=0.0), opened(tmp_path)
    do_units(made[:1], store, workers=1)
    with pytest.raises(RuntimeError, match=r"(?s)unit 7: Traceback.*defective.*ZeroDivisionError: of 7"):
        do_units([*made, unit(7, defective)], store, workers=workers)
    assert made[0].key in store.done()


def test_processes_come_to_the_same_bytes(tmp_path):
    for workers in (1, 2):
        do_units(units(6, seconds=0.0), opened(tmp_path / str(workers)), workers=workers)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


@needs_posix
def test_a_process_that_is_killed_costs_nothing_but_time(tmp_path):
    store, said = opened(tmp_path), []
    made = [*units(3, seconds=0.0), unit(3)]
    made[1] = made[1]._replace(do=partial(dies_once, str(tmp_path / "marker"), 1))
    do_units(made, store, workers=2, say=said.append)
    assert said == ["unit 1: its process ended (SIGKILL); it is done again"]
    assert store.read(made[1].key).equals(numbers(1, 0.0))
    assert len(store.done()) == 4


@needs_posix
def test_a_unit_that_ends_every_process_is_named(tmp_path):
    store, said = opened(tmp_path), []
    with pytest.raises(
        UnitsError, match=r"1 of 3 units failed, such as unit 9: its process ended \(SIGKILL\)"
    ):
        do_units([*units(2, seconds=0.0), unit(9, deadly)], store, workers=2, say=said.append)
    assert len(said) == MOST_DEATHS
    assert len(store.done()) == 2


def test_processes_have_one_thread_each_for_linear_algebra(tmp_path, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    store, made = opened(tmp_path), [unit(n, threads_of_algebra) for n in range(2)]
    do_units(made, store, workers=2)
    assert store.table([one.key for one in made]).column("threads").to_pylist() == ["1"] * 4
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "OPENBLAS_NUM_THREADS" not in os.environ


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_a_wrong_number_of_workers_is_refused(tmp_path, workers):
    with pytest.raises(ParameterError, match=r"workers = .*: must be a whole number, at least 1"):
        do_units(units(1), opened(tmp_path), workers=workers)


def test_parts_of_something_else_are_not_mixed_with(tmp_path):
    UnitStore(tmp_path / "one", "batch.json", {}).write("0" * 24, pa.table({"x": [1]}))
    with pytest.raises(HydroservoError, match=r"one: has parts and no study\.json; give another --out"):
        UnitStore(tmp_path / "one", "study.json", {})


def test_parts_that_are_not_kept_wait_until_they_are(tmp_path):
    store = UnitStore(tmp_path, MANIFEST, {})
    first, second = "1" * 24, "2" * 24
    for key in (first, second):
        store.write(key, pa.table({"x": [1]}))
    store.keep([first])
    assert store.done() == {first}
    store.keep([second, "3" * 24])
    assert store.done() == {second}
    store.keep([first, second])
    assert store.done() == {first, second}
