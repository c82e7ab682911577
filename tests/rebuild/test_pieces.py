"""A lattice kept as runs is split as its list of triangles is."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, rebuild_surfaces
from geosurf.model import Lattice
from geosurf.rebuild import drop_triangles, trim_sheets
from geosurf.rebuild.ghosts import kept_parts
from tests import laws
from tests.strategies import as_list


@st.composite
def gridded_scenes(draw):
    """Horizons as lattices of small integers with holes, and a fault as a curtain lattice."""
    surfaces = []
    for name in ("Top", "Base")[: draw(st.integers(1, 2))]:
        n_row, n_col = draw(st.integers(2, 6)), draw(st.integers(2, 6))
        n = n_row * n_col
        z = np.array(draw(st.lists(st.integers(0, 7), min_size=n, max_size=n)), dtype=float)
        z[z < draw(st.sampled_from([0, 1]))] = np.nan
        step = draw(st.sampled_from([1.0, 2.0]))
        lattice = Lattice(
            step * np.arange(n_col), step * np.arange(n_row), z.reshape(n_row, n_col),
            draw(st.booleans()),
        )  # fmt: skip
        if lattice.n_triangle:
            surfaces.append(TriSurface(name, "horizon", lattice=lattice))
    x = np.array(draw(st.lists(st.integers(0, 6), min_size=3, max_size=3)), dtype=float)
    dip = draw(st.sampled_from([0.0, 1.0, 2.0]))
    easting = np.stack([x, x + dip])
    northing = np.tile([-1.0, 3.0, 11.0], (2, 1))
    elevation = np.array([[9.0, 9, 9], [-2.0, -2, -2]])
    fault = Lattice(easting, northing, elevation, draw(st.booleans()), draw(st.booleans()))
    return [*surfaces, TriSurface("F1", "fault", lattice=fault)]


def in_order(patches):
    """Corners by coordinates, surface, parent and patch of all triangles, in a common order."""
    corners = patches.local[patches.triangles]
    columns = [patches.surface_of_triangle, patches.parent_of_triangle]
    rows = np.column_stack([*columns, corners.reshape(-1, 9), patches.patch_of_triangle])
    return rows[np.lexsort(rows[:, :11].T[::-1])]


@given(gridded_scenes())
def test_runs_and_lists_give_the_same_patches(surfaces):
    one, two = rebuild_surfaces(surfaces), rebuild_surfaces([as_list(s) for s in surfaces])
    assert one.report["moved_vertices"] == two.report["moved_vertices"] == 0
    a, b = in_order(one), in_order(two)
    np.testing.assert_array_equal(a, b)
    rims = [
        np.unique(np.sort(p.local[p.curve_edges].reshape(-1, 2, 3), axis=1), axis=0)
        for p in (one, two)
    ]
    np.testing.assert_array_equal(*rims)


def test_a_ring_closes_on_itself():
    """A lattice that ends where it began has no rim there."""
    angle = np.linspace(0, 2 * np.pi, 13)
    x, y = np.cos(angle), np.sin(angle)
    x[-1], y[-1] = x[0], y[0]
    pipe = Lattice(np.tile(x, (4, 1)), np.tile(y, (4, 1)), np.tile([[0.0], [1], [2], [3]], 13))
    flat = TriSurface("Top", "horizon", [[-9, -9, 1.5], [9, -9, 1.5], [0, 9, 1.5]], [[0, 1, 2]])
    patches = rebuild_surfaces([flat, TriSurface("F1", "fault", lattice=pipe)])
    assert patches.n_patch == 4


@given(gridded_scenes(), st.integers(0, 2**32 - 1))
def test_sheets_are_trimmed_without_listing_runs(surfaces, seed):
    rng = np.random.default_rng(seed)
    sheets = []
    for one in map(as_list, surfaces[:-1]):
        outer = rng.random(one.n_vertex) < 0.2
        marks = {"ghost": outer | (rng.random(one.n_vertex) < 0.3), "outer": outer}
        sheets.append(
            TriSurface(one.name, one.role, one.vertices, one.triangles, vertex_data=marks)
        )
    patches = rebuild_surfaces([*sheets, surfaces[-1]])
    trimmed = trim_sheets(patches)
    plain = drop_triangles(patches, kept_parts(patches)[0])
    laws.assert_same_bytes(trimmed, plain)
    assert trimmed.report == plain.report
    assert trimmed.n_patch == plain.n_patch

    # rings are those of the mesh as a whole, as far as it is listed
    pieces = trimmed.pieces
    rows = np.flatnonzero(trimmed.pieces.expanded.element < len(pieces.triangles))
    if len(rows) == trimmed.n_triangle:
        np.testing.assert_array_equal(pieces.ring, plain.pieces.ring)
        np.testing.assert_array_equal(pieces.link, plain.pieces.link)
