"""Count broken promises over small worlds: ``python -m tests.rebuild.many [worlds] [seconds]``.

Each world has two or three surfaces, as lattices where they have one, and is rebuilt by trees and
by voxels, as lattices and as lists, some in two orders; every sixteenth is cut by walls and
carved. With the folder `verify` on the path, its exact test of conformity is asked, too. It stops
after so many seconds, if they are given; a third number is the first seed. Ends with 1 if a
promise is broken.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from geosurf import Lattice, TriSurface, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import GeosurfError, InvariantError
from tests import laws, oracles
from tests.strategies import BOX, UTM, sheet, soup

BYTES = ("local", "triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle")


# ------------------------------------------------------------------- surfaces
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


def as_list(surface):
    """The same surface without its lattice."""
    return TriSurface(surface.name, surface.role, surface.vertices, surface.triangles)


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


# --------------------------------------------------------------------- promises
def itself(surfaces):
    """Whether one of them may meet itself."""
    return any(s.lattice is None or not s.lattice.is_graph for s in surfaces)


def attempt(surfaces, **options):
    """Patches, or the class of the refusal."""
    try:
        return rebuild_surfaces(surfaces, self_intersections=itself(surfaces), **options)
    except InvariantError:
        raise
    except GeosurfError as error:
        return type(error)


def pieces(patches):
    """All triangles in order: surface, parent and patch, then corners."""
    corners = patches.local[patches.triangles] + patches.origin + 0.0
    order = np.lexsort(corners.transpose(2, 0, 1), axis=1)
    corners = np.take_along_axis(corners, order[:, :, None], axis=1).reshape(-1, 9)
    which = (patches.surface_of_triangle, patches.parent_of_triangle, patches.patch_of_triangle)
    rows = np.column_stack([*which, corners])
    return rows[np.lexsort(rows.T[::-1])]


def rebuilt(surfaces, thorough=False):
    """Patches with all promises kept, or None where they are refused in every form."""
    if len(surfaces) > 2 and not itself(surfaces[:2]):
        attempt(surfaces[:2])  # so that trees of a part of a lattice are remembered
    one = attempt(surfaces, method="tree")
    lists = attempt([as_list(s) for s in surfaces], method="voxels")
    if isinstance(one, type):
        assert one == lists, (one, lists)
        return None
    assert not isinstance(lists, type), lists
    np.testing.assert_array_equal(pieces(one), pieces(lists))
    if thorough:
        assert certify(one).ok, str(certify(one))
        two = attempt([again(s) for s in surfaces], method="voxels")
        for name in BYTES:
            assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name
        laws.assert_shares_vertices(one)
        laws.assert_on_parents(one, 1e-8 if one.origin.any() else 1e-9)
        laws.assert_same_patches(one, attempt([again(s) for s in surfaces[::-1]]))
    return one


def conforming(patches, oracle):
    """Nothing meets but in corners and edges, says somebody else."""
    corners = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    found = oracle((patches.local, corners))
    assert len(found) == 0, found


def assert_cells(patches, units):
    """As many cells as the rank of the triangles inside says, where it is not too long to ask."""
    west, east, south, north, bottom, top = BOX
    inside = (patches.vertices >= (west, south, bottom)) & (patches.vertices <= (east, north, top))
    triangles = patches.triangles[inside.all(axis=1)[patches.triangles].all(axis=1)]
    if len(triangles) < 700:
        assert units.report["cells"] == oracles.n_cell(triangles)


def carved(surfaces, thorough):
    """Units that fill the box, the same from lattices and from lists; None where refused."""
    given = [*surfaces, *build_walls(BOX)]
    patches = rebuilt(given, thorough)
    if patches is None:
        return None
    found = []
    for one in (patches, attempt([as_list(s) for s in given])):
        try:
            units = carve_units(one)
        except InvariantError:
            raise
        except GeosurfError as error:
            found.append(type(error))
            continue
        if not found:
            assert_cells(one, units)
            laws.assert_volumes_add_up(units, BOX)
            assert certify(one, units).ok, str(certify(one, units))
        found.append({name: (u.volume, u.area) for name, u in units.items()})
    if isinstance(found[0], type):
        assert found[0] == found[1], found
        return None
    assert list(found[0]) == list(found[1]), found
    lattices, lists = (np.array(list(f.values())) for f in found)
    np.testing.assert_allclose(lattices, lists, rtol=1e-11, atol=1e-11)
    return found[0]


def check(seed, oracle=None):
    """What became of one world: "rebuilt", "carved" or "refused"; an error if it is wrong."""
    if seed % 16 == 7:
        return "refused" if carved(boxed_world(seed), seed % 32 == 7) is None else "carved"
    patches = rebuilt(world(seed), seed % 4 == 0)
    if patches is not None and oracle is not None and seed % 2:
        conforming(patches, oracle)
    return "refused" if patches is None else "rebuilt"


def main(arguments: list[str]) -> int:
    total = int(arguments[0]) if arguments else 10_000
    seconds = float(arguments[1]) if len(arguments) > 1 else float("inf")
    first = int(arguments[2]) if len(arguments) > 2 else 0
    try:
        from verify import nonconforming_pairs as oracle
    except ImportError:
        oracle = None
    start, done = time.monotonic(), Counter()
    for seed in range(first, first + total):
        if time.monotonic() - start > seconds:
            break
        try:
            done[check(seed, oracle)] += 1
        except Exception as error:  # whatever it is, it is counted as wrong
            done["wrong"] += 1
            words = " ".join(str(error).split())[:200]
            sys.stdout.write(f"world {seed}: {type(error).__name__}: {words}\n")
    counts = ", ".join(f"{n} {word}" for word, n in sorted(done.items()))
    sys.stdout.write(f"{done.total()} worlds: {counts}; {time.monotonic() - start:.0f} s\n")
    return int(done["wrong"] > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
