"""Faults on the lattice of a horizon: where each meets the horizon in the map.

A fault is a mesh of any shape: vertical, overturned, listric. Its mid trace is the zero line, on
the mesh, of its height above the drape: the horizon filled across the fault without any tear. The
mesh is split until its triangles are smaller than half a cell, near that line only
(`geosurf.kernels.sheets.fault_trace`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from geosurf.kernels.meshes.mesh import number_keys
from geosurf.kernels.sheets.fault_trace import block_bounds, may_meet, zero_line_pieces
from geosurf.kernels.sheets.link_lines import directed_lines
from geosurf.model import TriSurface
from geosurf.model.surfaces import Content
from geosurf.sheets.lattice.picks import Frame

Bounds = tuple[np.ndarray, np.ndarray, np.ndarray]

FINE = 0.5  # cells: longest edge, in the map, of the triangles that the trace runs through
KEPT = 32  # faults in a frame that are remembered
UNEVEN = 4.0  # times the usual width: wider triangles of a fault are halved by themselves


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

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners of all triangles, one after the other (m, 9)."""
        return self.points[self.triangles].reshape(-1, 9)

    @cached_property
    def across(self) -> np.ndarray:
        """Horizontal parts of the normals (m, 2)."""
        return np.ascontiguousarray(self.normals[:, :2])


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

    @cached_property
    def along(self) -> np.ndarray:
        """Length along the line, in cells, at each vertex."""
        step = np.hypot(*np.diff(self.line[:, :2], axis=0).T)
        return np.concatenate([[0.0], np.cumsum(step)])

    def at(self, place: Any) -> np.ndarray:
        """Points (..., 6) of the line at places, which are vertex numbers."""
        return _read(place, np.arange(len(self.line)), self.line)

    def at_length(self, length: Any) -> np.ndarray:
        """Points (..., 6) of the line at some lengths along it [cells]."""
        return _read(length, self.along, self.line)

    def length_at(self, place: Any) -> Any:
        """Lengths along the line [cells] of places."""
        return np.interp(place, np.arange(len(self.line)), self.along)

    def place_at(self, length: Any) -> Any:
        """Places at some lengths along the line [cells]."""
        return np.interp(length, self.along, np.arange(len(self.line)))

    def far_from(self, at: np.ndarray) -> np.ndarray:
        """Distance (n,) of each vertex from a point in the map [cells]."""
        return np.hypot(*(self.line[:, :2] - at).T)

    @property
    def inside(self) -> tuple[float, float]:
        """Lengths along the line between which the fault really is [cells]."""
        first, last = self.length_at([self.start, self.stop])
        return float(first), float(last)

    @property
    def stations(self) -> np.ndarray:
        """Lengths along the line (n,), about a cell apart, where throw is read [cells]."""
        first, last = self.inside
        return np.linspace(first, last, max(int(last - first), 1) + 1)


