"""A horizon moved by its faults: the height of each sheet anywhere, as if its wall had no end.

The sheet of a wall at a place is found from the particle that has come there: its place before is
the fixed point of "the place less the movement". Faults act from the oldest to the youngest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_edt

from geosurf.conventions import place, rising_diagonal
from geosurf.errors import GeometryError
from geosurf.kernels.sheets.link_lines import UNIT
from geosurf.kernels.sheets.moved_rock import first_folded, heights_on_triangles, settle
from geosurf.model import TriSurface
from geosurf.sheets.faults.fault_profile import dip_lines
from geosurf.sheets.faults.slip import Slip
from geosurf.sheets.heights.passes import MAP_REACH
from geosurf.sheets.lattice.picks import Frame, Picks

ROUNDS = 200  # steps to the fixed point; each halves the error at least, unless beds fold
RIM = 1e-9  # cells: nearer than this to the rim of a hole is on it
CLOSE = 1e-10  # cells: how near the particle has to come

Parts = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Before:
    """The horizon before it was faulted, linear on its triangles, and on past its rim."""

    def __init__(self, name: str, values: np.ndarray, frame: Frame, rising: bool) -> None:
        self.name, self.frame = name, frame
        self.values, self.rising = values, rising
        self.to_columns = np.linalg.inv(frame.step)
        self.holes = bool(np.isnan(values).any())
        self.filled = np.ascontiguousarray(_filled(values) if self.holes else values, np.float64)

    def _corners(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (n, 3) of the triangle at each place, and their weights (n, 3)."""
        n_row, n_col = self.values.shape

        # column and row; beyond the rim the outermost triangles are extended
        x, y = (xy @ self.to_columns).T
        j = np.clip(np.floor(x), 0, n_col - 2).astype(np.int64)
        i = np.clip(np.floor(y), 0, n_row - 2).astype(np.int64)

        # f, g: shares within the cell, below 0 or above 1 beyond the rim, which extrapolates
        f, g = x - j, y - i

        # corners of the cell a, b, c, d: anticlockwise, a at its lower left
        a = i * n_col + j
        b, d, c = a + 1, a + n_col, a + n_col + 1
        if self.rising:  # a joins c
            low = f >= g
            middle = np.where(low, b, d)
            large, small = np.maximum(f, g), np.minimum(f, g)
            return np.stack([a, middle, c], axis=1), np.stack([1 - large, large - small, small], 1)
        low = f + g <= 1.0
        corner = np.where(low, a, c)
        first = np.where(low, 1 - f - g, f + g - 1)
        one, two = np.where(low, f, 1 - g), np.where(low, g, 1 - f)
        return np.stack([corner, b, d], axis=1), np.stack([first, one, two], axis=1)

    def _cells(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Columns and rows, broken, of places (n, 2)."""
        (a, b), (c, d) = self.to_columns
        return xy[:, 0] * a + xy[:, 1] * c, xy[:, 0] * b + xy[:, 1] * d

    def at(self, xy: np.ndarray) -> np.ndarray:
        """Elevation (n,) at places (n, 2) from the corner; holes take the nearest value."""
        out = np.empty(len(xy))
        heights_on_triangles(self.filled, self.rising, *self._cells(xy), out)
        return out

    def without_lost(self, values: np.ndarray, xy: np.ndarray) -> np.ndarray:
        """Values (n,), NaN for places (n, 2) in holes; the rim of a hole is not in it."""
        return np.where(self.lost(xy), np.nan, values) if self.holes else values

    def lost(self, xy: np.ndarray) -> np.ndarray:
        """Mask (n,) of places in holes."""
        node, weight = self._corners(xy)
        return (np.isnan(self.values.ravel()[node]) & (weight > RIM)).any(axis=1)

    def outside(self, xy: np.ndarray) -> np.ndarray:
        """Distance (n,) by which places lie outside of the lattice [cells]."""
        u, v = self._cells(xy)
        n_row, n_col = self.values.shape
        zero = np.zeros(len(xy))
        return np.maximum.reduce([-u, u - (n_col - 1.0), -v, v - (n_row - 1.0), zero])


def _filled(values: np.ndarray) -> np.ndarray:
    """Holes take the nearest value, so that a particle may be sought across them."""
    nearest = distance_transform_edt(np.isnan(values), return_distances=False, return_indices=True)
    return values[tuple(nearest)]


def sheet_heights(
    before: Before, slips: Sequence[Slip], xy: np.ndarray, parts: np.ndarray | Parts, cell: float
) -> tuple[np.ndarray, np.ndarray]:
    """
    Elevations of the moved horizon at places, and where its particles were.

    Parameters
    ----------
    before : Before
    slips : sequence of Slip
        Youngest first.
    xy : ndarray (n, 2)
        From the corner of the frame [m].
    parts : ndarray (n_slip, n) or callable
        See `Slip.move`; or a function of places and elevations.
    cell : float
        [m]

    Returns
    -------
    elevation : ndarray (n,)
        Holes of the horizon take the nearest value.
    was : ndarray (n, 2)
        `Before.lost` gives which are in a hole.

    Raises
    ------
    GeometryError
        If the movement changes so quickly that beds would fold over: names the place.
    """
    close = CLOSE * cell + 4.0 * np.finfo(np.float64).eps * np.abs(xy).max(initial=0.0)
    z, was = before.at(xy), xy.copy()
    todo, where, at, old = np.arange(len(xy)), xy, was.copy(), z
    for _ in range(ROUNDS):
        # share (n_slip, n): part of the throw of each fault at each place
        share = parts(where, old) if callable(parts) else parts[:, todo]

        # forward: the particle from its old place through all faults, the oldest first
        now, height = at, before.at(at)
        for slip, part in zip(reversed(slips), reversed(list(share)), strict=True):
            now, height = slip.move(now, height, part)

        # Picard iteration: the origin is shifted by as much as the particle misses its place; only
        # particles that have not arrived go on, after a few rounds hardly any
        both = callable(parts)
        todo, where, at, old = settle(todo, where, at, old, now, height, both, close, z, was)
        if len(todo) == 0:
            break
    if len(todo):
        raise _folded(before, np.append(where[0] + before.frame.corner, old[0]))
    return z, was


def refuse_folds(before: Before, slips: Sequence[Slip], xy: np.ndarray, parts: np.ndarray) -> None:
    """Raise an error where cells of nodes xy turn over that move with `parts` of the throw."""
    # only cells whose four nodes are in one wall: a fault may open or close the others
    now, height = xy, before.at(xy)
    for slip, part in zip(reversed(slips), reversed(list(parts)), strict=True):
        now, height = slip.move(now, height, part)
    node = first_folded(np.ascontiguousarray(now), parts, *before.values.shape)
    if node >= 0:
        raise _folded(before, np.append(xy[node] + before.frame.corner, before.at(xy[[node]])))


def _folded(before: Before, where: np.ndarray) -> GeometryError:
    return GeometryError(
        f"horizon {before.name!r}: throw changes so quickly at {place(where)} that beds would "
        "fold over each other. Let it change over a longer distance, or lower it.",
        place=where,
        surfaces=(before.name,),
    )


# ---- movement ----------------------------------------
# How the faults of one horizon move it: parts of the throw in walls, and the moved heights.
#
# In a wall, a fault acts by its part of the throw. Beyond the fault that it ends on, a branch has
# one wall only. Places are x and y from the corner of the frame [m]; elevations are in metres.


TOUCH = 0.01  # cells from a fault within which the rim of another one lies on it


@dataclass(frozen=True)
class Branches:
    """Which faults end on others, and which ones the horizon meets.

    Attributes
    ----------
    mains : tuple of dict
        For each fault the main faults that it ends on, and its wall of them: 1.0 hanging wall.
    acts : tuple of bool
        For each fault whether it moves its walls apart; otherwise all rock is in its footwall.
    """

    mains: tuple[dict[int, float], ...]
    acts: tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class Movement:
    """One horizon, its faults from the youngest to the oldest, and how they move it.

    Attributes
    ----------
    picks : Picks
        The horizon before faulting, all nodes of a lattice.
    faults : list of TriSurface
    slips : list of Slip
    largest : list of float
        Largest throw of each fault at the elevations of the horizon, by size [m].
    blend : list of float
        Distance across each fault over which the drape changes from wall to wall [m].
    reach : float
        Cells from a trace within which a node belongs to a wall by the trace.
    before : Before
        The horizon as a function of the place.
    xy : ndarray (n_node, 2)
        Places of the nodes.
    rising : bool
        Whether the diagonals of the lattice rise to the north-east.
    """

    picks: Picks
    faults: list[TriSurface]
    slips: list[Slip]
    largest: list[float]
    blend: list[float]
    reach: float
    before: Before
    xy: np.ndarray
    rising: bool

    @property
    def frame(self) -> Frame:
        """Lattice of the horizon."""
        return self.picks.frame

    def distance(self, fault: int, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Distance (n,) across strike from a fault at their elevation, into its hanging wall."""
        return self.slips[fault].section.distance(xy, z)

    def in_hanging_walls(self, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Walls (n_slip, n) of places: 1 hanging wall, 0 footwall or on the fault."""
        out = np.empty((len(self.slips), len(xy)))
        for k in range(len(self.slips)):
            # rounded to the units that traces are on: less is noise for a place on the fault
            out[k] = np.rint(self.distance(k, xy, z) / self.frame.cell * UNIT) > 0
        return out

    def gradual_parts(self, lean: float, branches: Branches) -> Parts:
        """Parts of the throw in walls that change gradually from 0 to 1, `lean` on each fault."""

        def parts(xy: np.ndarray, z: np.ndarray) -> np.ndarray:
            """Parts (n_slip, n) at places and elevations."""
            far = [slip.section.distance(xy, z) for slip in self.slips]
            walls = [
                np.clip(lean + f / (2.0 * w), 0.0, 1.0)
                for f, w in zip(far, self.blend, strict=True)
            ]
            return self.parts(branches, np.array(walls).reshape(len(far), len(xy)))

        return parts

    def parts(self, branches: Branches, walls: np.ndarray) -> np.ndarray:
        """Parts (n_slip, n) of the throw (see `Slip.move`) in walls, 1 hanging, 0 foot.

        Beyond its main fault a branch has one wall only: the one that lies in that direction.
        """
        out, ends = np.empty_like(walls), self._ends(branches)
        for k, slip in enumerate(self.slips):
            # a fault that does not meet the horizon moves nothing: part 0
            wall = walls[k] if branches.acts[k] else np.full_like(walls[k], 1.0 - slip.share)
            for branch, main, own, beyond in ends:
                if branch == k:
                    here = walls[main] if own > 0.5 else 1.0 - walls[main]
                    wall = wall * here + beyond * (1.0 - here)
            out[k] = wall - 1.0 + slip.share
        return out

    def _ends(self, branches: Branches) -> list[tuple[int, int, float, float]]:
        """Branches, their main faults, their walls of these, and the wall that they have beyond."""
        ends = []
        for k, (slip, mains) in enumerate(zip(self.slips, branches.mains, strict=True)):
            # axes[1] points across strike into the hanging wall
            for main, wall in mains.items():
                # beyond its main fault a branch has one wall only: the one that the main fault's
                # far side lies in, by the directions of both across strike
                away = self.slips[main].section.axes[1] * (1.0 - 2.0 * wall)
                beyond = float(away @ slip.section.axes[1] > 0)
                # a fault that ends there on the other side moves rock there, such as the other
                # half of an older fault: this one leaves it
                if any(other.get(main) == 1.0 - wall for other in branches.mains):
                    beyond = 1.0 - slip.share
                ends.append((k, main, wall, beyond))
        return ends

    def heights(
        self, branches: Branches, xy: np.ndarray, walls: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Heights (n,) at places in walls (n_slip, n), NaN in holes; and where the rock was."""
        z, was = sheet_heights(
            self.before, self.slips, xy, self.parts(branches, walls), self.frame.cell
        )
        return self.before.without_lost(z, was), was

    def touching(self) -> tuple[dict[int, float], ...]:
        """For each fault the faults that its rim lies on, with its other points on one side."""
        mains: list[dict[int, float]] = [{} for _ in self.slips]
        near = TOUCH * self.frame.cell
        for k, fault in enumerate(self.faults):
            # places from the corner, as sections count them
            points = fault.vertices - np.append(self.frame.corner, 0.0)
            z = points[:, 2]
            for main, slip in enumerate(self.slips):
                if main == k:
                    continue
                s, _ = slip.section.of(points[:, :2])
                here = (s >= 0) & (s <= slip.section.length)
                here &= (z >= slip.section.z[0]) & (z <= slip.section.z[1])
                far = self.distance(main, points[:, :2], z)
                if not (here & (np.abs(far) <= near)).any():
                    continue

                # on both sides it crosses the other fault; on neither it lies in it
                if (far >= -near).all() != (far <= near).all():
                    mains[k][main] = float((far >= -near).all())
        return tuple(mains)

    def first_branches(self) -> Branches:
        """Branches by the faults alone, before any trace is known: every fault acts."""
        return Branches(self.touching(), (True,) * len(self.slips))


def movement_of(
    picks: Picks,
    faults: list[TriSurface],
    slips: list[Slip],
    turning: list[bool],
    sizes: list[tuple[float, float]],
) -> Movement:
    """Movement of a horizon; `turning`: whether walls move down the local dip of each fault.

    `sizes` are the largest throw and heave of each fault at the elevations of the horizon [m].
    """
    frame = picks.frame
    values = np.full(picks.n_node, np.nan)
    values[picks.node] = picks.z
    rising = rising_diagonal(frame.easting, frame.northing)

    # lines down the dip, straightened where this throw would stretch rock along strike
    lines = [
        dip_lines(slip.section, throw, frame.cell) if turns else None
        for slip, (throw, _), turns in zip(slips, sizes, turning, strict=True)
    ]
    # traces run between the cut-offs: a wall reaches past its trace by a part of the heave
    widest = max((heave for _, heave in sizes), default=0.0) / frame.cell
    return Movement(
        picks=picks,
        faults=faults,
        slips=[replace(slip, lines=line) for slip, line in zip(slips, lines, strict=True)],
        largest=[throw for throw, _ in sizes],
        blend=[max(2.0 * heave, frame.cell) for _, heave in sizes],
        reach=max(MAP_REACH, np.ceil(widest) + 3.0),
        before=Before(picks.name, values.reshape(frame.shape), frame, rising),
        xy=frame.places,
        rising=rising,
    )
