"""Inputs as they should not be: an error of ours that says so, or a right answer. Nothing else."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate import certify
from geosurf.errors import SurfaceError
from tests.strategies import grid

WALLS = gs.build_walls((0.5, 3.5, 0.25, 3.25, -5.0, 5.0))


def whole(kind: int, rng) -> tuple[np.ndarray, np.ndarray]:
    """A small mesh: a grid, a soup on a lattice, a soup, two large triangles."""
    if kind == 0:
        n = int(rng.integers(2, 6))
        made = grid("A", 0.5 * rng.integers(-2, 3, (n, n)))
        return made.vertices, made.triangles
    if kind == 3:
        x = np.array([[-1.0, -1.0], [6.0, -1.0], [6.0, 6.0], [-1.0, 6.0]])
        return np.column_stack([x, rng.integers(-2, 3, 4)]), np.array([[0, 1, 2], [0, 2, 3]])
    n = int(rng.integers(1, 8))
    x = rng.integers(0, 4, (3 * n, 3)).astype(float) if kind == 1 else rng.uniform(0, 4, (3 * n, 3))
    return x, np.arange(3 * n).reshape(-1, 3)


def put(array, at, value):
    """A copy with one value changed."""
    out = np.array(array)
    out[at] = value
    return out


def read_only(array):
    """A read-only view of a copy, every second row of a larger array."""
    out = np.repeat(array, 2, axis=0)[::2]
    out.flags.writeable = False
    return out


DAMAGES = {
    "nothing": lambda x, t: (x, t),
    "nan": lambda x, t: (put(x, (0, 1), np.nan), t),
    "infinite": lambda x, t: (put(x, (-1, 2), -np.inf), t),
    "two columns": lambda x, t: (x[:, :2], t),
    "one row of numbers": lambda x, t: (x.ravel(), t),
    "edges for triangles": lambda x, t: (x, t[:, :2]),
    "indices with fractions": lambda x, t: (x, t + 0.5),
    "a negative index": lambda x, t: (x, put(t, (0, 0), -1)),
    "an index too large": lambda x, t: (x, put(t, (0, 0), len(x))),
    "a huge index": lambda x, t: (x, put(t, (0, 2), 2**62)),
    "every triangle twice": lambda x, t: (x, np.concatenate([t, t])),
    "and turned over": lambda x, t: (x, np.concatenate([t, t[:, ::-1]])),
    "a corner twice": lambda x, t: (x, put(t, (0, 1), t[0, 0])),
    "every vertex twice": lambda x, t: (np.tile(x, (2, 1)), np.concatenate([t, t + len(x)])),
    "Fortran order": lambda x, t: (np.asfortranarray(x), np.asfortranarray(t)),
    "read-only, with strides": lambda x, t: (read_only(x), read_only(t)),
    "no triangles": lambda x, t: (x, t[:0]),
    "one triangle": lambda x, t: (x, t[:1]),
    "nothing at all": lambda x, t: ([], []),
    "huge": lambda x, t: (1e15 * x, t),
    "beyond all bounds": lambda x, t: (1e300 * x, t),
    "tiny": lambda x, t: (1e-200 * x, t),
    "subnormal": lambda x, t: (1e-320 * x, t),
    "one coordinate huge": lambda x, t: (put(x, (0, 0), 1e15), t),
    "one coordinate tiny": lambda x, t: (put(x, (0, 0), 1e-200), t),
    "int8": lambda x, t: (x, t.astype(np.int8)),
    "uint64": lambda x, t: (x, t.astype(np.uint64)),
    "float32": lambda x, t: (x.astype(np.float32), t),
    "objects": lambda x, t: (x.astype(object), t),
    "complex": lambda x, t: (x + 1j, t),
    "words": lambda x, t: (np.full(x.shape, "deep"), t),
    "lists": lambda x, t: (x.tolist(), t.tolist()),
    "UTM": lambda x, t: (x + np.array([456_000.1, 6_780_000.3, -2000.7]), t),
}


def whole_way(first, second):
    """Surfaces, curves, patches and units of two meshes; the certificate."""
    surfaces = [gs.TriSurface("A", "fault", *first), gs.TriSurface("B", "fault", *second)]
    curves = gs.intersect_surfaces(surfaces, self_intersections=True)
    turned = gs.intersect_surfaces(surfaces[::-1], self_intersections=True)
    assert turned.n_curve == curves.n_curve
    assert turned.length == pytest.approx(curves.length, rel=1e-12)
    patches = gs.rebuild_surfaces([*surfaces, *WALLS], self_intersections=True)
    return certify(patches, gs.carve_units(patches))


X, Y, Z = np.arange(4.0), np.arange(3.0), np.zeros((3, 4))


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ((Y, X, Z), r"easting of shape \(3,\), northing \(4,\) and elevation \(3, 4\)"),
        ((np.arange(9.0), Y, Z), r"shape \(9,\).*expected \(n_col,\), \(n_row,\)"),
        ((Z, Y, Z), r"or all \(n_row, n_col\)\."),
        ((X, Y, Z.ravel()), r"and elevation \(12,\)"),
        ((list("abcd"), Y, Z), r"easting of a lattice is not numeric"),
        ((X, Y + 1j, Z), r"northing .*complex.*Give an array of metres"),
        ((X, Y, Z.astype("timedelta64[ms]")), r"elevation .*\(timedelta64\[ms\]\).*of metres"),
    ],
)
def test_lattices_that_do_not_fit_are_refused(parts, words):
    with pytest.raises(SurfaceError, match=words):
        gs.Lattice(*parts)


def test_masked_nodes_are_absent():
    z = np.ma.masked_array(np.zeros((3, 3)), mask=np.eye(3))
    assert gs.Lattice(np.arange(3.0), np.arange(3.0), z).present.sum() == 6
