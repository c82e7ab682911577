"""Triangles of a virtual wall, which share the vertices of its fault exactly."""

from __future__ import annotations

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.faults.notches import strip
from geosurf.faults.virtual.joins import Join
from geosurf.kernels.exact.predicates import flat_triangles, frame_of
from geosurf.kernels.meshes.mesh import weld
from geosurf.model import TriSurface
from geosurf.model.compartments import virtual_name

_PARTING = 0.7  # cosine: lines of a wall that part by more than 45 degrees run parallel instead
_BEYOND = 0.5  # of the length of a join: how far a wall goes on, before it is cut at its target


class WallMesh:
    """The wall of one fault, strip by strip.

    Parameters
    ----------
    surface : TriSurface
        The fault; its vertices come first.
    """

    def __init__(self, surface: TriSurface) -> None:
        self.surface = surface
        self.x = np.array(surface.vertices)
        self.strips: list[np.ndarray] = []  # triangles, one array for each part of the wall

    def add(self, points: np.ndarray) -> np.ndarray:
        """Add vertices (n, 3); return their numbers."""
        first = len(self.x)
        self.x = np.concatenate([self.x, points])
        return np.arange(first, len(self.x))

    def raise_to(self, arc: np.ndarray, level: float) -> np.ndarray:
        """Add a vertical strip from an arc to a level; return the copies of its vertices."""
        tops = self.x[arc].copy()
        tops[:, 2] = level
        n = len(self.x)
        self.strips.append(strip(arc, n, self.x[arc], tops))
        return self.add(tops)

    def join(self, path: np.ndarray, join: Join, margin: float) -> None:
        """Add a strip of level lines from a path to a target, and beyond it."""
        line = self.x[path]
        way = join.ends - line
        length = np.linalg.norm(way, axis=1)

        # where the target is missing, or touched, lines run as their neighbours do
        known = np.flatnonzero(length > 0)
        near = known[np.abs(np.arange(len(path))[:, None] - known).argmin(axis=1)]
        way, length = (way / np.where(length > 0, length, 1.0)[:, None])[near], length[near]

        # ways that part leave a gap between them: all run as the shortest does
        main = way[int(length.argmin())]
        if join.reach or (way @ main).min() < _PARTING:
            way = np.broadcast_to(main, way.shape)
            length = np.full(len(length), max(join.reach, float(length.max())))
        far = line + way * (length * (1.0 + _BEYOND) + margin)[:, None]
        far[:, 2] = line[:, 2]
        n = len(self.x)
        self.strips.append(strip(path, n, line, far))
        self.add(far)

    def undo(self) -> None:
        """Drop the strip that was added last; its vertices stay unused."""
        self.strips.pop()

    def join_tip(self, path: np.ndarray, tip: np.ndarray) -> None:
        """Add a strip between a path and the tip line of another fault (n, 3), vertex by vertex."""
        line = self.x[path]
        down = line[0, 2] > line[-1, 2]
        if (tip[0, 2] > tip[-1, 2]) != down:
            tip = tip[::-1]
        other = self.add(tip)
        found, i, k = [], 0, 0

        # down both lines: the next vertex is the one that is farther ahead
        while i + 1 < len(path) or k + 1 < len(other):
            first = k + 1 == len(other)
            if not first and i + 1 < len(path):
                p, q = line[i + 1], tip[k + 1]
                ahead = (p[2] > q[2]) == down if p[2] != q[2] else tuple(p) < tuple(q)
                first = bool(ahead)
            if first:
                found.append((path[i + 1], path[i], other[k]))
                i += 1
            else:
                found.append((path[i], other[k], other[k + 1]))
                k += 1
        self.strips.append(np.array(found, dtype=np.int64))

    def finished(self) -> tuple[TriSurface, np.ndarray]:
        """Return the wall, and the strip of each of its triangles.

        Raises
        ------
        GeometryError
            If the wall crosses itself or its fault.
        """
        t = np.concatenate(self.strips)
        of = np.repeat(np.arange(len(self.strips)), [len(one) for one in self.strips])

        stays = self._with_area(t)
        t, of = t[stays], of[stays]
        pairs, every = self._crossing(t)
        if len(pairs):
            at = self.x[every[pairs[0, 0]]].mean(axis=0)
            name = self.surface.name
            raise GeometryError(
                f"the virtual wall of fault {name!r} would cross itself or the fault near "
                f"{place(at)}. Name another target: compartments={{{name!r}: 'boundary'}}; or "
                f"smooth the ends of the fault: lengthen={{{name!r}: ...}}.",
                place=at,
                surfaces=(name,),
            )
        used, number = np.unique(t, return_inverse=True)
        name = virtual_name(self.surface.name)
        return TriSurface(name, "virtual", self.x[used], number.reshape(-1, 3)), of

    @property
    def crosses_itself(self) -> bool:
        """Whether the wall as it is crosses itself or its fault, by exact signs."""
        t = np.concatenate(self.strips)
        return len(self._crossing(t[self._with_area(t)])[0]) > 0

    def _with_area(self, t: np.ndarray) -> np.ndarray:
        """Which triangles have an area: vertical steps of a rim make some that have none."""
        stays = np.ones(len(t), dtype=bool)
        stays[flat_triangles(self.x, t, *frame_of(self.x))] = False
        return stays

    def _crossing(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of triangles that cross, and the corners of all: of the wall, then of the fault."""
        # vertices at one place are one: tip lines of other faults may touch
        number, count = weld(self.x)
        first = np.full(count, -1, dtype=np.int64)
        first[number[::-1]] = np.arange(len(self.x))[::-1]
        mine, fault = first[number][t], first[number][self.surface.triangles]
        return crossing_pairs(self.x, mine, fault), np.concatenate([mine, fault])


__all__ = ["WallMesh"]
