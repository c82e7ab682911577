"""Ask the independent checker.

``python -m tests.field_data.checked [cases] [seconds] [first seed]``.

Small pairs and triples of surfaces, made by the generators of the folder `verify` beside the
checkout (GEOSURF_SHARED), with another seed each. Its oracles say which triangles meet and how,
where the curve of each pair runs, and where three surfaces meet; its checks, that every triangle
is cut into pieces that tile it and that the pieces meet in common corners and edges only. All
exact but for the last rounding. Ends with 1 if an answer is wrong.
"""

from __future__ import annotations

import importlib
import itertools
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from geosurf import TriSurface, intersect_surfaces, rebuild_surfaces
from geosurf.arrangement.search import find_contacts
from geosurf.errors import GeosurfError, InvariantError
from geosurf.kernels.contacts.triangle_contact import in_plane, n_corners
from tests import oracles
from tests.counting import count

KINDS = ("random", "lattice", "lattice triple", "catalogue", "structured", "random triple")
OFFSET = np.array([456_000.0, 6_780_000.0, -2_000.0])


def kit():
    """The checker and its generators."""
    shared = Path(os.environ.get("GEOSURF_SHARED", Path(__file__).parents[3] / "shared"))
    if str(shared) not in sys.path:
        sys.path.append(str(shared))
    return importlib.import_module("verify"), importlib.import_module("verify.cases")


