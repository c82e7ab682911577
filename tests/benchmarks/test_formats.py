"""The format matrix: hostile objects come back or are refused, and the page has every format."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.formats import hostile, page, peers
from benchmarks.formats.round_trips import Row, reader
from benchmarks.formats.subjects import difference
from geosurf.write.registry import WRITERS

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


def test_the_page_has_every_format():
    rows = [
        Row(kind, suffix, read_with=reader(kind, suffix), back=0.0, peers={"xtgeo": "opens"})
        for kind, known in WRITERS.items()
        for suffix in known
    ]
    text = page.page(rows, [("a", ".b", 1, 2, ["x: y"])], [], ["xtgeo"], "1 May 2026")
    for kind, known in WRITERS.items():
        for suffix in known:
            assert f"| {kind} | `{suffix}` |" in text
    assert "| a | `.b` | 1 | 2 | x: y |" in text


def test_differences_are_those_of_places():
    here = np.array([[5e5, 6e6, -1700.0], [5e5 + 1, 6e6, -1700.0]])
    assert difference(here, here[::-1]) == 0.0
    assert difference(here, here + np.array([0, 0, 0.25])) == pytest.approx(0.25)
    assert difference(here, here[:1]) == pytest.approx(1.0)
    assert difference(here, here[:0]) == np.inf


def test_without_interpreters_there_is_no_peer(tmp_path):
    assert peers.Peers([], tmp_path).knowing(".ts") == []
