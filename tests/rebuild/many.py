"""Count broken promises over small worlds: ``python -m tests.rebuild.many [worlds] [seconds]``.

Each world has two or three surfaces, as lattices where they have one, and is rebuilt by trees and
by voxels, as lattices and as lists, some in two orders; every sixteenth is cut by walls and
carved. Where a horizon is open in the box, that must be said, at a place of its rim, and not
where it is closed. With the folder `verify` on the path, its exact test of conformity is asked,
too. It stops after so many seconds, if they are given; a third number is the first seed. Ends
with 1 if a promise is broken; worlds that are refused for another reason are told.
"""

from __future__ import annotations

import re
import sys
import time
from collections import Counter
from itertools import combinations

import numpy as np

from geosurf import build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.errors import GeometryError, GeosurfError, InvariantError, OpenUnitError
from tests import laws, oracles
from tests.rebuild.worlds import again, as_list, boxed_world, world
from tests.strategies import BOX

ENDS = ("rebuilt", "carved", "open", "empty")
BYTES = ("local", "triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle")


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
    """Patches with all promises kept, or a refusal, the same in every form."""
    if len(surfaces) > 2 and not itself(surfaces[:2]):
        attempt(surfaces[:2])  # so that trees of a part of a lattice are remembered
    one = attempt(surfaces, method="tree")
    lists = attempt([as_list(s) for s in surfaces], method="voxels")
    if isinstance(one, GeosurfError):
        assert type(one) is type(lists), (one, lists)
        return one
    assert not isinstance(lists, GeosurfError), lists
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


def rims(patches):
    """(surface, ends, triangle) of the edges of one triangle of a horizon, off the walls."""
    west, east, south, north, bottom, top = BOX
    low, high = np.array([west, south, bottom]), np.array([east, north, top])
    inside = ((patches.vertices >= low) & (patches.vertices <= high)).all(axis=1)
    rows = np.flatnonzero(inside[patches.triangles].all(axis=1))
    of_edge: dict[tuple[int, int], set[tuple[int, ...]]] = {}
    owner = {}
    for row in rows.tolist():
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


def assert_open(patches, error):
    """The place of a leak is on the rim of the horizon, and its length is that of such edges."""
    (name,) = error.surfaces
    ends = [x for surface, x, _ in rims(patches) if patches.names[surface] == name]
    at = np.abs(np.mean(ends, axis=1) - error.place).max(axis=1)
    assert at.min() < 1e-9, f"{error.place} is not on the rim of {name}"
    told = float(re.search(r"([0-9.e+-]+) m of its rim", str(error)).group(1))
    whole = np.linalg.norm(np.diff(ends, axis=1), axis=2).sum()
    assert 0 < told <= whole * (1 + 1e-5), (told, whole)


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
    if isinstance(patches, GeosurfError):
        return patches
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
        except GeometryError as error:  # a horizon with nothing in the box, or but a point of it
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
    """What became of one world: "rebuilt", "carved", "open" where a horizon leaks (and does),
    "empty", or a sentence that refuses it; an error if it is wrong.
    """
    boxed = seed % 16 == 7
    surfaces = boxed_world(seed) if boxed else world(seed)
    if not surfaces:
        return "empty"
    if boxed:
        found = carved(surfaces, seed % 32 == 7)
        return "open" if isinstance(found, OpenUnitError) else _word(found, "carved")
    found = rebuilt(surfaces, seed % 4 == 0)
    if not isinstance(found, GeosurfError) and oracle is not None and seed % 2:
        conforming(found, oracle)
    return _word(found, "rebuilt")


def _word(found, word):
    return f"{type(found).__name__}: {found}" if isinstance(found, GeosurfError) else word


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
            word = check(seed, oracle)
            done[word if word in ENDS else "refused"] += 1
            if word not in ENDS:
                sys.stdout.write(f"world {seed}: refused, {' '.join(word.split())[:200]}\n")
        except Exception as error:  # whatever it is, it is counted as wrong
            done["wrong"] += 1
            words = " ".join(str(error).split())[:200]
            sys.stdout.write(f"world {seed}: {type(error).__name__}: {words}\n")
    counts = ", ".join(f"{n} {word}" for word, n in sorted(done.items()))
    sys.stdout.write(f"{done.total()} worlds: {counts}; {time.monotonic() - start:.0f} s\n")
    return int(done["wrong"] > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
