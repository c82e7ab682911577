"""How throw dies at the tips of a fault, which the smoothest sheet alone cannot know.

Around a fault that ends, walls bend as around a crack: throw grows from the tip with the root of
the distance, or another power, and no sheet with small third differences does. Smoothed alone,
throw would die along the fault for some cells more than it does. So shapes that bend like that are
taken out of the sheet before it is smoothed, and put back after it: as much of each as leaves the
smoothest residual (`geosurf.sheets.heights.tip_solve`). Throw that dies in another way is left
to the residual.

The shapes of a fault between two tips are the imaginary parts of J, J^2, .. with z = (J + 1/J) / 2,
|J| < 1, z = s + i r: harmonic, fading away from the fault, and on it sin(k t) at s = cos(t), the
series of throws of a crack (Muskhelishvili 1953; Pollard & Segall 1987). Those of a fault with one
tip are the first terms at it alone, z^(1/2) and z^(3/2) (Williams 1957), and fade out before its
other end. To add known shapes to a space of smooth ones: Belytschko & Black (1999), Int. J. Numer.
Methods Eng. 45, 601-620.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.model import Lattice, Sheet, TriSurface
from geosurf.sheets.faults.cut_edges import Cuts
from geosurf.sheets.faults.fault_distance import (
    Blocks,
    NearTrace,
    blocks_between,
    side_at_own_height,
    window,
)
from geosurf.sheets.faults.traces import Trace, mesh_in_frame
from geosurf.sheets.lattice.picks import frame_of_lattice

TERMS = 5  # shapes between two tips; docs/validation/torn_sheets.md has what fewer and more do
POWERS = (0.5, 1.5)  # of the distance from a single tip
FADE = 30.0  # cells from a single tip at which its shapes are nothing, or sooner
SHORTEST = 3.0  # cells: shorter faults have no shapes
STEP = 0.5  # cells between the places of a line
CHORD = 2.0  # cells that a line is drawn on straight by


@dataclass(frozen=True, eq=False)
class Tips:
    """The tips of one trace, in coordinates along it and across it.

    Attributes
    ----------
    trace : int
    tips : ndarray (n, 2)
        Where it ends [cells].
    origin, ahead : ndarray (2,)
        Of the coordinates: between both tips, or at the single one; a unit vector along the line.
    line : ndarray (2, n)
        How far the trace lies across, at places along, increasing.
    size : float
        Half length between two tips, or distance at which shapes have faded.
    near : NearTrace
        Sides of nodes: those that the links were cut by.
    turn : float
        -1 if the coordinates run against the trace.
    """

    trace: int
    tips: np.ndarray
    origin: np.ndarray
    ahead: np.ndarray
    line: np.ndarray
    size: float
    near: NearTrace
    turn: float = 1.0

    def _flat(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates along and across, the trace being straight."""
        x, y = _along_across(places - self.origin, self.ahead)
        return x, y - np.interp(x, *self.line)

    def side(self, nodes: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """On which side of the coordinates places [cells] are, and whether next to the tear."""
        return self._side_at(nodes, *self._flat(places))

    def _side_at(
        self, nodes: np.ndarray, x: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The same for coordinates of `_flat`."""
        beside = np.abs(x) < self.size if len(self.tips) == 2 else x < 0

        # next to the tear a node's side is the one that links were cut by, even where the
        # straightened coordinate disagrees by rounding; elsewhere that of the coordinate
        row = self.near.look_up(nodes)
        known = beside & (row >= 0)
        side = np.where(y >= 0, 1.0, -1.0)
        side[known] = self.turn * self.near.side[row[known]]
        return side, beside

    @property
    def n_shape(self) -> int:
        """Number of shapes."""
        return TERMS if len(self.tips) == 2 else len(POWERS)

    def throw_towards(self) -> np.ndarray:
        """Throw (n_tip, 2, k) of each shape close to each tip, and further in, up to factors > 0.

        A sum of shapes whose two throws differ in sign would turn over before it dies.
        """
        if len(self.tips) == 2:
            k = np.arange(1, TERMS + 1)
            there = np.stack([k, np.sin(0.25 * np.pi * k)])
            return np.stack([there * (-1.0) ** (k + 1), there])  # the first tip is at s = -1
        p = np.array(POWERS)
        turned = np.sin(np.pi * p)
        return np.stack([np.where(p == p.min(), turned, 0.0), 0.25**p * turned])[None]

    def shapes(
        self, nodes: np.ndarray, places: np.ndarray, wall: np.ndarray | None = None
    ) -> np.ndarray:
        """Shapes (n, k) at places [cells]; `wall`: the side of an extrapolated sheet."""
        x, y = self._flat(places)
        side, _ = self._side_at(nodes, x, y)

        # upper half plane on the left; off the branch cut by a hair, so that roots are one-sided
        z = (x + 1j * side * np.maximum(np.abs(y), 1e-12)) / self.size
        past = np.zeros(len(x), dtype=bool) if wall is None else (wall != 0) & (wall != side)
        if len(self.tips) == 2:
            # J of the Joukowski map:
            # J
            # < 1 outside the slit; 1 / J continues a wall past the slit
            j = z - np.sqrt(z - 1.0) * np.sqrt(z + 1.0)
            j = np.where(past, 1.0 / j, j)
            return np.stack([-(j**k).imag for k in range(1, TERMS + 1)], axis=1)

        # past the slit a wall turns on around the tip, by a full circle
        angle = np.angle(z) - np.where(past, 2.0 * np.pi * side, 0.0)
        far = np.abs(z)

        # three derivatives vanish at the rim as well: third differences see no edge there
        fade = (1.0 - np.minimum(far, 1.0) ** 2) ** 4
        return np.stack([fade * far**p * np.sin(p * angle) for p in POWERS], axis=1)


def tips_of(traces: Sequence[Trace], near: Sequence[NearTrace], cuts: Cuts) -> list[Tips]:
    """The tips of all traces, as far as they are torn."""
    all_tips = []
    for number, trace in enumerate(traces):
        place = cuts.place[cuts.trace == number]
        free = [k for k in range(2) if trace.ends[k] == "tip"]
        if not free or not len(place):
            continue

        # only as far as links are cut: throw dies at the last one, not at the end of the fault
        ends = max(trace.start, place.min()), min(trace.stop, place.max())
        if len(free) == 2:
            tips = [_between(number, trace, near[number], ends)]

            # a trace that turns back has no straight coordinates between its tips: each tip by
            # itself
            if tips[0] is None:
                tips = [_single(number, trace, near[number], ends, k) for k in free]
        else:
            tips = [_single(number, trace, near[number], ends, free[0])]
        all_tips += [t for t in tips if t is not None]
    return all_tips


def _line(trace: Trace, ends: tuple[float, float]) -> np.ndarray:
    """Places (n, 2) along a trace between two of its places [cells]."""
    first, last = trace.length_at(ends)

    # steps of equal length, whatever the vertices of the trace are
    s = np.linspace(first, last, max(int((last - first) / STEP), 1) + 1)
    return trace.at_length(s)[:, :2]


def _between(number: int, trace: Trace, near: NearTrace, ends: tuple[float, float]) -> Tips | None:
    """Coordinates between two tips; None if the trace turns back on the line through them."""
    line = _line(trace, ends)

    # coordinates x along the chord, y across it, both in cells
    half = 0.5 * (line[-1] - line[0])
    size = float(np.hypot(*half))
    if size < SHORTEST:
        return None
    origin, ahead = line[0] + half, half / size
    x, y = _along_across(line - origin, ahead)
    if len(_turned(x, y)):
        return None
    table = _drawn_on(x, y, (True, True))
    return Tips(number, line[[0, -1]], origin, ahead, table, size, near)


def _single(
    number: int, trace: Trace, near: NearTrace, ends: tuple[float, float], k: int
) -> Tips | None:
    """Coordinates at one tip, along the last cells of the trace."""
    line = _line(trace, ends)
    line = line[::-1] if k == 0 else line
    tip = line[-1]

    # the direction of the last two cells: that of the tip itself is rounding
    ahead = tip - line[-1 - min(int(CHORD / STEP), len(line) - 1)]
    size = float(np.hypot(*ahead))
    if size == 0.0:
        return None
    ahead = ahead / size
    x, y = _along_across(line - tip, ahead)

    # only the part after the last turn is a function of x
    turned = _turned(x, y)
    first = int(turned[-1]) + 1 if len(turned) else 0
    reach = min(FADE, -float(x[first]))
    if reach < SHORTEST:
        return None
    table = _drawn_on(x[first:], y[first:], (False, True))
    return Tips(number, tip[None], tip, ahead, table, reach, near, -1.0 if k == 0 else 1.0)


def _along_across(away: np.ndarray, ahead: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along and across."""
    return away @ ahead, away @ np.array([-ahead[1], ahead[0]])


def _turned(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Steps of a line that lead by more than 60 degrees away from its coordinate along."""
    return np.flatnonzero(np.diff(x) <= 0.5 * np.hypot(np.diff(x), np.diff(y)))


def _drawn_on(x: np.ndarray, y: np.ndarray, ends: tuple[bool, bool]) -> np.ndarray:
    """The table of a line (2, n), straight on past its ends."""
    k = min(int(CHORD / STEP), len(x) - 1)
    far = 1000.0
    if ends[0]:
        # past an end the line goes on by the mean slope of its last two cells
        slope = (y[k] - y[0]) / (x[k] - x[0])
        x, y = np.append(x[0] - far, x), np.append(y[0] - far * slope, y)
    if ends[1]:
        slope = (y[-1] - y[-1 - k]) / (x[-1] - x[-1 - k])
        x, y = np.append(x, x[-1] + far), np.append(y, y[-1] + far * slope)
    return np.stack([x, y])


# ---- longer faults ----------------------------------------
# Whether a horizon is the same at a fault that became longer elsewhere.
#
# A tear reads its faults where they are near the horizon: distances of data at their own height,
# traces, tips and branches. So a horizon is torn again only where a longer fault comes within
# `NEAR` cells of it.
#
# That nothing farther away matters is an assumption, measured and not proven. On three fields every
# sheet that changed had a new triangle within 3.4 cells, so 12 cells are 3.5 times what was needed.
# If it were wrong, one horizon would keep heights of the shorter fault: where the rule has to bite,
# they differ by up to 0.1 m in the synthetic world of the tests. The sheet still ends on the longer
# fault, and the certificate still holds.


NEAR = 12.0  # cells; an assumption, see above


def is_unchanged(
    sheet: Sheet, before: Mapping[str, TriSurface], after: Mapping[str, TriSurface]
) -> bool:
    """Whether a sheet that ends on some faults is that of longer ones, too.

    Parameters
    ----------
    sheet : Sheet
    before, after : mapping of str to TriSurface
        Faults that it was torn at, and the same or longer ones.
    """
    if all(fault is after[name] for name, fault in before.items()):
        return True
    points = _Vertices(sheet)
    return all(_is_far(points, fault, after[name]) for name, fault in before.items())


def as_near(
    horizon: TriSurface, versions: Mapping[str, Sequence[TriSurface]]
) -> dict[str, TriSurface]:
    """Return faults as short as a horizon can take them before it is torn.

    Parameters
    ----------
    horizon : TriSurface
        Without tears. One without a lattice takes all faults as long as they are.
    versions : mapping of str to sequence of TriSurface
        Each fault as it became longer.
    """
    if horizon.lattice is None:
        return {name: known[-1] for name, known in versions.items()}
    points = _Nodes(horizon.lattice, horizon.name)
    return {
        name: next(one for one in known if _is_far(points, one, known[-1]))
        for name, known in versions.items()
    }


class _Nodes:
    """Nodes of a lattice; only those in some blocks are listed."""

    def __init__(self, lattice: Lattice, name: str) -> None:
        self.frame, z = frame_of_lattice(lattice, f"horizon {name!r}")
        self._z = z.ravel()
        self.low, self.high = float(np.nanmin(z)), float(np.nanmax(z))

    def near(self, blocks: Blocks) -> np.ndarray:
        """Columns and rows [cells], and elevations, of all that can be near (n, 3)."""
        nodes = window(self.frame, blocks)
        nodes = nodes[np.isfinite(self._z[nodes])]
        return np.column_stack([self.frame.cells_of_node(nodes), self._z[nodes]])


class _Vertices:
    """Nodes of a sheet, and ghosts beyond them."""

    def __init__(self, sheet: Sheet) -> None:
        self.frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
        points = sheet.surface.vertices
        uv = self.frame.to_cells(points[:, :2])
        self._places = np.column_stack([uv, points[:, 2]])
        self.low, self.high = float(points[:, 2].min()), float(points[:, 2].max())

    def near(self, blocks: Blocks) -> np.ndarray:
        """Columns and rows [cells], and elevations, of all (n, 3)."""
        return self._places


def _is_far(points: _Nodes | _Vertices, fault: TriSurface, longer: TriSurface) -> bool:
    """Whether a fault became longer only where no point is near, or not at all."""
    if fault is longer:
        return True

    # an extension leaves what was given as it is, and adds to it
    n, m = fault.n_vertex, fault.n_triangle
    if not np.array_equal(fault.vertices, longer.vertices[:n]):
        return False
    if not np.array_equal(fault.triangles, longer.triangles[:m]):
        return False
    if longer.n_triangle == m:
        return True

    # at their own height, as data are compared with a fault
    mesh = mesh_in_frame(longer, points.frame)
    mesh = replace(mesh, triangles=mesh.triangles[m:], normals=mesh.normals[m:])
    added, blocks = blocks_between(mesh, NEAR, points.low, points.high)
    if blocks is None:
        return True
    _, side = side_at_own_height(added, blocks, points.near(blocks), NEAR)
    return not side.any()
