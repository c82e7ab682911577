"""Faults on the lattice of a horizon: where each meets the horizon in the map.

A fault is a mesh of any shape: vertical, overturned, listric. Its mid trace is the zero line, on
the mesh, of its height above the drape: the horizon filled across the fault without any tear. The
mesh is split until its triangles are smaller than half a cell, near that line only.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geosurf.model import TriSurface
from geosurf.sheets.frame import Frame

FINE = 0.5  # cells: longest edge, in the map, of the triangles that the trace runs through


@dataclass(frozen=True, eq=False)
class FaultMesh:
    """A fault in the frame of a horizon: x, y in cells, z in metres.

    Attributes
    ----------
    name : str
    points : ndarray (n, 3)
    triangles : ndarray (m, 3)
    normals : ndarray (m, 3)
        Into the hanging wall; x, y, z in cells.
    cell : float
        Length of a cell [m].
    """

    name: str
    points: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    cell: float


@dataclass(eq=False)
class Trace:
    """A line in the map along which a fault cuts a horizon, the fault's front on its left.

    Attributes
    ----------
    fault : int
    line : ndarray (n, 6)
        x, y in cells, z in metres, and the normal of the fault there, in cells; straight
        extensions at both ends included.
    start, stop : float
        Places along the line (vertex number) between which the fault really is.
    ends : list of str
        How it ends at the start and at the stop: "tip", "rim" (of the data), "branch of F2".
    """

    fault: int
    line: np.ndarray
    start: float
    stop: float
    ends: list[str] = field(default_factory=lambda: ["tip", "tip"])

    @property
    def segments(self) -> np.ndarray:
        """Pieces (n, 4) of the line in the map."""
        return np.hstack([self.line[:-1, :2], self.line[1:, :2]])

    @property
    def along(self) -> np.ndarray:
        """Length along the line, in cells, at each vertex."""
        step = np.hypot(*np.diff(self.line[:, :2], axis=0).T)
        return np.concatenate([[0.0], np.cumsum(step)])


def mesh_in_frame(surface: TriSurface, frame: Frame) -> FaultMesh:
    """A fault in the frame of a horizon."""
    uv = frame.to_lattice(surface.vertices[:, :2]) * frame.stretch
    points = np.column_stack([uv, surface.vertices[:, 2]])
    scaled = points * (1.0, 1.0, 1.0 / frame.cell)
    a, b, c = (scaled[surface.triangles[:, k]] for k in range(3))
    return FaultMesh(surface.name, points, surface.triangles, np.cross(b - a, c - a), frame.cell)


def sample(grid: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Bilinear values of a grid at columns and rows (n, 2); NaN outside and beside NaN."""
    n_row, n_col = grid.shape
    x, y = xy[:, 0], xy[:, 1]
    inside = (x >= 0) & (x <= n_col - 1) & (y >= 0) & (y <= n_row - 1)
    j = np.clip(np.floor(np.where(inside, x, 0)).astype(np.int64), 0, n_col - 2)
    i = np.clip(np.floor(np.where(inside, y, 0)).astype(np.int64), 0, n_row - 2)
    s, t = x - j, y - i
    low = grid[i, j] * (1 - s) + grid[i, j + 1] * s
    high = grid[i + 1, j] * (1 - s) + grid[i + 1, j + 1] * s
    return np.where(inside, low * (1 - t) + high * t, np.nan)


def trace_lines(mesh: FaultMesh, drape: np.ndarray, stretch: np.ndarray) -> list[np.ndarray]:
    """Lines (n, 6) on a fault where it meets the drape, its front on their left."""
    points, faces = mesh.points, mesh.triangles
    steepest = _steepest(drape, points, stretch)
    if steepest is None:
        return []
    while len(faces):
        above = points[:, 2] - sample(drape, points[:, :2] / stretch)
        edge = points[np.roll(faces, -1, axis=1)] - points[faces]
        wide = np.hypot(edge[..., 0], edge[..., 1]).max(axis=1)
        # the height above the drape changes no faster than this over a triangle
        reach = np.abs(edge[..., 2]).max(axis=1) + steepest * wide
        height = above[faces]
        unknown = np.isnan(height).any(axis=1)
        crosses = (height.min(axis=1) <= reach) & (height.max(axis=1) >= -reach)
        faces = faces[crosses | (unknown & (wide > FINE))]
        if len(faces) == 0 or wide.max() <= FINE:
            break
        points, faces = _split(points, faces)
    return _zero_lines(points, faces, drape, stretch, mesh.cell)


