"""How the faults of one horizon move it: parts of the throw in walls, and the moved heights.

In a wall, a fault acts by its part of the throw. Beyond the fault that it ends on, a branch has one
wall only. Places are x and y from the corner of the frame [m]; elevations are in metres.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geosurf.conventions import rising_diagonal
from geosurf.kernels.sheets.fault_distance import UNIT
from geosurf.model import TriSurface
from geosurf.sheets.faults.dip_lines import dip_lines
from geosurf.sheets.faults.slip import Slip
from geosurf.sheets.heights.passes import MAP_REACH
from geosurf.sheets.lattice.frame import Frame
from geosurf.sheets.lattice.picks import Picks
from geosurf.sheets.throw.displacement import Before, GradualParts, parts_in, sheet_heights

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

    def gradual_parts(self, lean: float, branches: Branches) -> GradualParts:
        """Parts of the throw in walls that change gradually from 0 to 1, `lean` on each fault."""
        return GradualParts(self.slips, lean, self.blend, branches.acts, self._ends(branches))

    def parts(self, branches: Branches, walls: np.ndarray) -> np.ndarray:
        """Parts (n_slip, n) of the throw (see `Slip.move`) in walls, 1 hanging, 0 foot.

        Beyond its main fault a branch has one wall only: the one that lies in that direction.
        """
        return parts_in(self.slips, branches.acts, self._ends(branches), walls)

    def _ends(self, branches: Branches) -> list[tuple[int, int, float, float]]:
        """Branches, their main faults, their walls of these, and the wall that they have beyond."""
        found = []
        for k, (slip, mains) in enumerate(zip(self.slips, branches.mains, strict=True)):
            # axes[1] points across strike into the hanging wall
            for main, own in mains.items():
                # beyond its main fault a branch has one wall only: the one that the main fault's
                # far side lies in, by the directions of both across strike
                away = self.slips[main].section.axes[1] * (1.0 - 2.0 * own)
                beyond = float(away @ slip.section.axes[1] > 0)
                # a fault that ends there on the other side moves rock there, such as the other
                # half of an older fault: this one leaves it
                if any(other.get(main) == 1.0 - own for other in branches.mains):
                    beyond = 1.0 - slip.share
                found.append((k, main, own, beyond))
        return found

    def heights(
        self, branches: Branches, node: np.ndarray, walls: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Heights (n,) over nodes in walls (n_slip, n), NaN in holes; and where the rock was."""
        return self.heights_at(branches, self.xy[node], walls)

    def heights_at(
        self, branches: Branches, xy: np.ndarray, walls: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Heights (n,) at places in walls (n_slip, n), NaN in holes; and where the rock was."""
        z, was = sheet_heights(
            self.before, self.slips, xy, self.parts(branches, walls), self.frame.cell
        )
        return self.before.without_lost(z, was), was

    def touching(self) -> tuple[dict[int, float], ...]:
        """For each fault the faults that its rim lies on, with its other points on one side."""
        found: list[dict[int, float]] = [{} for _ in self.slips]
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
                    found[k][main] = float((far >= -near).all())
        return tuple(found)

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
