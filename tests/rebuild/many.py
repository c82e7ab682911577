"""Count broken promises over small worlds: ``python -m tests.rebuild.many [worlds] [seconds]``.

Each world has two or three surfaces, as lattices where they have one, and is rebuilt by trees and
by voxels, as lattices and as lists, some in two orders; every sixteenth is cut by walls and
carved. Two refusals are right, where slow and obvious arithmetic agrees: a horizon leaks, at that
place and along that much of its rim, or nothing of it is in the box. Any other is a broken promise.
With the folder `verify` on the path, its exact test of conformity is asked, too. It stops after so
many seconds, if they are given; a third number is the first seed. Ends with 1 if a promise is
broken.
"""

from __future__ import annotations

import re
import sys
from fractions import Fraction
from itertools import combinations

import numpy as np

from geosurf import build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.conventions import length_text
from geosurf.errors import GeometryError, GeosurfError, InvariantError, OpenUnitError
from tests import laws, oracles
from tests.counting import count
from tests.rebuild import spaces
from tests.rebuild.worlds import again, boxed_world, world
from tests.strategies import BOX, as_list

ENDS = ("rebuilt", "carved", "open", "beyond", "empty")
MOST = 700  # triangles that slow oracles are asked about


# --------------------------------------------------------------------- promises
def itself(surfaces):
    """Whether one of them may meet itself."""
    return any(s.lattice is None or not s.lattice.is_graph for s in surfaces)


def attempt(surfaces, **options):
    """Patches, or the refusal."""
    try:
        return rebuild_surfaces(surfaces, self_intersections=itself(surfaces), **options)
    except InvariantError:
        raise
    except GeosurfError as error:
        return error


def pieces(patches):
    """All triangles in order: surface, parent and patch, then corners."""
    corners = patches.local[patches.triangles] + patches.origin + 0.0
    order = np.lexsort(corners.transpose(2, 0, 1), axis=1)
    corners = np.take_along_axis(corners, order[:, :, None], axis=1).reshape(-1, 9)
    which = (patches.surface_of_triangle, patches.parent_of_triangle, patches.patch_of_triangle)
    rows = np.column_stack([*which, corners])
    return rows[np.lexsort(rows.T[::-1])]


def rebuilt(surfaces, thorough=False):
    """Patches with all promises kept, the same in every form; no refusal is known to be right."""
    if len(surfaces) > 2 and not itself(surfaces[:2]):
        attempt(surfaces[:2])  # so that trees of a part of a lattice are remembered
    one = attempt(surfaces, method="tree")
    lists = attempt([as_list(s) for s in surfaces], method="voxels")
    assert not isinstance(one, GeosurfError), f"refused: {one}"
    assert not isinstance(lists, GeosurfError), f"refused: {lists}"
    np.testing.assert_array_equal(pieces(one), pieces(lists))
    if thorough:
        assert certify(one).ok, str(certify(one))
        two = attempt([again(s) for s in surfaces], method="voxels")
        laws.assert_same_bytes(one, two)
        laws.assert_shares_vertices(one)
        laws.assert_on_parents(one, 1e-8 if one.origin.any() else 1e-9)
        laws.assert_same_patches(one, attempt([again(s) for s in surfaces[::-1]]))
    return one


def conforming(patches, oracle):
    """Nothing meets but in corners and edges, says somebody else."""
    corners = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    found = oracle((patches.local, corners))
    assert len(found) == 0, found


def inner(patches):
    """Rows of triangles in the box, its sides included."""
    west, east, south, north, bottom, top = BOX
    low, high = np.array([west, south, bottom]), np.array([east, north, top])
    inside = ((patches.vertices >= low) & (patches.vertices <= high)).all(axis=1)
    return np.flatnonzero(inside[patches.triangles].all(axis=1))


def assert_cells(patches, units):
    """As many cells as the rank of the triangles inside says, each in one unit, where it is not too
    long to ask.
    """
    rows = inner(patches)
    if len(rows) > MOST:
        return
    triangles = patches.triangles[rows]
    assert units.report["cells"] == oracles.n_cell(triangles)
    unit_of = {0: -1}
    for parts, of in zip(
        spaces.beside(patches.local, triangles).tolist(), units.sides[rows].tolist(), strict=True
    ):
        for part, unit in zip(parts, of, strict=True):
            assert unit_of.setdefault(part, unit) == unit, f"part {part} is in two units"
    assert set(unit_of.values()) == {-1, *range(len(units))}


def rims(patches):
    """(surface, ends, triangle) of the edges of one triangle of a horizon, off the walls."""
    of_edge: dict[tuple[int, int], set[tuple[int, ...]]] = {}
    owner = {}
    for row in inner(patches).tolist():
        corners = sorted(patches.triangles[row].tolist())
        for edge in combinations(corners, 2):
            of_edge.setdefault(edge, set()).add(tuple(corners))
            owner[edge] = row
    horizons = [i for i, s in enumerate(patches.sources) if s.role == "horizon"]
    out = []
    for edge, triangles in of_edge.items():
        surface = int(patches.surface_of_triangle[owner[edge]])
        if len(triangles) == 1 and surface in horizons:
            out.append((surface, patches.vertices[list(edge)], owner[edge]))
    return out


