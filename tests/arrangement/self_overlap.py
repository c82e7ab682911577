"""Soups that coincide, cross and touch.

``python -m tests.arrangement.self_overlap [soups] [seconds] [first]``.

One to three surfaces of triangles with corners on a small lattice, from few planes, so that they
coincide with themselves and each other, in part and wholly, turned and not, and other triangles
cross such areas, end on them and touch them. Some are welded, some closed, some are grids.
Exact arithmetic of our
own (`tests.overlaps`) says what the curves, the touching points and the areas are, of each pair and
of each surface with itself; what was rebuilt must tile its parents, cross nothing, and share the
areas. With libigl installed, the number of vertices and triangles is compared with its own; with
the folder `verify` beside the checkout (GEOSURF_SHARED), its checks of curves, pieces and
conformity are asked. Ends with 1 if an answer is wrong, or refused without a place.
"""

from __future__ import annotations

import itertools
import sys
from importlib import import_module

import numpy as np

from benchmarks.stress.shapes import grid
from geosurf import TriSurface, build_walls, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.errors import GeosurfError, InvariantError
from tests import laws, oracles
from tests.counting import count
from tests.field_data import checked
from tests.overlaps import together

NEAR = 1e-9
SHIFTS = ((0, 0, 0), (456_000.0, 6_780_000.0, -2_048.0))


# ------------------------------------------------------------------------ soups
def soup(seed: int) -> list[TriSurface]:
    """The surfaces of a case, by its seed."""
    rng = np.random.default_rng([97, seed])
    n_surface = int(rng.choice([1, 2, 2, 3]))
    extent = int(rng.integers(2, 5))
    pool = [t for t in (triangle(rng, extent) for _ in range(60)) if t is not None]
    scale, shift = 2.0 ** rng.integers(-2, 3), np.array(SHIFTS[int(rng.integers(4)) == 0])
    out = []
    for _ in range(n_surface):
        mine = [pool[k] for k in rng.integers(0, len(pool), int(rng.integers(1, 5)))]
        if out and rng.random() < 0.7:  # some that another one has
            others = out[int(rng.integers(len(out)))]
            mine += [others[k] for k in rng.integers(0, len(others), int(rng.integers(1, 3)))]
        if rng.random() < 0.25:  # twice in one
            mine.append(mine[0])
        if rng.random() < 0.1:
            mine += closed(rng)
        out.append([np.roll(t, rng.integers(3), axis=0)[:: rng.choice([-1, 1])] for t in mine])
    found = [
        surface(name, np.array(mine) * scale + shift, bool(rng.integers(2)))
        for name, mine in zip("ABC", out, strict=False)
    ]
    if seed % 5 == 4:  # grids, which are searched in other ways
        found[0] = relief("A", rng, scale, shift)
        found[1:2] = [relief("B", rng, scale, shift)] if len(found) > 1 else []
    return found


def triangle(rng, extent: int):
    """A triangle on the lattice, mostly in one of a few planes; None if it has no area."""
    corners = rng.integers(0, extent + 1, (3, 3)).astype(float)
    kind = rng.integers(5)
    if kind < 3:
        corners[:, kind] = rng.integers(0, 2)
    elif kind == 3:
        corners[:, 2] = corners[:, 0]
    return None if oracles.flat(corners) else corners


def relief(name: str, rng, scale: float, shift) -> TriSurface:
    """A grid of 3 x 3 nodes: over the map, upright, or folded; sometimes level."""
    u, v = np.meshgrid(np.arange(3.0), np.arange(3.0))
    while True:
        z = rng.integers(0, 3, (3, 3)) if rng.random() < 0.6 else np.ones((3, 3))
        nodes = [(u, v, z), (u, z, v), (rng.integers(0, 3, (3, 3)), v, z)][int(rng.integers(3))]
        nodes = [scale * x + at for x, at in zip(nodes, shift, strict=True)]
        try:
            found = grid(name, *nodes, role="fault", rising=bool(rng.integers(2)))
        except GeosurfError:
            continue  # triangles without area, as a lattice
        if not any(oracles.flat(t) for t in found.vertices[found.triangles]):
            return found


def closed(rng) -> list[np.ndarray]:
    """A box or a tetrahedron."""
    if rng.integers(2):
        low = rng.integers(0, 2, 3)
        walls = build_walls(tuple(np.stack([low, low + rng.integers(1, 3, 3)], axis=1).ravel()))
        return [t for w in walls for t in w.vertices[w.triangles]]
    corners = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]]) + rng.integers(0, 2, 3)
    return [corners[list(t)].astype(float) for t in itertools.combinations(range(4), 3)]


