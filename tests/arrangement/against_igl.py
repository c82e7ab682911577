"""Compare with libigl.

``python -m tests.arrangement.against_igl [scenes] [seconds] [folder] [first]``.

Two surfaces of triangles with corners in 0..3 and, every third time, a closed box inside; walls
around them. The pairs of triangles in contact, the length of the common curve (where they share
no area), and the number of cells, from our triangles and from its own, are those of
`igl.copyleft.cgal`; the number of cells is that of a rank, too (`oracles.n_cell`). libigl is no
dependency: name the folder of site-packages where it lies. Ends with 1 if an answer differs.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from importlib import import_module
from itertools import combinations

import numpy as np

from geosurf import build_walls, carve_units, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement.search import find_contacts
from geosurf.errors import GeosurfError
from geosurf.kernels.contacts.packed_contact import in_plane, n_corners
from tests import oracles
from tests.arrangement.test_upright import codes
from tests.strategies import soup


def scene(seed: int):
    """Two surfaces and a box around them, which they touch one time in two."""
    rng = np.random.default_rng([31, seed])
    out = []
    for name in ("A", "B"):
        corners = rng.integers(0, 4, (int(rng.integers(2, 10)), 3, 3)).astype(float)
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        out.append(soup(name, corners[normal.any(axis=1)]).renamed(name, "fault"))
    low, high = np.sort(rng.choice(np.arange(0, 3.5, 0.5), (3, 2), replace=True), axis=1).T
    if seed % 3 == 0 and (low < high).all():
        shell = build_walls(tuple(np.stack([low, high], axis=1).ravel()))
        out[1] = soup("B", np.concatenate([w.vertices[w.triangles] for w in shell]))
        out[1] = out[1].renamed("B", "fault")
    reach = rng.integers(0, 2)
    return [s for s in out if s.n_triangle], (-reach, 3 + reach) * 3


def our_pairs(surfaces):
    """Pairs of rows of all triangles that meet elsewhere than in common corners, and whether
    the surfaces share no area: where they do, the curve is an outline, which libigl does not tell.
    """
    found = find_contacts(surfaces, self_intersections=True)
    first = np.cumsum([0] + [s.n_triangle for s in surfaces])
    faces = first[found.surface_of_face] + found.key_of_face
    rows = np.sort(faces[found.rows[:, :2]], axis=1)
    code = codes(found.rows)
    corners = (((code >> 3 & 7) < 3) & ((code & 7) < 3) | (code < 0)).all(axis=1)
    area = in_plane(found.rows) & (n_corners(found.rows) > 2)
    own = np.diff(found.surface_of_face[found.rows[:, :2]], axis=1)[:, 0] == 0
    plain = not (area & ~own).any()
    return {tuple(row) for row in rows[~corners].tolist()}, plain


def stacked(surfaces):
    """Vertices and triangles of all surfaces."""
    first = np.cumsum([0] + [s.n_vertex for s in surfaces])
    faces = [s.triangles + n for s, n in zip(surfaces, first, strict=False)]
    return np.concatenate([s.vertices for s in surfaces]), np.concatenate(faces)


def common_length(points, faces, of_second) -> float:
    """Length of the edges that have triangles of both surfaces."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2)
    edges, number = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    both = [np.bincount(number.ravel(), np.repeat(side, 3)) for side in (of_second, ~of_second)]
    ends = points[edges[(both[0] > 0) & (both[1] > 0)]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def welded(points, faces):
    """Each place and each triangle once, without triangles that dangle: they part no cells."""
    points, number = np.unique(points + 0.0, axis=0, return_inverse=True)
    faces = np.sort(number.ravel()[faces], axis=1)
    faces = np.unique(faces[(np.diff(faces, axis=1) > 0).all(axis=1)], axis=0)
    while True:
        edges = np.stack([faces[:, [0, 1]], faces[:, [0, 2]], faces[:, [1, 2]]], axis=1)
        _, number, count = np.unique(
            edges.reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
        )
        held = (count[number.ravel()] > 1).reshape(-1, 3).all(axis=1)
        if held.all():
            return points, faces
        faces = faces[held]


def turned_alike(faces):
    """Triangles turned like their neighbours across edges of two: `extract_cells` counts wrongly
    where they are not. None if a patch has one side only, so that it cannot be.
    """
    faces = faces.tolist()
    of_edge: dict[frozenset[int], list[int]] = {}
    for row, triangle in enumerate(faces):
        for edge in combinations(triangle, 2):
            of_edge.setdefault(frozenset(edge), []).append(row)
    turned: list[list[int] | None] = [None] * len(faces)
    for seed in range(len(faces)):
        stack = [seed] if turned[seed] is None else []
        while stack:
            row = stack.pop()
            mine = turned[row] = turned[row] or faces[row]
            for p, q in zip(mine, mine[1:] + mine[:1], strict=True):
                pair = of_edge[frozenset((p, q))]
                if len(pair) != 2:
                    continue
                other = sum(pair) - row
                (r,) = set(faces[other]) - {p, q}
                if turned[other] is None:
                    turned[other] = [q, p, r]
                    stack.append(other)
                elif [q, p] not in [(2 * turned[other])[k : k + 2] for k in range(3)]:
                    return None
    return np.array(turned)


def compare(seed: int, kit, done: Counter) -> None:
    """Count what is compared, and what differs."""
    surfaces, box = scene(seed)
    if len(surfaces) < 2:
        return
    points, faces = stacked(surfaces)
    _, _, pairs, *_ = kit.remesh_self_intersections(points, faces, detect_only=True)
    theirs = {tuple(sorted(row)) for row in np.asarray(pairs).reshape(-1, 2).tolist()}
    ours, plain = our_pairs(surfaces)
    judge(seed, "pairs", len(ours ^ theirs) == 0, done, len(ours), (ours - theirs, theirs - ours))
    if plain:
        fine, cut, _, parent, *_ = kit.remesh_self_intersections(points, faces, stitch_all=True)
        length = common_length(fine, cut, parent >= surfaces[0].n_triangle)
        own = intersect_surfaces(surfaces).length
        judge(seed, "length", abs(own - length) <= 1e-9 * (1 + length), done, 1, (own, length))
    walls = build_walls(box)
    try:
        patches = rebuild_surfaces([*surfaces, *walls], self_intersections=True)
    except GeosurfError as error:
        judge(seed, "refused", False, done, 1, str(error))
        return
    own = carve_units(patches).report["cells"]
    rank = oracles.n_cell(patches.triangles)
    judge(seed, "cells", own == rank, done, own, (own, rank))
    split = kit.remesh_self_intersections(*stacked([*surfaces, *walls]), stitch_all=True)
    for name, mesh in (("our", (patches.local, patches.triangles)), ("its own", split[:2])):
        points, faces = welded(*mesh)
        faces = turned_alike(faces)
        if faces is None:
            done[f"cells by libigl, from {name} triangles: one-sided patches, not asked"] += 1
            continue
        count, _ = kit.extract_cells(points, faces)
        judge(seed, f"cells from {name} triangles", count - 1 == own, done, own, (own, count - 1))


def judge(seed, what, same, done, n, values) -> None:
    done[what] += n
    done[f"{what}: scenes"] += 1
    done[f"{what}: different"] += not same
    if not same:
        sys.stdout.write(f"scene {seed}, {what}: ours and theirs are {values}\n")


def main(arguments: list[str]) -> int:
    total = int(arguments[0]) if arguments else 1_000
    seconds = float(arguments[1]) if len(arguments) > 1 else float("inf")
    sys.path.extend(arguments[2:3])
    kit = import_module("igl.copyleft.cgal")
    start, done = time.monotonic(), Counter()
    first = int(arguments[3]) if len(arguments) > 3 else 0
    for seed in range(first, first + total):
        if time.monotonic() - start > seconds:
            break
        compare(seed, kit, done)
    for word, n in sorted(done.items()):
        sys.stdout.write(f"{word:45} {n}\n")
    return int(any(n for word, n in done.items() if word.endswith("different")))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
