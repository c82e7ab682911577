"""A sealed model made elsewhere: geosurf must find its blocks and invent nothing."""

from __future__ import annotations

import itertools
import math
from collections import Counter

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate import certify
from geosurf.read.model3d import read_model3d, read_regions


@pytest.fixture(scope="module")
def path(data):
    return data / "modelA4" / "modelA4.ml"


@pytest.fixture(scope="module")
def surfaces(path):
    found = read_model3d(path)
    order = {"horizon": 0, "fault": 1, "wall": 2}
    return sorted(found.values(), key=lambda surface: order[surface.role])


@pytest.fixture(scope="module")
def patches(surfaces):
    return gs.rebuild_surfaces(surfaces, self_intersections=True)


def test_reader_gives_welded_surfaces_with_their_roles(surfaces):
    roles = [surface.role for surface in surfaces]
    assert [roles.count(role) for role in ("horizon", "fault", "wall")] == [3, 2, 6]
    assert sum(surface.n_triangle for surface in surfaces) == 48_903
    for surface in surfaces:
        assert len(np.unique(surface.vertices, axis=0)) == surface.n_vertex
    low, high = surfaces[0].bounds[4:]
    assert -100 < low < high < 2000  # the file says depth, down to -3247 m


def test_curves_are_the_shared_borders_and_nothing_else(surfaces):
    curves = gs.intersect_surfaces(surfaces)
    edges = [edge_set(surface) for surface in surfaces]
    assert curves.n_curve > 30
    ends = curves.points[curves.segments]
    for pair, (a, b) in zip(curves.surfaces_of_segment.tolist(), ends.tolist(), strict=True):
        edge = frozenset([tuple(a), tuple(b)])
        assert edge in edges[pair[0]]
        assert edge in edges[pair[1]]
    assert not [contact for contact in curves.contacts if contact.kind == "area"]


def test_nothing_is_cut(patches):
    assert patches.report["cut_triangles"] == 0
    assert patches.n_patch == 55  # the TFACEs of the file
    assert certify(patches).ok


def test_eight_units_fill_the_box_and_are_the_regions_of_the_file(patches, path):
    units = gs.carve_units(patches)
    assert certify(patches, units).ok
    regions = region_volumes(path)
    assert len(units) == len(regions) == 8
    np.testing.assert_allclose(
        sorted(unit.volume for unit in units.values()), sorted(regions.values()), rtol=1e-11
    )
    assert units.report["clipped"] == ()  # throw is no crossing of horizons
    for name, volume in regions.items():  # H2b_1: on top of it lies H2b
        layer = {"H0b": 0, "H1b": 1, "H2b": 2, "H3b": 3}[name.split("_")[0]]
        near = [u for u in units.values() if math.isclose(u.volume, volume, rel_tol=1e-9)]
        assert [unit.zone_index for unit in near] == [layer]


def edge_set(surface):
    """All edges, as sets of two places."""
    x = [tuple(p) for p in surface.vertices.tolist()]
    return {
        frozenset([x[t[k]], x[t[k - 1]]])
        for t, k in itertools.product(surface.triangles.tolist(), range(3))
    }


def region_volumes(path) -> dict[str, float]:
    """Volume inside the signed TFACE lists of each REGION, straight from the lines of the file."""
    faces, regions, rows, points = [], {}, None, {}
    lines = iter(path.read_text().splitlines())
    for line in lines:
        words = line.split()
        if words[:1] == ["REGION"]:
            listed = []
            while "0" not in listed:
                listed += next(lines).split()
            regions[words[2]] = [int(word) for word in listed[:-1]]
        elif words == ["TFACE"]:
            rows = []
            faces.append(rows)
        elif words[:1] in (["VRTX"], ["PVRTX"]):
            points[words[1]] = [float(word) for word in words[2:5]]
        elif words[:1] in (["ATOM"], ["PATOM"]):
            points[words[1]] = points[words[2]]
        elif words[:1] == ["TRGL"]:
            rows.append([points[word] for word in words[1:4]])
    corners = [np.array(rows) for rows in faces]
    flux = [np.einsum("ij,ij->", c[:, 0], np.cross(c[:, 1], c[:, 2])) / 6 for c in corners]
    volumes = {
        name: abs(math.fsum(math.copysign(1, k) * flux[abs(k) - 1] for k in listed))
        for name, listed in regions.items()
    }
    volumes.pop("Universe")
    return volumes


def test_its_regions_are_units_and_come_back(path, tmp_path):
    units = gs.read_units(path)
    volumes = {unit.name: unit.volume for unit in units.values()}
    assert volumes == pytest.approx(read_regions(path), rel=1e-13)
    assert {unit.zone for unit in units.values()} == {"H1b", "H2b", "H3b", "model3b_boundary"}

    # what is written has the same faces: each between the same units
    back = gs.read_units(gs.write(units, tmp_path / "again.ml")[0])
    assert {unit.name: unit.volume for unit in back.values()} == pytest.approx(volumes, rel=1e-13)
    pairs = [Counter(map(tuple, one.sides.tolist())) for one in (units, back)]
    assert pairs[0] == pairs[1]