def above_and_below(patches, rows, parts, surface):
    """Parts of space above triangles of a horizon, and below."""
    mine = patches.surface_of_triangle[rows] == surface
    x = patches.sources[surface].vertices[patches.sources[surface].triangles]
    up = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])[:, 2] > 0
    up = up[patches.parent_of_triangle[rows[mine]]]
    parts = np.where(up[:, None], parts[mine], parts[mine][:, ::-1])
    return set(parts[:, 0].tolist()), set(parts[:, 1].tolist())


def assert_open(patches, error):
    """A part of space lies above the horizon and below it, and not above a younger one, which may
    take it away; the place of the leak is in the middle of an edge of its rim, in such parts, and
    the length told is that of these edges.
    """
    (name,) = error.surfaces
    surface = patches.names.index(name)
    rows = inner(patches)
    parts = spaces.beside(patches.local, patches.triangles[rows])
    above, below = above_and_below(patches, rows, parts, surface)
    if "cannot determine whether" in str(error):
        assert_not_told(above, below, parts[patches.surface_of_triangle[rows] != surface])
        return
    leaking = (above & below) - {0}
    for younger in range(surface):
        over, under = above_and_below(patches, rows, parts, younger)
        leaking -= over - under
    assert leaking, f"{name} does not leak"
    beside = dict(zip(rows.tolist(), parts.tolist(), strict=True))
    ends = [x for i, x, row in rims(patches) if i == surface and leaking & set(beside[row])]
    at = np.abs(np.mean(ends, axis=1) - error.place).max(axis=1)
    assert at.min() < 1e-9, f"{error.place} is not on the rim of {name}"
    told = re.search(r"([0-9.e+-]+ k?m) of its rim", str(error)).group(1)
    whole = float(np.linalg.norm(np.diff(ends, axis=1), axis=2).sum())
    near = {length_text(whole * (1.0 + share)) for share in (-1e-5, 0.0, 1e-5)}
    assert told in near, (told, whole)  # three digits, as messages state lengths


def assert_not_told(above, below, pairs):
    """Parts of space that a horizon is not in, and around them some above it and some below."""
    untold = set(pairs.ravel().tolist()) - above - below - {0}
    around = [pair - untold - {0} for pair in map(set, pairs.tolist()) if pair & untold]
    assert any(part & above for part in around), "nothing around is above"
    assert any(part & below for part in around), "nothing around is below"


def has_area_in_box(surface):
    """Whether a triangle has more than an edge in the box, exactly."""
    low, high = ([Fraction(value) for value in BOX[k::2]] for k in (0, 1))
    axes = [tuple(Fraction(int(i == k)) for i in range(3)) for k in range(3)]
    for corners in surface.vertices[surface.triangles]:
        points = oracles.rational(corners)
        for axis in axes:
            points = oracles.clip(points, axis, tuple(low))
            points = oracles.clip(points, tuple(-value for value in axis), tuple(high))
        if len(points) > 2:
            return True
    return False


def assert_beyond(patches, error):
    """Nothing of the horizon is in the box but points and edges."""
    (name,) = error.surfaces
    source = patches.sources[patches.names.index(name)]
    assert "does not reach the model box" in str(error), error
    assert not has_area_in_box(source), f"{name} is in the box"


def assert_sealed(patches, units):
    """A rim in the box is only where a younger horizon took the horizon away."""
    zones = [unit.zone_index for unit in units.values()]
    for surface, ends, row in rims(patches):
        beside = [zones[u] for u in units.sides[row]]
        assert max(beside) <= surface - 1, f"horizon {surface} ends in the box at {ends}"


def carved(surfaces, thorough):
    """Units that fill the box, the same from lattices and from lists; or the refusal."""
    given = [*surfaces, *build_walls(BOX)]
    patches = rebuilt(given, thorough)
    found = []
    for one in (patches, attempt([as_list(s) for s in given])):
        try:
            units = carve_units(one)
        except InvariantError:
            raise
        except OpenUnitError as error:
            assert_open(one, error)
            found.append(error)
            continue
        except GeometryError as error:
            assert_beyond(one, error)
            found.append(error)
            continue
        if not found:
            assert_cells(one, units)
            assert_sealed(one, units)
            laws.assert_volumes_add_up(units, BOX)
            assert certify(one, units).ok, str(certify(one, units))
        found.append({name: (u.volume, u.area) for name, u in units.items()})
    if isinstance(found[0], GeosurfError):
        assert str(found[0]) == str(found[1]), found
        return found[0]
    assert list(found[0]) == list(found[1]), found
    lattices, lists = (np.array(list(f.values())) for f in found)
    np.testing.assert_allclose(lattices, lists, rtol=1e-11, atol=1e-11)
    return found[0]


def check(seed, oracle=None):
    """What became of one world: "rebuilt", "carved", "open" where a horizon leaks, "beyond" where
    one is not in the box, or "empty"; an error if it is wrong, or refused and should not be.
    """
    boxed = seed % 16 == 7
    surfaces = boxed_world(seed) if boxed else world(seed)
    if not surfaces:
        return "empty"
    if boxed:
        found = carved(surfaces, seed % 32 == 7)
        if isinstance(found, GeometryError):  # an oracle agreed
            return "open" if isinstance(found, OpenUnitError) else "beyond"
        return "carved"
    found = rebuilt(surfaces, seed % 4 == 0)
    if oracle is not None and seed % 2:
        conforming(found, oracle)
    return "rebuilt"


if __name__ == "__main__":
    try:
        from verify import nonconforming_pairs as oracle
    except ImportError:
        oracle = None
    sys.exit(count(lambda seed: check(seed, oracle)))
