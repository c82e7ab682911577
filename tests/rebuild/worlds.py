"""Small worlds at random: lattices, upright ones, loose triangles, planes; known by a number."""

from __future__ import annotations

import numpy as np

from geosurf import Lattice, TriSurface
from tests.strategies import UTM, as_list, sheet, soup


def axes(rng, n_row, n_col):
    """Whole or uneven axes, rising or falling."""
    out = []
    for n in (n_col, n_row):
        steps = np.ones(n) if rng.random() < 0.6 else rng.choice([0.5, 1.0, 1.25], n)
        axis = np.cumsum(steps) - 2.0
        out.append(axis[::-1] if rng.random() < 0.3 else axis)
    return out


def holed(rng, values):
    """Some values not-a-number, alone or a whole corner; a zero may be negative."""
    out = np.where(rng.random(values.shape) < rng.choice([0.0, 0.1, 0.3]), np.nan, values)
    if rng.random() < 0.2:
        out[: len(out) // 2, : out.shape[1] // 3] = np.nan
    return np.where((out == 0) & (rng.random(out.shape) < 0.3), -0.0, out)


def size(rng):
    """Rows and columns of nodes: mostly less than a block of the trees, some more."""
    most = 22 if rng.random() < 0.04 else 5
    return int(rng.integers(2, most)), int(rng.integers(2, most))


def flat_lattice(rng, name):
    """A graph over axes, or over a sheared map, of whole heights or with decimals."""
    n_row, n_col = size(rng)
    easting, northing = axes(rng, n_row, n_col)
    z = rng.integers(0, 3, (n_row, n_col)).astype(float)
    if rng.random() < 0.3:
        z += rng.normal(0, 0.2, z.shape)
    z = holed(rng, z) if rng.random() < 0.6 else z
    if rng.random() < 0.4:
        x, y = np.meshgrid(easting, northing)
        easting, northing = x + rng.choice([0, 0.5, 1]) * y, y - rng.choice([0, 0.25]) * x
        if rng.random() < 0.5:
            easting = holed(rng, easting)
    lattice = Lattice(easting, northing, z, bool(rng.integers(2)), rng.choice([None, True, False]))
    return TriSurface(name, "horizon", lattice=lattice)


def steep_lattice(rng, name):
    """Rows along a line in the map, columns down: upright, folded over, or closed in a ring."""
    n_row, n_col = size(rng)
    kind = rng.integers(3)
    along = np.arange(n_col) - 1.0
    down = np.arange(n_row, dtype=float)[:, None]
    if kind == 0:
        easting = along + 0 * down
        northing = rng.integers(-1, 2) * along + rng.integers(0, 3) + 0.5 * down
    elif kind == 1:
        easting = np.abs(along - 2) + rng.integers(0, 2) * 0.5 * down
        northing = rng.choice([0.5, 1.0]) * along + 0 * down
    else:
        ring = np.array([[0, 0], [2, 0], [3, 1], [2, 3], [0, 2]], dtype=float)
        ring = ring[np.arange(n_col) % 5]
        easting, northing = ring[:, 0] + 0 * down, ring[:, 1] + 0 * down
    z = 4.0 - down - rng.integers(0, 2, n_col) * 0.5 + 0 * easting
    z = holed(rng, z) if rng.random() < 0.4 else z
    lattice = Lattice(easting, northing, z, bool(rng.integers(2)), bool(rng.integers(2)))
    return TriSurface(name, "fault", lattice=lattice)


def loose(rng, name):
    """Separate triangles with corners in 0..3, or with decimals."""
    corners = rng.integers(0, 4, (int(rng.integers(1, 9)), 3, 3)).astype(float)
    if rng.random() < 0.3:
        corners += rng.normal(0, 0.3, corners.shape)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    corners = corners[normal.any(axis=1)]
    return soup(name, corners if len(corners) else [[(0, 0, 0), (3, 0, 1), (0, 3, 2)]])


def plane(rng, name):
    """A plane fault of few large triangles."""
    at, lean = rng.integers(0, 4), rng.integers(-1, 2)
    corners = np.array([(at - lean, -1, -5), (at - lean, 5, -5), (at + lean, 5, 9)], dtype=float)
    corners = np.vstack([corners, corners[0] + corners[2] - corners[1]])
    corners[:, :2] = corners[:, :2] if rng.random() < 0.5 else corners[:, 1::-1]
    return sheet(name, corners, tuple(rng.integers(1, 4, 2)))


def shifted(surface, offset):
    """The same surface somewhere else."""
    of = surface.lattice
    if of is None:
        return TriSurface(surface.name, surface.role, surface.vertices + offset, surface.triangles)
    moved = (
        getattr(of, k) + d
        for k, d in zip(("easting", "northing", "elevation"), offset, strict=True)
    )
    return TriSurface(surface.name, surface.role, lattice=Lattice(*moved, of.rising, of.reverse))


def again(surface):
    """The same surface, of which nothing is remembered."""
    if surface.lattice is None:
        return as_list(surface)
    of = surface.lattice
    parts = of.easting, of.northing, of.elevation, of.rising, of.reverse
    return TriSurface(surface.name, surface.role, lattice=Lattice(*parts))


def world(seed):
    """Two or three surfaces in contact, likely."""
    rng = np.random.default_rng([11, seed])
    makers = [flat_lattice, flat_lattice, steep_lattice, loose, plane]
    some = [
        makers[rng.integers(len(makers))](rng, name) for name in ("A", "B", "C")[rng.integers(2) :]
    ]
    if rng.random() < 0.2:
        some = [shifted(s, np.array(UTM)) for s in some]
    return [s for s in some if s.n_triangle]


def boxed_world(seed):
    """One or two horizons over `BOX`, and up to two faults."""
    rng = np.random.default_rng([12, seed])
    out = []
    for k in range(rng.integers(1, 3)):
        n = int(rng.choice([3, 3, 3, 3, 4, 4, 4, 7, 7, 19]))
        axis = np.linspace(-1.0, 5.0, n)
        z = rng.integers(0, 3, (n, n)) - (2.0 if rng.random() < 0.7 else 1.0) * k
        if rng.random() < 0.3:
            z += rng.normal(0, 0.1, z.shape)
        if rng.random() < 0.15:
            z = holed(rng, z)
        grids = (axis, axis[:: rng.choice([-1, 1])])
        if rng.random() < 0.3:
            x, y = np.meshgrid(*grids)
            grids = (1.5 * (x - 2) + 0.25 * (y - 2) + 2, 1.5 * (y - 2) - 0.25 * (x - 2) + 2)
        lattice = Lattice(*grids, z, bool(rng.integers(2)))
        out.append(TriSurface(f"H{k + 1}", "horizon", lattice=lattice))
    makers = [plane, steep_lattice, loose]
    for k in range(rng.integers(0, 3)):
        fault = makers[rng.integers(3)](rng, f"F{k + 1}")
        out.append(fault.renamed(fault.name, "fault"))
    return [s for s in out if s.n_triangle]