def surface(name: str, corners: np.ndarray, weld: bool) -> TriSurface:
    """Triangles (n, 3, 3) as a surface, separate or over common vertices."""
    flat, faces = corners.reshape(-1, 3), np.arange(3 * len(corners))
    if weld:
        flat, faces = np.unique(flat, axis=0, return_inverse=True)
    return TriSurface(name, "surface", flat, faces.reshape(-1, 3))


# --------------------------------------------------------------------- judgement
def assert_curves(surfaces, curves, truth) -> None:
    """Curves, touching points and areas are those of `truth`, {(i, j): Together}."""
    laws.assert_curves_are_whole(curves)
    found = {tuple(p) for p in curves.surfaces_of_segment.tolist()}
    found |= {t.surfaces for t in curves.contacts}
    assert found <= set(truth), f"{found} have something in common"
    for (i, j), exact in truth.items():
        what = f"{curves.names[i]} and {curves.names[j]}"
        mine = (curves.surfaces_of_segment == (i, j)).all(axis=1)
        assert_lines(what, curves.points[curves.segments[mine]], exact.curves)
        touches = [t for t in curves.contacts if t.surfaces == (i, j)]
        area = sum(t.area for t in touches if t.kind == "area")
        assert abs(area - exact.area) <= NEAR * (1 + area), f"{what}: {area} m2, not {exact.area}"
        points = np.array([t.points[0] for t in touches if t.kind == "point"]).reshape(-1, 3)
        true = floats(exact.points)
        assert len(points) == len(true), f"{what}: touch in {points.tolist()}, not {true.tolist()}"
        for p in true:
            assert (np.abs(points - p).max(axis=1) <= NEAR).any(), f"{what}: do not touch at {p}"


def assert_lines(what: str, ends, parts) -> None:
    """Segments (n, 2, 3) cover the parts of lines, each once, and nothing else."""
    true = np.array([floats(part) for part in parts]).reshape(-1, 2, 3)
    covers = on_segments(true.mean(axis=1), ends)
    off = np.flatnonzero(covers.sum(axis=1) != 1)
    assert len(off) == 0, f"{what}: on {covers[off[0]].sum()} curves near {true[off[0]].tolist()}"
    size = np.linalg.norm(true[:, 1] - true[:, 0], axis=1)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    bad = np.flatnonzero(np.abs(size @ covers - length) > NEAR) if len(ends) else []
    assert len(bad) == 0, f"{what}: no curve at {ends[bad[0]].tolist()}"


def on_segments(points, ends) -> np.ndarray:
    """Which points (n, 3) lie on which segments (m, 2, 3)."""
    along, to = ends[:, 1] - ends[:, 0], points[:, None] - ends[:, 0]
    t = np.clip((to * along).sum(axis=2) / (along * along).sum(axis=1), 0, 1)
    far: np.ndarray = np.abs(to - t[:, :, None] * along).max(axis=2)
    return far <= NEAR


def floats(points) -> np.ndarray:
    """Rational points as doubles (n, 3)."""
    return np.array([oracles.rounded(p) for p in points]).reshape(-1, 3)


def assert_patches(surfaces, patches, truth, itself: bool) -> None:
    """Pieces tile their parents, cross nothing of another surface, and share what coincides."""
    laws.assert_on_parents(patches)
    corners, number = np.unique(np.sort(patches.triangles, axis=1), axis=0, return_inverse=True)
    owners = np.zeros((len(corners), len(surfaces)), dtype=bool)
    owners[number.ravel(), patches.surface_of_triangle] = True
    bits = owners @ (1 << np.arange(len(surfaces)))
    one, two = crossing_pairs(patches.local, corners).T
    alone = (bits[one] == bits[two]) & (owners[one].sum(axis=1) == 1)
    assert itself or not (~alone).any(), "pieces of two surfaces cross"
    assert not itself or len(one) == 0, "pieces cross"
    p = patches.local[corners]
    area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
    edges = {}
    for k in range(len(surfaces)):
        t = corners[owners[:, k]]
        edges[k] = {tuple(e) for pair in ((0, 1), (0, 2), (1, 2)) for e in t[:, pair].tolist()}
    for (i, j), exact in truth.items():
        if i == j:
            continue
        what = f"{patches.names[i]} and {patches.names[j]}"
        both = area[owners[:, i] & owners[:, j]].sum()
        assert abs(both - exact.area) <= NEAR * (1 + both), f"{what} share {both}, not {exact.area}"
        ends = patches.vertices[np.array(sorted(edges[i] & edges[j]), dtype=int).reshape(-1, 2)]
        middles = np.array([floats(part).mean(axis=0) for part in exact.curves]).reshape(-1, 3)
        shared = on_segments(middles, ends).any(axis=1)
        assert shared.all(), f"{what} share no edge at {middles[~shared].tolist()[:1]}"


