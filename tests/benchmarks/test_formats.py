"""The format matrix: hostile objects come back or are refused, and the page has every format."""

from __future__ import annotations

import pytest

from benchmarks.formats import hostile
from benchmarks.formats.damaged import damaged_rows
from benchmarks.formats.round_trips import reader, round_trips
from benchmarks.formats.subjects import mesh_of, points_of
from geosurf.write import WRITERS

# one suffix for each function that writes; NetCDF takes long, and its round trips are tested
ONCE = {
    (kind, function): suffix
    for kind in hostile.HOSTILE
    for suffix, function in reversed(WRITERS[kind].items())
    if suffix not in (".parquet", ".nc")
}


@pytest.mark.parametrize(("kind", "suffix"), [(kind, one) for (kind, _), one in ONCE.items()])
def test_law_hostile_objects_come_back_or_are_refused(tmp_path, kind, suffix):
    answers = {
        name: hostile.judge(kind, suffix, obj, tmp_path / f"a{k}{suffix}")
        for k, (name, obj) in enumerate(hostile.HOSTILE[kind]())
    }
    good = "back" if reader(kind, suffix) else "written"
    assert not {name: one for name, one in answers.items() if one not in (good, "refused")}
    assert good in answers.values()


@pytest.mark.parametrize("suffix", [".ts", ".xyz"])
def test_law_damaged_files_read_as_before_or_are_refused(tmp_path, suffix):
    rows = round_trips({"TriSurface": mesh_of(4), "Dataset of points": points_of(9)}, tmp_path)
    found = damaged_rows([row for row in rows if row.suffix == suffix and row.files])
    assert found
    assert all(before and refused and not wrong for _, _, before, refused, wrong in found)