def _steepest(drape, points, stretch):
    """Steepest step of the drape [m per cell] near some points; None where there is no drape."""
    low = np.floor(points[:, :2].min(axis=0) / stretch).astype(np.int64) - 1
    high = np.ceil(points[:, :2].max(axis=0) / stretch).astype(np.int64) + 2
    part = drape[max(low[1], 0) : max(high[1], 0), max(low[0], 0) : max(high[0], 0)]
    if min(part.shape) < 2 or not np.isfinite(part).any():
        return None
    rise = [
        np.abs(d[np.isfinite(d)]).max(initial=0.0) for d in (np.diff(part, axis=0), np.diff(part))
    ]
    return float(np.hypot(*rise) / stretch.min())


def _split(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle into four; neighbours share the new points."""
    used, faces = np.unique(faces, return_inverse=True)
    points, faces = points[used], faces.reshape(-1, 3)
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = ends.min(axis=1) * len(points) + ends.max(axis=1)
    edge, number = np.unique(keys, return_inverse=True)
    middle = 0.5 * (points[edge // len(points)] + points[edge % len(points)])
    m = number.reshape(-1, 3) + len(points)
    a, b, c = faces.T
    ab, bc, ca = m.T
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    faces = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([points, middle]), faces


def _zero_lines(points, faces, drape, stretch, cell) -> list[np.ndarray]:
    """Marching triangles: the zero lines of the height above the drape."""
    above = points[:, 2] - sample(drape, points[:, :2] / stretch)
    faces = faces[np.isfinite(above[faces]).all(axis=1)]
    up = above >= 0
    sign = up[faces]
    faces = faces[sign.any(axis=1) & ~sign.all(axis=1)]
    if len(faces) == 0:
        return []
    # walking round a triangle, the line leaves where the height falls below zero and enters
    # where it rises: then the fault's front is on its left
    sign = up[faces]
    after = np.roll(sign, -1, axis=1)
    row = np.arange(len(faces))
    falls, rises = (sign & ~after).argmax(axis=1), (~sign & after).argmax(axis=1)
    keys, places = [], []
    for k in (rises, falls):
        i, j = faces[row, k], faces[row, (k + 1) % 3]
        i, j = np.minimum(i, j), np.maximum(i, j)
        f = above[i] / (above[i] - above[j])
        keys.append(i * len(points) + j)
        places.append(points[i] + f[:, None] * (points[j] - points[i]))
    number = np.unique(np.concatenate(keys), return_inverse=True)[1]
    scaled = points[faces] * (1.0, 1.0, 1.0 / cell)
    normal = np.cross(scaled[:, 1] - scaled[:, 0], scaled[:, 2] - scaled[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    where = np.empty((number.max() + 1, 6))
    where[number, :3] = np.concatenate(places)
    tail, head = number[: len(faces)], number[len(faces) :]
    where[head, 3:] = normal
    where[tail, 3:] = normal
    return [_thinned(where[chain]) for chain in chains(tail, head)]


def chains(tail: np.ndarray, head: np.ndarray) -> list[np.ndarray]:
    """Directed links -> lines of points; a closed line repeats its first point."""
    onward = dict(zip(tail.tolist(), head.tolist(), strict=True))
    heads = set(head.tolist())
    found = []
    for start in [t for t in tail.tolist() if t not in heads] + tail.tolist():
        if start not in onward:
            continue
        line = [start]
        while line[-1] in onward:
            line.append(onward.pop(line[-1]))
        found.append(np.array(line))
    return found


def _thinned(line: np.ndarray) -> np.ndarray:
    """Leave out points that repeat the one before within a fifth of a cell."""
    step = np.hypot(*np.diff(line[:, :2], axis=0).T)
    place = np.concatenate([[0.0], np.cumsum(step)])
    keep = np.concatenate([[True], np.diff(np.floor(place / 0.2)) > 0])
    keep[-1] = True
    return line[keep]


def extended(line: np.ndarray, first: float, last: float) -> tuple[np.ndarray, float, float]:
    """A line with straight pieces of given lengths [cells] at its ends, and where it was."""
    parts, start = [line], 0.0
    if first > 0:
        far = _beyond(line, first)
        parts.insert(0, far)
        start = float(len(far))
    stop = start + len(line) - 1
    if last > 0:
        parts.append(_beyond(line[::-1], last)[::-1])
    return np.concatenate(parts), start, stop


def _beyond(line: np.ndarray, length: float) -> np.ndarray:
    """Points from `length` cells before the line up to it, along its first two cells."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line[:, :2], axis=0).T))])
    k = min(int(np.searchsorted(along, 2.0)), len(line) - 1)
    away = line[0] - line[k]
    away = away / max(float(np.hypot(*away[:2])), 1e-9)
    away[3:] = 0.0
    n = max(int(np.ceil(length / FINE)), 1)
    return line[0] + away * (length * np.arange(n, 0, -1) / n)[:, None]
