"""One stress case: surfaces, and what is known about them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from geosurf.model import TriSurface


@dataclass(frozen=True)
class Case:
    """Surfaces to intersect, and what is known about them.

    Attributes
    ----------
    family : str
    number, seed : int
        What it was made from.
    surfaces : tuple of TriSurface
    self_intersections : bool
        Whether surfaces may cross themselves.
    known : dict
        What must come out: ``kind`` and ``count`` of two triangles, ``apart``, ``area`` [m2].
    """

    family: str
    number: int
    seed: int
    surfaces: tuple[TriSurface, ...]
    self_intersections: bool = False
    known: dict[str, Any] = field(default_factory=dict)


def shuffled(case: Case) -> Case:
    """The same case with surfaces, vertices, triangles and corners in another order."""
    rng = np.random.default_rng([case.seed, case.number, 7])
    out = []
    for surface in case.surfaces:
        new = rng.permutation(surface.n_vertex)
        vertices = np.empty_like(surface.vertices)
        vertices[new] = surface.vertices
        faces = new[surface.triangles][rng.permutation(surface.n_triangle)]
        turns = rng.integers(0, 3, len(faces))
        faces = np.stack([np.roll(face, k) for face, k in zip(faces, turns, strict=True)])
        out.append(TriSurface(surface.name, surface.role, vertices, faces))
    order = rng.permutation(len(out))
    return replace(case, surfaces=tuple(out[i] for i in order))
