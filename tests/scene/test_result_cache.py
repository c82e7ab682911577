"""Results on disk: the same bytes come back, and whatever happens to the files costs no result."""

from __future__ import annotations

import errno
import os
import threading
import warnings

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfWarning, warn
from geosurf.scene import result_cache
from geosurf.scene.result_cache import ResultCache, packed, unpacked

BOX = (50, 450, 50, 450, -2000, -1500)
NUMBERS = np.arange(600.0).reshape(20, 30)


def stored(cache: ResultCache, inputs=(NUMBERS, "trim", 2.5), value=NUMBERS):
    """One result through a cache, and how often it was computed."""
    calls = []
    found = cache.get_or_compute("sums", inputs, lambda: calls.append(1) or value)
    return found, len(calls)


@pytest.fixture(scope="module")
def world():
    return gs.synthetic.torn("normal", n=21)


@pytest.fixture(scope="module")
def sheet(world):
    return gs.tear_horizon(world.horizons["Top"], list(world.faults.values()), name="Top")


def test_a_sheet_comes_back_with_all_its_bytes(world, sheet):
    twin = unpacked(packed(sheet))
    assert packed(twin) == packed(sheet)
    assert repr(twin.report) == repr(sheet.report)
    assert twin.warnings == sheet.warnings
    ours, theirs = (gs.Scene({"Top": one}, world.faults, BOX).units for one in (sheet, twin))
    assert list(ours) == list(theirs)
    for name, unit in ours.items():
        assert unit.vertices.tobytes() == theirs[name].vertices.tobytes()
        assert unit.triangles.tobytes() == theirs[name].triangles.tobytes()


@pytest.mark.parametrize(
    "value",
    [NUMBERS.T, np.float64(0.1), np.inf, (1, [2.5, None], {"a": True, 3: "b"}), NUMBERS[:0]],
)
def test_values_come_back_with_type_and_order(value):
    twin = unpacked(packed(value))
    assert type(twin) is type(value)
    assert repr(twin) == repr(value)
    if isinstance(value, np.ndarray):
        assert twin.flags.f_contiguous == value.flags.f_contiguous
        assert not twin.flags.writeable


def test_code_and_unknown_classes_are_refused():
    with pytest.raises(TypeError, match="Scene cannot be packed"):
        packed(gs.Scene.__new__(gs.Scene))
    for tree in (b'["object", "Popen", {}, null]', b'["array", "|O", [1], "C"]', b"[[1]]"):
        with pytest.raises((KeyError, ValueError)):
            unpacked(f"{len(tree):016d}".encode() + tree + b"\0" * 8)


@pytest.mark.parametrize(
    "other",
    [(NUMBERS + 1e-12, "trim", 2.5), (NUMBERS, "trim", 2.0), (NUMBERS, "noise", 2.5),
     (NUMBERS.T, "trim", 2.5), (NUMBERS, "trim", "2.5"), (NUMBERS, "trim")],
)  # fmt: skip
def test_other_inputs_find_nothing(tmp_path, other):
    stored(ResultCache(tmp_path))
    assert stored(ResultCache(tmp_path))[1] == 0
    assert stored(ResultCache(tmp_path), other)[1] == 1


def test_another_version_finds_nothing(tmp_path, monkeypatch):
    stored(ResultCache(tmp_path))
    monkeypatch.setattr(result_cache, "environment", lambda: "other sources")
    assert stored(ResultCache(tmp_path))[1] == 1


def test_inputs_known_by_identity_only_are_not_stored(tmp_path):
    for _ in range(2):
        assert stored(ResultCache(tmp_path), (object(),))[1] == 1
    assert not list(tmp_path.iterdir())


def test_warnings_come_back_with_the_result(tmp_path):
    note = GeosurfWarning("area", "box", "The box is small.", "Give aoi=.", (1.0, 2.0, 3.0))
    for _ in range(2):
        with pytest.warns(GeosurfWarning, match="The box is small") as caught:
            ResultCache(tmp_path).get_or_compute("sums", (1,), lambda: warn(note))
        assert [one.message for one in caught] == [note]


def shorten(path):
    path.write_bytes(path.read_bytes()[:-9])


def flip(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def empty(path):
    path.write_bytes(b"")


def open_to_all(path):
    path.chmod(0o666)


def linked(path):
    path.rename(path.with_suffix(".moved"))
    path.symlink_to(path.with_suffix(".moved"))


@pytest.mark.parametrize("harm", [shorten, flip, empty, open_to_all, linked])
def test_a_damaged_file_is_computed_again_and_replaced(tmp_path, harm):
    for k in range(2):
        stored(ResultCache(tmp_path), (k,))
    for path in list(tmp_path.glob("*.gsr")):
        harm(path)
    cache = ResultCache(tmp_path)
    with pytest.warns(GeosurfWarning, match="cannot be used .*computed again") as caught:
        assert [stored(cache, (k,))[1] for k in range(2)] == [1, 1]
    assert len(caught) == 1  # two files, one message
    found, n = stored(ResultCache(tmp_path), (0,))
    assert n == 0
    assert found.tobytes() == NUMBERS.tobytes()


def test_a_full_disk_costs_one_message_and_no_result(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(result_cache, "write_whole", full)
    cache = ResultCache(tmp_path / "cache")
    with pytest.warns(GeosurfWarning, match="No space left on device.*This run is complete") as got:
        assert [stored(cache, (k,))[0] is NUMBERS for k in range(3)] == [True] * 3
    assert len(got) == 1


def test_a_folder_that_others_can_write_is_not_used(tmp_path):
    tmp_path.chmod(0o777)
    with pytest.warns(GeosurfWarning, match="can be written by others"):
        assert stored(ResultCache(tmp_path))[1] == 1
    assert not list(tmp_path.iterdir())


def test_writers_at_once_leave_whole_files(tmp_path):
    wrong = []

    def work():
        for _ in range(10):
            cache = ResultCache(tmp_path)
            found, _n = stored(cache)
            cache.save("sums-shared.gsr", packed(NUMBERS))
            if found.tobytes() != NUMBERS.tobytes() or cache.load("sums-shared.gsr") is None:
                wrong.append(1)

    with warnings.catch_warnings(action="error"):
        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert not wrong
    assert len(list(tmp_path.iterdir())) == 2


def test_the_folder_stays_within_its_budget_and_drops_what_was_used_least(tmp_path):
    size = len(packed((NUMBERS, ())))
    cache = ResultCache(tmp_path, budget=4 * size)
    for k in range(8):
        stored(cache, (k,))
        for path in tmp_path.glob("*.gsr"):  # the clock of files may be coarse
            os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 10))
        assert stored(cache, (0,))[1] == 0  # used each time: it stays
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 4 * size
    assert stored(cache, (1,))[1] == 1
