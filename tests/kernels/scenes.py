"""Bytes of everything that kernels decide, for many scenes: ``python -m tests.kernels.scenes``.

Run by `test_frozen_whole` in processes that run kernels in different ways. The lines say
which scene differs; at the end, whether numba was imported.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator

import numpy as np

from benchmarks.stress.families import FAMILIES, make_case
from geosurf import (
    TriSurface,
    carve_units,
    intersect_surfaces,
    intersect_triangles,
    rebuild_surfaces,
    synthetic,
)
from geosurf.errors import GeosurfError
from geosurf.scene import Scene
from tests.kernels.families import FAMILIES as POINTS
from tests.kernels.families import PREDICATES, kernel_signs, tuples


def scenes() -> Iterator[tuple[str, str]]:
    """Name and hash of each scene: predicates, degenerate cases, whole models."""
    for name, size in PREDICATES.items():
        for family in POINTS:
            yield f"{name} {family}", _hash(kernel_signs(name, tuples(family, 200, *size, seed=7)))
    for family in FAMILIES:
        for number in range(6):
            case = make_case(family, number, seed=11)
            yield f"{family} {number}", _case(case.surfaces, case.self_intersections)
    worlds = [synthetic.tilted_planes(n=9), synthetic.graben(n=7), synthetic.egg_box(n=17)]
    for world in [*worlds, synthetic.faulted_reservoir(n=15)]:
        yield world.name, _model(Scene(world.horizons, world.faults, world.box))


def _case(surfaces: tuple[TriSurface, ...], itself: bool) -> str:
    """Curves by both searches, and patches; a refusal is a result too."""
    held: list[object] = []
    for method in ("tree", "voxels"):
        try:
            curves = intersect_surfaces(surfaces, method=method, self_intersections=itself)
            held += [curves.local, curves.segments, curves.surfaces_of_segment, *curves.curves]
        except GeosurfError as error:
            held.append(str(error))
    try:
        patches = rebuild_surfaces(surfaces, self_intersections=itself)
        held += [patches.local, patches.triangles, patches.parent_of_triangle]
        held += [patches.patch_of_triangle, patches.curve_edges]
    except GeosurfError as error:
        held.append(str(error))
    if len(surfaces) == 2 and all(s.n_triangle == 1 for s in surfaces):
        contact = intersect_triangles(*(s.vertices[s.triangles[0]] for s in surfaces))
        held += [contact.kind, contact.points]
    return _hash(*held)


def _model(scene: Scene) -> str:
    certificate = scene.check()
    units = carve_units(scene.patches)
    held: list[object] = [str(certificate), scene.patches.local, scene.patches.triangles]
    for unit in units.values():
        held += [unit.volume.hex(), unit.triangles, unit.local]
    return _hash(*held)


def _hash(*parts: object) -> str:
    digest = hashlib.sha256()
    for part in parts:
        if isinstance(part, np.ndarray):
            digest.update(f"{part.dtype} {part.shape}".encode())
            digest.update(np.ascontiguousarray(part))
        else:
            digest.update(str(part).encode())
    return digest.hexdigest()[:16]


if __name__ == "__main__":
    for name, digest in scenes():
        sys.stdout.write(f"{name}: {digest}\n")
    sys.stdout.write(f"numba: {bool({'numba', 'llvmlite'} & set(sys.modules))}\n")