def _area(x: np.ndarray, t: np.ndarray) -> float:
    """Area of triangles."""
    normal = np.cross(x[t[:, 1]] - x[t[:, 0]], x[t[:, 2]] - x[t[:, 0]])
    return 0.5 * float(np.linalg.norm(normal, axis=1).sum())


def assert_as_igl(kit, surfaces, patches) -> bool:
    """As many distinct vertices and triangles as libigl makes.

    False if its own triangles cross or overlap: in areas of points on one circle it takes both
    diagonals. Pieces of ours tile their parents, so a larger area of distinct triangles overlaps.
    """
    first = np.cumsum([0] + [s.n_vertex for s in surfaces])
    faces = np.concatenate([s.triangles + n for s, n in zip(surfaces, first, strict=False)])
    points = np.concatenate([s.vertices for s in surfaces]) - patches.origin
    fine, cut, *_ = kit.remesh_self_intersections(points, faces, stitch_all=True)
    place, number = np.unique(fine + 0.0, axis=0, return_inverse=True)
    cut = np.unique(np.sort(number.ravel()[cut], axis=1), axis=0)
    own = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    ours, theirs = (len(np.unique(own)), len(own)), (len(np.unique(cut)), len(cut))
    if ours == theirs:
        return True
    overlaps = _area(place, cut) > (1.0 + NEAR) * _area(patches.local, own)
    assert overlaps or len(crossing_pairs(place, cut)), (
        f"{ours} vertices and triangles, libigl has {theirs}"
    )
    return False


def check(seed: int, kit=None, verify=None) -> str:
    """What a case was, in a word; an error if an answer is wrong."""
    surfaces = soup(seed)
    n = len(surfaces)
    pairs = list(itertools.combinations_with_replacement(range(n), 2))
    truth = {pair: together(surfaces, *pair) for pair in pairs}
    others = {pair: of for pair, of in truth.items() if pair[0] < pair[1]}
    curves = intersect_surfaces(surfaces, self_intersections=True)
    assert_curves(surfaces, curves, truth)
    if n > 1:
        assert_curves(surfaces, intersect_surfaces(surfaces, method="voxels"), others)
    patches = rebuild_surfaces(surfaces, self_intersections=True)
    assert_patches(surfaces, patches, truth, itself=True)
    assert_patches(surfaces, rebuild_surfaces(surfaces), truth, itself=False)
    if verify is not None:
        assert_verified(verify, surfaces, curves, patches)
    if kit is not None and not assert_as_igl(kit, surfaces, patches):
        return "right, but for libigl, whose own triangles cross"
    areas = [of.area > 0 for of in truth.values()]
    return "with areas" if any(areas) else "without areas"


def assert_verified(verify, surfaces, curves, patches) -> None:
    """The independent checks of curves, pieces and conformity."""
    tol = max(NEAR, 4e-15 * max(np.abs(s.vertices).max() for s in surfaces))
    for i, j in itertools.combinations(range(len(surfaces)), 2):
        meshes = [(s.vertices, s.triangles) for s in (surfaces[i], surfaces[j])]
        mine = curves.segments[(curves.surfaces_of_segment == (i, j)).all(axis=1)]
        used, segments = np.unique(mine, return_inverse=True)
        line = curves.points[used], segments.reshape(-1, 2)
        verify.check_curve(*meshes, *line, tol, degrees=False)
    checked.check_pieces(verify, patches, tol)


def tool(load):
    """What is not installed is left out."""
    try:
        return load()
    except ImportError:
        return None


def is_refused(error: Exception) -> bool:
    """Whether an error is one of ours that names a place."""
    known = isinstance(error, GeosurfError) and not isinstance(error, InvariantError)
    return known and " at (" in str(error)


if __name__ == "__main__":
    kit = tool(lambda: import_module("igl.copyleft.cgal"))
    verify = tool(lambda: checked.kit()[0])
    sys.exit(count(lambda seed: check(seed, kit, verify), refused=is_refused))