def meshes_of(seed: int, cases):
    """Kind and meshes (V, F) of a case."""
    rng = np.random.default_rng([61, seed])
    kind = KINDS[seed % len(KINDS)]
    if kind == "catalogue":
        some = list(cases.catalogue_variants(seed, 1 + seed // len(KINDS) % 2))
        _, *meshes = some[rng.integers(len(some))]
        return kind, meshes
    if kind == "structured":
        maker = rng.integers(6)
        if maker == 0:
            case = cases.horizon_and_fault(seed, n=5, offset=OFFSET * rng.integers(2))
        elif maker == 1:
            case = cases.fault_on_vertices(seed, n=int(rng.integers(3, 8)))
        elif maker == 2:
            case = cases.slivers(seed, count=6, aspect=10.0 ** -rng.integers(1, 10))
        elif maker == 3:
            case = cases.nan_holes(seed, n=7, share=0.2)
        elif maker == 4:
            case = cases.pinch_out(n=int(rng.integers(3, 9)), dip=10.0 ** -rng.integers(1, 9))
        else:
            case = cases.sub_nanometre_gap(
                n=int(rng.integers(2, 6)), gap=2.0 ** -rng.integers(20, 45)
            )
        return kind, finite(case.meshes)
    if kind.startswith("random"):
        count = int(rng.integers(2, 9))
        make = lambda seed: cases.random_soup(seed, count).meshes  # noqa: E731
    else:
        count, extent = int(rng.integers(1, 7)), int(rng.integers(2, 5))
        make = lambda seed: cases.lattice_soup(seed, count, extent).meshes  # noqa: E731
    meshes = make(seed) + (make(seed + 10**6)[:1] if kind.endswith("triple") else [])
    if rng.random() < 0.3:
        scale = 2.0 ** rng.integers(-3, 8)
        meshes = [(V * scale + OFFSET, F) for V, F in meshes]
    return kind, meshes


def finite(meshes):
    """Meshes of a case, with numbers for nodes that no triangle has."""
    return [(np.where(np.isfinite(V), V, 0.0), F) for V, F in meshes]


def kinds_of(first: TriSurface, second: TriSurface) -> set[tuple[int, int, str]]:
    """Pairs of triangles of two surfaces that meet, and how, in the words of the checker."""
    found = find_contacts([first, second])
    rows = found.rows[found.surface_of_face[found.rows[:, :2]].sum(axis=1) == 1]
    faces = found.rows[:0, :2] if len(rows) == 0 else rows[:, :2]
    turned = found.surface_of_face[faces[:, 0]] == 1
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    out = set()
    each = found.key_of_face[faces].tolist(), n_corners(rows), in_plane(rows)
    for (a, b), n, flat in zip(*each, strict=True):
        word = ("point", "segment", "area")[min(int(n), 3) - 1]
        out.add((a, b, f"coplanar {word}" if flat else word))
    return out


def check(seed: int, verify, cases) -> tuple[str, int]:
    """The kind of a case and how many pairs of triangles meet in it; an error if one is wrong."""
    kind, meshes = meshes_of(seed, cases)
    return kind, check_meshes(verify, meshes, soups=kind not in ("catalogue", "structured"))


def check_meshes(verify, meshes, *, soups: bool = False, by_fractions: bool = True) -> int:
    """How many pairs of triangles of different meshes meet; an error if an answer is wrong.

    Without fractions, curves are compared with the meshes only: for large ones.
    """
    surfaces = [TriSurface("ABCDE"[i], "surface", *mesh) for i, mesh in enumerate(meshes)]
    far = max(float(np.abs(V).max()) for V, _ in meshes)
    tol = max(1e-9, 4e-15 * far)
    n_pair, exact = 0, None
    for i, j in itertools.combinations(range(len(meshes)), 2):
        if by_fractions:
            pairs = verify.exact_pairs(meshes[i], meshes[j])
            n_pair += len(pairs)
            ours = kinds_of(surfaces[i], surfaces[j])
            assert ours == pairs.as_set(), ours ^ pairs.as_set()
            exact = verify.exact_curve_segments(meshes[i], meshes[j], pairs)
        curves = intersect_surfaces([surfaces[i], surfaces[j]], self_intersections=soups)
        both = (curves.surfaces_of_segment == (0, 1)).all(axis=1)
        used, segments = np.unique(curves.segments[both], return_inverse=True)
        line = curves.points[used], segments.reshape(-1, 2)
        verify.check_curve(meshes[i], meshes[j], *line, tol, degrees=not soups, exact=exact)
    if soups:
        check_itself(verify, meshes[0], surfaces[0], tol)
    patches = rebuild_surfaces(surfaces, self_intersections=soups)
    check_pieces(verify, patches, tol)
    if len(meshes) == 3 and by_fractions:
        assert_triple_points(verify, meshes, patches, tol)
    return n_pair


def check_pieces(verify, patches, tol) -> None:
    """Pieces tile their triangles, and those of two surfaces share corners and edges only."""
    parts = []
    for i, source in enumerate(patches.sources):
        mine = patches.surface_of_triangle == i
        parts.append((patches.vertices, patches.triangles[mine]))
        verify.check_split(
            source.vertices, source.triangles, *parts[i], patches.parent_of_triangle[mine], tol
        )
    for one, two in itertools.combinations(parts, 2):
        verify.check_conforming(*one, *two, tol=0.0)


def check_itself(verify, mesh, surface, tol) -> None:
    """Where a surface meets itself, off the corners and edges that its triangles share."""
    pairs = verify.exact_pairs(mesh, mesh)
    corners = [set(oracles.rational(triangle)) for triangle in mesh[0][mesh[1]]]
    keep = [
        k
        for k, (a, b) in enumerate(zip(pairs.a.tolist(), pairs.b.tolist(), strict=True))
        if a < b and (len(pairs.points[k]) > 2 or not {*pairs.points[k]} <= corners[a] & corners[b])
    ]
    pairs = replace(
        pairs, a=pairs.a[keep], b=pairs.b[keep], kind=[pairs.kind[k] for k in keep],
        points=[pairs.points[k] for k in keep],
    )  # fmt: skip
    curves = intersect_surfaces([surface], self_intersections=True)
    exact = verify.exact_curve_segments(mesh, mesh, pairs)
    line = curves.points, curves.segments
    verify.check_curve(mesh, mesh, *line, tol, degrees=False, exact=exact)


def assert_triple_points(verify, meshes, patches, tol) -> None:
    """Where three surfaces meet there is a vertex that all three have."""
    shared = set.intersection(
        *(set(patches.triangles[patches.surface_of_triangle == i].ravel()) for i in range(3))
    )
    near = patches.vertices[sorted(shared)]
    for point in verify.exact_triple_points(*meshes):
        place = np.array([float(value) for value in point])
        off = np.abs(near - place).max(axis=1).min(initial=np.inf)
        assert off <= tol + patches.report["largest_move"], f"no vertex at {place}"


def what_becomes_of(seed: int) -> tuple[str, str]:
    """The kind of a case, or "refused" or "wrong", and why."""
    try:
        return check(seed, *kit())[0], ""
    except Exception as error:  # whatever it is, it is counted
        known = isinstance(error, GeosurfError) and not isinstance(error, InvariantError)
        return "refused" if known else "wrong", f"{type(error).__name__}: {error}"


if __name__ == "__main__":
    sys.exit(count(what_becomes_of))