def _read(at: Any, over: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Columns (..., n) of a table, linear between its rows."""
    return np.stack([np.interp(at, over, column) for column in columns.T], axis=-1)


def mesh_in_frame(surface: TriSurface, frame: Frame) -> FaultMesh:
    """A fault in the frame of a horizon; remembered by content for the last ones.

    Horizons of one survey share their frame, and so do all realisations of one horizon.
    """
    return _in_frame(Content(surface), _Steps(frame))


class _Steps:
    """A frame as a key: places depend on its corner and its steps only."""

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.key = frame.corner.tobytes() + frame.step.tobytes()

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Steps) and self.key == other.key


@lru_cache(maxsize=KEPT)
def _in_frame(content: Content, steps: _Steps) -> FaultMesh:
    """A fault in the frame of a horizon."""
    surface, frame = content.surface, steps.frame
    uv = frame.to_cells(surface.vertices[:, :2])
    points = np.column_stack([uv, surface.vertices[:, 2]])

    # normals in cells, all three axes alike: their slope gives distances across strike in cells
    scaled = points * (1.0, 1.0, 1.0 / frame.cell)
    a, b, c = (scaled[surface.triangles[:, k]] for k in range(3))
    return FaultMesh(surface.name, points, surface.triangles, np.cross(b - a, c - a), frame.cell)


def sample(grid: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Bilinear values of a grid at columns and rows (n, 2); NaN outside and next to NaN."""
    n_row, n_col = grid.shape
    x, y = xy[:, 0], xy[:, 1]

    # NaN of a neighbour comes through by itself, as its share times NaN is NaN
    inside = (x >= 0) & (x <= n_col - 1) & (y >= 0) & (y <= n_row - 1)
    j = np.clip(np.floor(np.where(inside, x, 0)).astype(np.int64), 0, n_col - 2)
    i = np.clip(np.floor(np.where(inside, y, 0)).astype(np.int64), 0, n_row - 2)
    s, t = x - j, y - i
    low = grid[i, j] * (1 - s) + grid[i, j + 1] * s
    high = grid[i + 1, j] * (1 - s) + grid[i + 1, j + 1] * s
    return np.where(inside, low * (1 - t) + high * t, np.nan)


def trace_lines(
    mesh: FaultMesh, drape: np.ndarray, stretch: np.ndarray, bounds: Bounds | None = None
) -> list[np.ndarray]:
    """Lines (n, 6) on a fault where it meets the drape, its front on their left.

    `bounds` are those of `block_bounds`, for many faults on one drape.
    """
    low, high, levels = block_bounds(drape) if bounds is None else bounds

    # rows (n,): triangles that the drape can meet, by the range of its heights under each
    near = may_meet(drape, low, high, levels, stretch, mesh.points, mesh.triangles)
    rows = np.flatnonzero(near)
    if len(rows) == 0:
        return []

    # a few triangles a thousand times as wide as the others would ask for splits of all
    points, faces, rows, wide = _evened(mesh.points, mesh.triangles[rows], rows)
    ahead = np.roll(faces, -1, axis=1)

    # edges (n, 3): number of the edge from each corner, the same for both its triangles
    keys = np.minimum(faces, ahead) * len(points) + np.maximum(faces, ahead)
    edges = number_keys(keys.ravel())[1].reshape(-1, 3)
    depth, needed = _depth(wide) + 1, _depth(wide)
    while needed < depth:
        depth = needed  # as fine as the triangles ask for that the trace runs through
        names, places = zero_line_pieces(
            drape, low, high, levels, stretch, points, faces, edges, faces < ahead, depth
        )
        needed = _depth(wide[names[:, 4]])
    if len(names) == 0:
        return []

    # join pieces by the names of their ends, which two triangles give alike
    number = _numbered(*(np.concatenate([names[:, k], names[:, k + 2]]) for k in (0, 1)))
    tail, head = number[: len(names)], number[len(names) :]
    where, face = np.empty((number.max() + 1, 3)), np.empty(number.max() + 1, dtype=np.int64)
    where[tail], where[head] = places[:, :3], places[:, 3:]
    face[head] = names[:, 4]
    face[tail] = names[:, 4]

    # unit normals into the hanging wall, of the triangle that each point lies on
    normals = mesh.normals[rows]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lines = []
    for line in split_lines(directed_lines(tail, head, len(where))):
        # points closer than a fifth of a cell carry no more than rounding
        line = line[_spaced(where[line, 0], where[line, 1])]
        lines.append(np.hstack([where[line], normals[face[line]]]))
    return lines


def split_lines(found: tuple[np.ndarray, np.ndarray]) -> list[np.ndarray]:
    """Lines of points, from what kernels give: all points, and where each line starts."""
    points, starts = found
    return np.split(points, starts[1:-1]) if len(starts) > 1 else []


def _depth(wide: np.ndarray) -> int:
    """How often triangles are halved until all are fine."""
    return int(np.ceil(np.log2(max(float(wide.max(initial=0.0)), FINE) / FINE)))


def _widths(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Length (n, 3) in the map of the edges of triangles, from each corner to the next."""
    edge = points[np.roll(faces, -1, axis=1), :2] - points[faces, :2]
    return np.hypot(edge[..., 0], edge[..., 1])


def _evened(
    points: np.ndarray, faces: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Long edges halved, on both sides alike: small triangles stay what they are.

    A fault that was drawn out has triangles a thousand times as wide as its others. Returns the
    width of each triangle, too.
    """
    widths = _widths(points, faces)
    # the median; numpy's loads masked arrays, a twentieth of a second
    wide = np.sort(widths.max(axis=1))
    usual = 0.5 * float(wide[(len(wide) - 1) // 2] + wide[len(wide) // 2])
    limit = max(UNEVEN * usual, FINE)
    while (long := widths > limit).any():
        ahead = np.roll(faces, -1, axis=1)
        keys = (np.minimum(faces, ahead) * len(points) + np.maximum(faces, ahead))[long]

        # one new point for each long edge, the same for both triangles
        edge, number = np.unique(keys, return_inverse=True)
        middle = np.full(faces.shape, -1)
        middle[long] = len(points) + number
        points = np.concatenate(
            [points, 0.5 * (points[edge // len(points)] + points[edge % len(points)])]
        )
        # turned so that long edges come first
        turn = np.where(long[:, 0] & ~long[:, 2], 0, np.where(long[:, 1] & ~long[:, 0], 1, 2))
        at = (turn[:, None] + np.arange(3)) % 3

        # split into as many triangles as there are long edges, plus one
        a, b, c = np.take_along_axis(faces, at, axis=1).T
        ab, bc, ca = np.take_along_axis(middle, at, axis=1).T
        many = long.sum(axis=1)
        parts = {
            0: [(a, b, c)],
            1: [(a, ab, c), (ab, b, c)],
            2: [(ab, b, bc), (a, ab, bc), (a, bc, c)],
            3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
        }
        made = [(np.stack(part, 1)[many == k], rows[many == k]) for k in parts for part in parts[k]]
        faces, rows = (np.concatenate(some) for some in zip(*made, strict=True))
        widths = _widths(points, faces)
    return points, faces, rows, widths.max(axis=1)


def _numbered(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Numbers (n,) from 0, in the order of names (one, two), the same for the same ones."""
    least, low = int(first.min()), int(second.min())
    wide = int(second.max()) - low + 1
    if (int(first.max()) - least + 1) * wide >= 2**63:
        return np.unique(np.stack([first, second], axis=1), axis=0, return_inverse=True)[1].ravel()
    return number_keys((first - least) * wide + (second - low))[1]


def _spaced(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Which points of a line stay: those that do not repeat the one before by a fifth of a cell."""
    # one point for each fifth of a cell; both ends always stay
    place = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    keep = np.ones(len(x), dtype=bool)
    fifth = np.floor(place / 0.2)
    keep[1:-1] = fifth[1:-1] > fifth[:-2]
    return keep


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

    # the direction of two cells: a single piece may be shorter than rounding
    k = min(int(np.searchsorted(along, 2.0)), len(line) - 1)
    away = line[0] - line[k]
    away = away / max(float(np.hypot(*away[:2])), 1e-9)
    away[3:] = 0.0
    n = max(int(np.ceil(length / FINE)), 1)
    return line[0] + away * (length * np.arange(n, 0, -1) / n)[:, None]
