"""Sealed models as GOCAD Model3d: units out are units in; parts are surfaces with borders."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings

import geosurf as gs
from geosurf.errors import FormatError
from geosurf.read.model3d import read_model3d, read_regions
from geosurf.write.model3d import parts_of
from tests.messages import refused
from tests.strategies import BOX, faulted_worlds, grid, sheet
from tests.write.sealed import assert_equal, carve


def written(units, folder, name="m"):
    (path,) = gs.write(units, folder / f"{name}.ml", name="m")
    return path


def test_parts_are_cut_open_along_all_lines(slit):
    """In each part an edge has one face or two of opposite directions, and borders are rings."""
    parts = parts_of(slit)
    ends = set(parts.borders[:, 0].tolist())
    inside = 0
    for k in range(len(parts.surface)):
        mine = parts.triangles[parts.first_triangle[k] : parts.first_triangle[k + 1]]
        assert mine.min() >= parts.first_vertex[k]
        assert mine.max() < parts.first_vertex[k + 1]
        edges = Counter((t[i], t[(i + 1) % 3]) for t in mine.tolist() for i in range(3))
        assert max(edges.values()) == 1
        border = [(b, a) for a, b in edges if (b, a) not in edges]
        after = dict(border)
        assert len(after) == len(border) == len(set(after.values()))

        # two lines or more begin on each ring, so that each has two ends
        left = set(after)
        while left:
            at, ring = min(left), set()
            while at not in ring:
                ring.add(at)
                at = after[at]
            assert len({tuple(parts.vertices[i]) for i in ring & ends}) >= 2
            left -= ring
        inside += int(parts.sides[k, 0] == parts.sides[k, 1])
    assert inside >= 3  # F1 in three units


def test_faults_that_end_inside_a_unit_have_it_on_both_sides(slit, tmp_path):
    path = written(slit, tmp_path)
    assert_equal(gs.read_units(path), slit)
    of_file = read_model3d(path)
    area = sum(np.linalg.norm(np.cross(*edges)) for edges in edges_of(of_file["F2"])) / 2
    assert area == pytest.approx(2.0)


def edges_of(surface):
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return list(zip(b - a, c - a, strict=True))


def test_other_programs_see_plain_names_and_groups(graben, tmp_path):
    path = written(graben, tmp_path)
    own = [line for line in path.read_text().splitlines() if line.startswith("*geosurf*")]
    plain = "\n".join(line for line in path.read_text().splitlines() if line not in own) + "\n"
    path.write_text(plain)
    back = gs.read_units(path)
    assert len(back) == len(graben)
    assert [u.volume for u in back.values()] == pytest.approx([u.volume for u in graben.values()])
    assert all(" " not in u.name and "/" not in u.zone for u in back.values())
    assert [u.zone_index for u in back.values()] == [u.zone_index for u in graben.values()]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("  +1  ", "  ", "is not closed near"),
        ("REGION", "LAYER", "has no regions"),
        ('*geosurf*unit:["', '*geosurf*unit:[["', "is damaged"),
        ("*geosurf*unit", "*geosurf*other", "describes"),
        ("*geosurf*surface", "*geosurf*other", "surfaces of geosurf"),
        ("+1 ", "+99999 ", "names TFACE 99999"),
    ],
)
def test_damage_is_named(graben, tmp_path, old, new, words):
    path = written(graben, tmp_path)
    head, end, rest = path.read_text().partition("\nEND\n")
    if "other" in new:
        head = head.replace(old, new, 1)
    elif "+1" in old:
        first, region, after = head.partition("REGION " + head.split("REGION ")[2].split()[0])
        head = first + region + after.replace(after[after.index("  ") : after.index("  ") + 6], new)
    else:
        head = head.replace(old, new)
    path.write_text(head + end + rest)
    refused(FormatError, words, gs.read_units, path)


def test_two_regions_on_one_side_of_a_part_are_refused(graben, tmp_path):
    path = written(graben, tmp_path)
    lines = path.read_text().split("\n")
    at = [i for i, line in enumerate(lines) if line.startswith("REGION ")][1:3]
    lines[at[1] + 1] = lines[at[0] + 1]
    path.write_text("\n".join(lines))
    refused(FormatError, "lie on the same side of TFACE", gs.read_units, path)


def test_vertices_that_rounding_brought_to_one_place_leave_the_region_closed(tmp_path):
    """Vertex 5 divides an edge and lies where vertex 1 does: two triangles are lines."""
    faces = ["1 3 5", "5 3 2", "1 5 4", "5 2 4", "2 3 4", "1 4 3"]
    path = tmp_path / "corner.ml"
    path.write_text(
        "GOCAD Model3d 1\nTSURF A\nTFACE 1 boundary A\n  0 0 0\n  6 0 0\n  0 6 0\n"
        "REGION 5 Corner\n  -1 0\nEND\nGOCAD TSurf 1\nHEADER {\nname:A\n}\nTFACE\nVRTX 1 0 0 0\n"
        "VRTX 2 6 0 0\nVRTX 3 0 6 0\nVRTX 4 0 0 6\nVRTX 5 0 0 0\n"
        + "".join(f"TRGL {face}\n" for face in faces)
        + "END\n"
    )
    assert gs.read_units(path)["Corner"].volume == pytest.approx(36.0)


def test_places_that_other_programs_take_for_one_are_named(tmp_path):
    """Two faults that are 0.5 micrometres apart: OpenGeode joins what lies within one."""
    level = grid("H", np.zeros((7, 7)), corner=(-1, -1))
    faults = [
        sheet(f"F{k}", [(x, -1, -5), (x, 7, -5), (x, 7, 9), (x, -1, 9)])
        for k, x in enumerate((2.0, 2.0 + 2.0**-21))
    ]
    lost = gs.write(carve([level, *faults, *gs.build_walls(BOX)]), tmp_path / "m.ml").lost
    assert "vertices on lines lie within 1e-06 m of each other" in " ".join(map(str, lost))
    lost = gs.write(carve([level, faults[0], *gs.build_walls(BOX)]), tmp_path / "m.ml").lost
    assert "within" not in " ".join(map(str, lost))


# ---- Sealed models in the two kinds of file that hold them: units out are units in.
SUFFIXES = (".ml", ".epc")


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=5)
@given(surfaces=faulted_worlds())
def test_units_of_small_worlds_come_back(surfaces, suffix, tmp_path_factory):
    pytest.importorskip("h5py")
    one, two = (tmp_path_factory.mktemp("worlds") for _ in range(2))
    units = carve(surfaces)
    (path, *_) = gs.write(units, one / f"m{suffix}", name="m")
    back = gs.read_units(path)
    assert_equal(back, units)
    gs.write(back, two / f"m{suffix}", name="m")
    first, again = ({p.name: p.read_bytes() for p in folder.iterdir()} for folder in (one, two))
    assert first == again
    if suffix == ".ml":
        volumes = [unit.volume for unit in back.values()]
        assert list(read_regions(path).values()) == pytest.approx(volumes, rel=1e-13)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_labels_roles_and_the_reference_system_come_back(graben, suffix, tmp_path):
    pytest.importorskip("h5py")
    path = gs.write(graben, tmp_path / f"m{suffix}", name="m")[0]
    back = gs.read_units(path)
    assert_equal(back, graben)
    assert any(unit.contact for unit in back.values())
    assert back.crs == next(iter(back.values())).crs == "EPSG:32631"
    roles = {source.name: source.role for source in back.piece_sides[0].sources}
    assert {name: roles[name] for name in ("OWC", "F1", "Top", "west")} == {
        "OWC": "contact", "F1": "fault", "Top": "horizon", "west": "wall",
    }  # fmt: skip
    assert "read_units" in gs.info(path).read_with
