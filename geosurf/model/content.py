"""A surface as a key of results that are remembered: equal surfaces have equal ones."""

from __future__ import annotations

from hashlib import sha256

from geosurf.model.surfaces import TriSurface

_KEPT = "_content"


class Content:
    """A surface as a key: equal if name, vertices and triangles are.

    Examples
    --------
    >>> from geosurf import TriSurface
    >>> corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0]]
    >>> one, two = (Content(TriSurface("F1", "fault", corners, [[0, 1, 2]])) for _ in range(2))
    >>> one == two, hash(one) == hash(two)
    (True, True)
    """

    def __init__(self, surface: TriSurface) -> None:
        self.surface = surface
        # remembered on the surface, with its name: a renamed twin has the same attributes
        known = surface.__dict__.get(_KEPT)
        if known is None or known[0] != surface.name:
            digest = sha256(f"{surface.name} {surface.n_vertex} ".encode())
            digest.update(surface.vertices.data)
            digest.update(surface.triangles.data)
            known = surface.__dict__[_KEPT] = surface.name, digest.digest()
        self.key: bytes = known[1]

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Content) and self.key == other.key
