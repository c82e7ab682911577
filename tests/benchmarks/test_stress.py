"""The stress test finds nothing in the engine, and everything that is planted in its results."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.formats import hostile
from benchmarks.formats.damaged import damaged_rows
from benchmarks.formats.round_trips import reader, round_trips
from benchmarks.formats.subjects import mesh_of, points_of
from benchmarks.stress import judge, rational, stress
from benchmarks.stress.__main__ import main
from benchmarks.stress.catalogue import BASE, CATALOGUE
from benchmarks.stress.families import FAMILIES, make_case
from benchmarks.stress.stress import run_case, run_stress
from geosurf import TriSurface, intersect_surfaces, intersect_triangles, rebuild_surfaces
from geosurf.errors import RoundingError
from geosurf.write import WRITERS

pytestmark = pytest.mark.long

# ---- the engine ------------------------------------------------------------------------


def test_all_families_are_answered_rightly():
    lines = []
    rows = run_stress(4, seed=11, progress=lines.append)
    assert [row.family for row in rows] == list(FAMILIES)
    assert {row.family: row.failures for row in rows if row.wrong} == {}
    assert all(row.cases == 4 and row.error_ulp <= 0.5 for row in rows)
    assert len(lines) == len(FAMILIES) + 1
    assert all(len(line) == len(stress.HEAD) for line in lines)


def test_a_seed_makes_the_same_cases_and_results():
    for family in FAMILIES:
        one, two, other = (make_case(family, 3, seed) for seed in (1, 1, 2))
        bytes_of = [b"".join(s.vertices.tobytes() for s in c.surfaces) for c in (one, two, other)]
        assert bytes_of[0] == bytes_of[1] != bytes_of[2]
    first, second = (run_stress(3, 1, ["slivers"])[0] for _ in range(2))
    assert replace(first, seconds=0) == replace(second, seconds=0)


# ---- what the cases are ------------------------------------------------------------------


def test_the_catalogue_says_what_fractions_say():
    assert {(p.kind, p.count) for p in CATALOGUE} == {
        ("disjoint", 0), ("point", 1), ("segment", 2), *(("area", n) for n in (3, 4, 5, 6))
    }  # fmt: skip
    names = set()
    for pair in CATALOGUE:
        base, other = rational.rational(BASE), rational.rational(pair.corners)
        corners = rational.meet(base, other)
        assert len(corners) == pair.count, pair.name
        for corner in corners:
            features = (rational.feature(t, corner).split()[0] for t in (base, other))
            names.add(tuple(features))
    kinds = ("vertex", "edge", "face")
    assert names == {(a, b) for a in kinds for b in kinds} - {("face", "face")}


def test_touching_points_are_judged_in_world_coordinates():
    """A touching point at UTM coordinates is rounded where it is kept."""
    offset = (448_512.0, 6_725_632.0, 0.0)
    P = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]]) + np.array(offset)
    Q = np.array([[3, -1, -1], [4, 6, 6], [1, -9, 0.0]]) + np.array(offset)
    surfaces = [TriSurface(n, "surface", t, [[0, 1, 2]]) for n, t in (("A", P), ("B", Q))]
    curves = intersect_surfaces(surfaces)
    met, complete = judge.meetings(surfaces, curves.origin, 9, False)
    assert judge.judge_curves(surfaces, curves, met, complete).wrong == []
    (touch,) = curves.contacts
    far = replace(curves, contacts=(replace(touch, points=touch.points + 1e-6),))
    assert judge.judge_curves(surfaces, far, met, complete).wrong
    assert judge.judge_curves(surfaces, replace(curves, contacts=()), met, complete).wrong


# ---- fractions ---------------------------------------------------------------------------


def test_area_and_distance_in_fractions():
    square = rational.rational([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    assert rational.area(square) == 4.0
    triangle = rational.rational([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
    for point, far in (([1, 1, 2], 2.0), ([-3, -4, 0], 5.0), ([2, -1, 0], 1.0), ([7, 0, 4], 5.0)):
        assert rational.distance(*rational.rational([point]), triangle) == far


# ---- planted faults: contacts ---------------------------------------------------------------

P = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0.0]])
Q = np.array([[1, 1, -1], [1, 3, 2], [7, 5, 2.0]])


@pytest.mark.parametrize(
    ("plant", "sentence"),
    [
        (lambda c: {"kind": "point"}, "contact is point, expected segment"),
        (lambda c: {"coplanar": True}, "coplanar is True, which"),
        (lambda c: {"crossing": False}, "crossing is False, which"),
        (lambda c: {"points": c.points[:1]}, "1 points, expected 2"),
        (lambda c: {"points": c.points + 1e-14}, "ulp from the exact point"),
        (lambda c: {"features": (("vertex 0", "face"),) * 2}, "expected .'face', 'edge"),
    ],
)
def test_a_wrong_contact_is_seen(plant, sentence):
    contact = intersect_triangles(P, Q)
    assert judge.judge_contact(P, Q, contact).wrong == []
    verdict = judge.judge_contact(P, Q, replace(contact, **plant(contact)))
    assert any(re.search(sentence, s) for s in verdict.wrong), verdict.wrong


# ---- planted faults: meshes ---------------------------------------------------------------


@pytest.fixture(scope="module")
def split():
    """A case, its mesh, and what its triangles have in common."""
    case = make_case("offsets", 4)
    patches = rebuild_surfaces(case.surfaces)
    met, _ = judge.meetings(patches.sources, patches.origin, 99, False)
    assert judge.judge_patches(case.surfaces, patches, met).wrong == []
    assert len(met) > 5
    return case, patches, met


def _moved_point(patches):
    local = patches.local.copy()
    row = patches.curve_edges[0, 0]
    local[row] += 64 * np.spacing(np.abs(local).max())
    return {"local": local}


def _without(patches, rows):
    keep = np.ones(patches.n_triangle, dtype=bool)
    keep[rows] = False
    keys = ("triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle")
    return {key: getattr(patches, key)[keep] for key in keys}


def _turned(patches):
    triangles = patches.triangles.copy()
    triangles[3] = triangles[3, ::-1]
    return {"triangles": triangles}


def _other_parent(patches):
    parents = patches.parent_of_triangle.copy()
    parents[0] = parents[-1]
    return {"parent_of_triangle": parents}


def _unreported_move(patches):
    first, *others = patches.sources
    moved = type(first)(first.name, first.role, first.vertices + 1e-3, first.triangles)
    return {"sources": (moved, *others)}


@pytest.mark.parametrize(
    ("plant", "sentence"),
    [
        (_moved_point, r"ulp|cross|lack"),
        (lambda p: _without(p, [0]), "pieces of triangle .* short"),
        (_turned, "turned over"),
        (_other_parent, "lack|turned|off its triangle"),
        (_unreported_move, "moves .* but reported as"),
    ],
    ids=["moved point", "dropped child", "turned child", "other parent", "unreported move"],
)
def test_a_wrong_mesh_is_seen(split, plant, sentence):
    case, patches, met = split
    verdict = judge.judge_patches(case.surfaces, patches.changed(**plant(patches)), met)
    assert any(re.search(sentence, s) for s in verdict.wrong), verdict.wrong


# ---- planted faults: curves ------------------------------------------------------------------


def _half_the_curve(curves):
    return {
        "segments": curves.segments[::2],
        "surfaces_of_segment": curves.surfaces_of_segment[::2],
    }


@pytest.mark.parametrize(
    ("plant", "sentence"),
    [
        (lambda c: {"local": c.local + np.array([0, 0, 1e-6])}, "off its triangle"),
        (_half_the_curve, "on no curve|ulp"),
        (lambda c: {"segments": c.segments[:0], "surfaces_of_segment": c.segments[:0]}, "nothing"),
    ],
    ids=["moved", "in pieces", "gone"],
)
def test_a_wrong_curve_is_seen(plant, sentence):
    case = make_case("offsets", 1)
    curves = intersect_surfaces(case.surfaces)
    met, complete = judge.meetings(case.surfaces, curves.origin, 999, False)
    assert complete
    assert judge.judge_curves(case.surfaces, curves, met, complete).wrong == []
    wrong = replace(curves, **plant(curves))
    verdict = judge.judge_curves(case.surfaces, wrong, met, complete)
    assert any(re.search(sentence, s) for s in verdict.wrong), verdict.wrong


def test_a_curve_where_nothing_meets_is_seen():
    curves = intersect_surfaces(make_case("offsets", 1).surfaces)
    assert judge.judge_curves(make_case("offsets", 1).surfaces, curves, [], True).wrong
    assert judge.judge_known({"apart": True}, None, curves).wrong == ["surfaces with a gap meet"]
    (lack,) = judge.judge_known({"area": 2.0}, None, curves).wrong
    assert "overlap 0 m², expected 2.0" in lack
    known = {"kind": "point", "count": 1}
    assert judge.judge_known(known, intersect_triangles(P, Q), curves).wrong


# ---- the runner ------------------------------------------------------------------------------


def test_what_the_engine_raises_is_counted(monkeypatch):
    def refuse(*arguments, **options):
        raise RoundingError("cannot be held at (easting 1, northing 2, elevation 3)")

    monkeypatch.setattr(stress, "rebuild_surfaces", refuse)
    [row] = run_stress(2, families=["strips"])
    assert (row.wrong, row.refused) == (0, 2)
    assert "easting 1" in row.refusals[0]["refused"]

    monkeypatch.setattr(stress, "intersect_surfaces", lambda *a, **k: 1 // 0)
    assert run_case(make_case("strips", 0)).wrong == [
        "intersect_surfaces: ZeroDivisionError: integer division or modulo by zero"
    ]


def test_a_failure_leaves_a_file_and_an_exit_code(tmp_path, monkeypatch, capsys):
    true = stress.intersect_triangles
    monkeypatch.setattr(
        stress, "intersect_triangles", lambda P, Q: replace(true(P, Q), coplanar=None)
    )
    out = tmp_path / "stress.json"
    arguments = ["--cases", "1", "--family", "catalogue", "-o", str(out)]
    assert main(arguments) == 1
    said = capsys.readouterr()
    assert "coplanar is None, which" in said.err
    assert "1 cases, 1 wrong, 0 refused" in said.out
    [row] = json.loads(out.read_text())["families"]
    assert row["wrong"] == 1
    file = row["failures"][0]["file"]
    assert file in said.err
    assert main(["--replay", file]) == 1
    monkeypatch.undo()
    assert main(["--replay", file]) == 0
    assert "catalogue 0, seed 0: 0 wrong" in capsys.readouterr().out


# ---- The format matrix: hostile objects come back or are refused, and the page has every format.
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
