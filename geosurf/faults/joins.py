"""The shortest way from a tip line to a fault or to the boundary, at equal elevation.

Each vertex of a tip line is joined to the nearest point of the target at its own elevation. So a
wall consists of level lines, of which no two cross where the tip line falls throughout.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

_SAME = 1e-9  # relative: a tip line that is as near as the fault itself is the end of a join


@dataclass(frozen=True)
class TipLine:
    """Where a fault dies along strike, with the vertical lines above and below.

    Attributes
    ----------
    fault : str
    piece : int
        Of the fault.
    side : {"start", "end"}
    line : ndarray of float64, shape (n, 3)
        [m], as the triangles next to the rim run.
    """

    fault: str
    piece: int
    side: str
    line: np.ndarray

    @property
    def key(self) -> tuple[str, int, str]:
        """What it is known by."""
        return self.fault, self.piece, self.side


@dataclass(frozen=True)
class Target:
    """What walls may end at: a fault, with the virtual wall above and below it.

    Attributes
    ----------
    name : str
    corners : ndarray of float64, shape (n, 3, 3)
        Its triangles [m].
    tips : tuple of TipLine
        Where it dies itself.
    """

    name: str
    corners: np.ndarray
    tips: tuple[TipLine, ...] = ()
    low: np.ndarray = field(init=False)
    high: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        """Bounds on the map, by which far targets are left out."""
        points = self.corners.reshape(-1, 3)[:, :2]
        self.__dict__.update(low=points.min(axis=0), high=points.max(axis=0))

    def least_distance(self, points: np.ndarray) -> float:
        """A distance on the map that no point (n, 3) is nearer than."""
        away = np.maximum(np.maximum(self.low - points[:, :2], points[:, :2] - self.high), 0.0)
        return float(np.linalg.norm(away, axis=1).min())


@dataclass(frozen=True)
class Join:
    """The shortest ways from a line to a target.

    Attributes
    ----------
    target : str
    ends : ndarray of float64, shape (n, 3)
        Nearest point of each vertex, at its elevation; NaN where the target is not that high.
    length : float
        The shortest way that starts inside the model [m].
    place : ndarray of float64, shape (3,)
        Where that one starts.
    goes_on : bool
        Whether any way has a length; else the line lies on the target.
    facing : TipLine or None
        The tip line of the target, where it is nearest.
    reach : float
        Where all ways run parallel: how far [m].
    """

    target: str
    ends: np.ndarray
    length: float
    place: np.ndarray
    goes_on: bool
    facing: TipLine | None = None
    reach: float = 0.0

    @property
    def touches(self) -> bool:
        """Whether the line touches the target, but for rounding."""
        return self.length <= 4.0 * float(np.spacing(np.abs(self.place).max()))


def join_to(line: np.ndarray, inside: np.ndarray, target: Target) -> Join | None:
    """Return the shortest ways from a line (n, 3) to a fault; None where none starts inside.

    Parameters
    ----------
    line : ndarray of float64, shape (n, 3)
    inside : ndarray of bool, shape (n,)
        Which vertices count for the length.
    target : Target
    """
    ends = np.stack([nearest_at_level(point, target.corners) for point in line])
    away = np.linalg.norm(ends - line, axis=1)
    counts = inside & np.isfinite(away)
    if not counts.any():
        return None
    least = int(np.where(counts, away, np.inf).argmin())

    # two tip lines face each other if the nearest point is a tip at some elevation
    facing, near = None, np.inf
    for tip in target.tips:
        across = np.linalg.norm(at_levels(tip.line, line[:, 2]) - line, axis=1)
        same = counts & (across <= away * (1.0 + _SAME))
        if same.any() and across[same].min() < near:
            facing, near = tip, float(across[same].min())
    goes_on = bool((away[np.isfinite(away)] > 0).any())
    return Join(target.name, ends, float(away[least]), line[least], goes_on, facing)


def join_to_boundary(
    line: np.ndarray, inside: np.ndarray, outline: np.ndarray, name: str
) -> Join | None:
    """Return the shortest ways from a line (n, 3) to an outline on the map (m, 2)."""
    if not inside.any():
        return None
    a, b = outline, np.roll(outline, -1, axis=0)
    ends = np.full(line.shape, np.nan)
    for i in np.flatnonzero(inside):
        ends[i, :2] = _nearest_on(line[i, :2], a, b)
        ends[i, 2] = line[i, 2]
    away = np.linalg.norm(ends - line, axis=1)
    least = int(np.where(inside, away, np.inf).argmin())
    reach = float(np.linalg.norm(np.ptp(outline, axis=0)))
    goes_on = bool((away[inside] > 0).any())
    return Join(name, ends, float(away[least]), line[least], goes_on, reach=reach)


def joins_by_length(
    line: np.ndarray, inside: np.ndarray, targets: Sequence[Target], boundary: Join | None
) -> list[Join]:
    """Return the joins to some faults, and to the boundary; the shortest first.

    Faults beyond the boundary, as far as bounds show, are left out.
    """
    points = line[inside]
    if len(points) == 0:
        return []
    limit = np.inf if boundary is None else boundary.length
    near = [one for one in targets if one.least_distance(points) <= limit]
    found = [boundary, *(join_to(line, inside, one) for one in near)]
    return sorted((one for one in found if one is not None), key=lambda one: one.length)


def nearest_at_level(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Nearest point of triangles (n, 3, 3) at the elevation of a point (3,); NaN without one.

    Examples
    --------
    >>> wall = np.array([[[4.0, -9, -9], [4, 9, -9], [4, 0, 9]]])
    >>> nearest_at_level(np.array([1.0, 2, 0]), wall).tolist()
    [4.0, 2.0, 0.0]
    """
    # corners at the level are above it; where that leaves no triangle, at the base, below it
    for below in (corners[:, :, 2] < point[2], corners[:, :, 2] <= point[2]):
        rows = below.any(axis=1) & ~below.all(axis=1)
        if rows.any():
            break
    else:
        return np.full(3, np.nan)

    # the level line in each triangle: the corner that is alone on its side, and the other two
    cut, low = corners[rows], below[rows]
    alone = np.where(low.sum(axis=1) == 1, low.argmax(axis=1), (~low).argmax(axis=1))
    rows = np.arange(len(cut))
    ends = []
    for step in (1, 2):
        a, b = cut[rows, alone], cut[rows, (alone + step) % 3]
        share = (point[2] - a[:, 2]) / (b[:, 2] - a[:, 2])
        ends.append(a[:, :2] + share[:, None] * (b - a)[:, :2])
    return np.append(_nearest_on(point[:2], *ends), point[2])


def _nearest_on(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Nearest point of some segments (n, 2) to a point (2,); of equal ones, west and south."""
    step = b - a
    size = (step**2).sum(axis=1)
    share = ((point - a) * step).sum(axis=1) / np.where(size > 0, size, 1.0)
    at = a + np.clip(share, 0.0, 1.0)[:, None] * step
    away = ((at - point) ** 2).sum(axis=1)
    return at[np.lexsort((at[:, 1], at[:, 0], away))[0]]


def at_levels(line: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Points of a tip line (n, 3) at some elevations, its ends beyond it; NaN there."""
    order = np.argsort(line[:, 2], kind="stable")
    z = line[order, 2]
    found = np.stack([np.interp(levels, z, line[order, k]) for k in range(3)], axis=1)
    found[(levels < z[0]) | (levels > z[-1])] = np.nan
    return found
