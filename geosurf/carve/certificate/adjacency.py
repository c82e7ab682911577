"""Recompute the adjacency of units from the triangles of their shells.

Units with a common triangle are neighbours across all surfaces that lie on it (see
`check_partition`). Some triangles belong to no shell: a fault that ends inside a unit, or a horizon
that the column removed. A ray finds the unit around them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geosurf.carve.certificate.elements import Elements
from geosurf.carve.certificate.partition import Matched, rows_of
from geosurf.carve.rays import NO_HIT, Rays
from geosurf.kernels.lattices.sets import distinct, is_among
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.kernels.meshes.numbering import number_keys

ABOVE, BELOW = 1, -1


@dataclass(frozen=True)
class Around:
    """Units, and the surfaces between them.

    Attributes
    ----------
    patches : Elements
    found : Matched
    n_unit : int
    """

    patches: Elements
    found: Matched
    n_unit: int

    @cached_property
    def on(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles of shells, each surface they lie on, and whether the unit is behind it.

        Where surfaces coincide, a shell names only one of them, and each has its own orientation.
        """
        found = self.found

        # keys are sets of corners; those of a single triangle name their surface directly
        times = np.bincount(found.of_patches, minlength=found.n_key)
        once = np.flatnonzero((found.row >= 0) & (times[found.key] <= 1))

        # where surfaces coincide, list every triangle with the corners of the shell's one
        several = np.flatnonzero(times[found.key] > 1)
        rows = np.flatnonzero(times[found.of_patches] > 1)
        rows = rows[np.argsort(found.of_patches[rows], kind="stable")]
        start = np.searchsorted(found.of_patches[rows], found.key[several])
        count = times[found.key[several]]
        nth = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)

        # one row for each pair of shell triangle and surface; behind if both turn alike
        row = np.concatenate([found.row[once], rows[np.repeat(start, count) + nth]])
        shell = np.concatenate([once, np.repeat(several, count)])
        behind = found.turn[shell] == found.turn_of_patches[row]
        return shell, self.patches.surface_of_triangle[row], behind

    def on_each_side(self, of: np.ndarray) -> np.ndarray:
        """Value of `of` for the shell on either side of each triangle; -1 without a shell."""
        beside = np.full((self.found.n_key, 2), -1)
        beside[self.found.key, self.found.turn.astype(np.int64)] = of
        return beside

    @cached_property
    def _beside(self) -> np.ndarray:
        return self.on_each_side(self.found.unit)

    @cached_property
    def _links(self) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of neighbours (n, 2), and the pair of each triangle; n if it has fewer than two."""
        # triangles with a unit on both sides link these two; the pair is coded as one number
        one, other = self._beside.T
        inner = np.flatnonzero((one >= 0) & (other >= 0))
        low, high = np.minimum(one, other)[inner], np.maximum(one, other)[inner]
        codes, code = number_keys(low * self.n_unit + high)
        link = np.full(self.found.n_key, len(codes))
        link[inner] = code
        return np.stack(np.divmod(codes, self.n_unit), axis=1), link

    @cached_property
    def _times(self) -> np.ndarray:
        """Number of triangles of each surface between each pair of neighbours (n_surface, n)."""
        link, surface, _ = self._inner
        shape = len(self.patches.sources), len(self._links[0])
        times = np.bincount(surface * shape[1] + link, minlength=shape[0] * shape[1])
        return times.reshape(shape)

    @cached_property
    def _inner(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Each set of corners between two neighbours with each surface on it: pair of neighbours,
        surface, and key.
        """
        shell, surface, _ = self.on

        # the shell on one side lists all surfaces
        one = np.flatnonzero(self.found.turn[shell])
        key = self.found.key[shell[one]]
        link = self._links[1][key]
        inner = np.flatnonzero(link < len(self._links[0]))
        link, key, surface = link[inner], key[inner], surface[one[inner]]

        # where surfaces coincide, one may lie on itself: it counts once
        several = np.flatnonzero(self._several[key])
        _, first = np.unique(key[several] * len(self.patches.sources) + surface[several], True)
        once = ~self._several[key]
        once[several[first]] = True
        return link[once], surface[once], key[once]

    @cached_property
    def _several(self) -> np.ndarray:
        """Whether several triangles of the patches have the corners of a key."""
        return np.bincount(self.found.of_patches, minlength=self.found.n_key) > 1

    def _times_of(self, surfaces: list[int]) -> np.ndarray:
        """Number of triangles between each pair of neighbours that lie on one of some surfaces."""
        times: np.ndarray = self._times[surfaces].sum(axis=0)

        # each set of corners counts once, however many of the surfaces have it
        wanted = np.zeros(len(self.patches.sources), dtype=bool)
        wanted[surfaces] = True
        link, surface, key = self._coinciding
        mine = np.flatnonzero(wanted[surface])
        _, first = np.unique(key[mine], return_index=True)
        again = np.delete(mine, first)
        return times - np.bincount(link[again], minlength=len(times))

    @cached_property
    def _coinciding(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Those of `_inner` that lie where surfaces coincide."""
        link, surface, key = self._inner
        several = np.flatnonzero(self._several[key])
        return link[several], surface[several], key[several]

    @cached_property
    def _all(self) -> np.ndarray:
        return self._times_of(list(range(len(self.patches.sources))))

    @cached_property
    def _level(self) -> np.ndarray:
        """Number of triangles of horizons and contacts between each pair of neighbours."""
        level = [*rows_of(self.patches, "horizon"), *rows_of(self.patches, "contact")]
        return self._times_of(level)

    def neighbours_except_across(self, one: int, *, level: bool = False) -> np.ndarray:
        """Pairs of neighbours across a triangle that is not on surface `one`.

        With `level`, only across horizons and contacts.
        """
        some = self._level if level else self._all
        return self._links[0][some > self._times[one]]

    def touched(self, one: int, *, inside: bool = False) -> np.ndarray:
        """Whether each unit touches the front and the back of a surface, bool (n_unit, 2).

        With `inside`, triangles on walls do not count.
        """
        found: np.ndarray = self._touched[int(inside), one]
        return found

    @property
    def touched_all(self) -> np.ndarray:
        """Whether units touch front and back of each surface, bool (n_surface, n_unit, 2)."""
        found: np.ndarray = self._touched[0]
        return found

    @cached_property
    def _touched(self) -> np.ndarray:
        """What `touched` says of all surfaces with and without walls, bool (2, n, n_unit, 2)."""
        shell, surface, behind = self.on
        out = np.zeros((2, len(self.patches.sources), self.n_unit, 2), dtype=bool)
        unit, side = self.found.unit[shell], behind.astype(np.int64)
        out[0, surface, unit, side] = True
        off = ~self._on_walls[self.found.key[shell]]
        out[1, surface[off], unit[off], side[off]] = True
        return out

    def seen(self, some: list[int]) -> np.ndarray:
        """Whether front and back of a fault are reachable without crossing it, bool (n_unit, 2).

        Both are reachable from a unit that contains a part of it. A fault may have several
        surfaces: its own, and its virtual wall.
        """
        # regions: units that are connected without passing through the surfaces
        links = self._links[0][self._all > self._times_of(some)]
        region = join_pairs(links, self.n_unit)
        seen = _gathered(np.any([self.touched(one) for one in some], axis=0), region)
        if (seen[:, 0] != seen[:, 1]).any():
            for one in some:
                seen[np.isin(region, region[self.holding(one)])] = True
        return seen

    def side_of_horizon(self, one: int, front: int) -> np.ndarray:
        """Side of a horizon that each unit is on: ABOVE, BELOW, or 0 if it is unknown.

        The side holds across all other horizons. It holds across faults for stacks of units
        without this horizon, if all stacks around them agree: as in `zones`.

        Parameters
        ----------
        one : int
        front : int
            The side that its front faces.
        """
        # stacks: units between which only other horizons and contacts lie share a side
        stack = join_pairs(self.neighbours_except_across(one, level=True), self.n_unit)
        touched = _gathered(self.touched(one, inside=True), stack)
        side = front * (touched[:, 0].astype(np.int64) - touched[:, 1])
        torn = touched[:, 0] & touched[:, 1]

        # stacks that touch neither side take what all stacks across the faults say, if they agree
        links = self.neighbours_except_across(one)
        links = links[~torn[links].any(axis=1)]
        links = np.concatenate([links, links[:, ::-1]])  # from a known unit to an open one
        while True:
            open_ = links[(side[links[:, 0]] != 0) & (side[links[:, 1]] == 0)]
            says = np.zeros((self.n_unit, 2), dtype=bool)
            says[open_[:, 1], (side[open_[:, 0]] == BELOW).astype(np.int64)] = True
            says = _gathered(says, stack)
            new = (side == 0) & (says[:, 0] != says[:, 1])
            if not new.any():
                return side
            side[new] = np.where(says[new, 0], ABOVE, BELOW)

    def holding(self, one: int) -> np.ndarray:
        """Units that contain a part of a surface which belongs to no shell."""
        mine = self._bare[self.found.of_patches] & (self.patches.surface_of_triangle == one)
        rows = np.flatnonzero(mine & self._within)
        if len(rows) == 0:
            return np.empty(0, dtype=np.int64)

        # one ray from each connected piece is enough: a piece crosses no shell
        _, first, piece = np.unique(self._pieces(rows), return_index=True, return_inverse=True)
        set_of = np.full(len(self.found.of_patches), -2)
        set_of[self._shell_rows] = -1
        set_of[rows] = piece.ravel()
        x, t, element, starts = self.patches.triangles_near(rows[first], set_of > -2)
        set_of = set_of[element]
        side = Rays(x, t).shoot(starts, set_of, set_of < 0)[:, 1]
        side = side[side != NO_HIT]
        row, behind = element[side // 2], side % 2 == 1
        turn = (self.found.turn_of_patches[row] == behind).astype(np.int64)
        units = self._beside[self.found.of_patches[row], turn]
        return distinct(units[units >= 0])

    @cached_property
    def _bare(self) -> np.ndarray:
        """Whether each triangle belongs to no shell."""
        bare = np.ones(self.found.n_key, dtype=bool)
        bare[self.found.key] = False
        return bare

    @cached_property
    def _on_walls(self) -> np.ndarray:
        return lie_on(self.patches, self.found, rows_of(self.patches, "wall"))

    @cached_property
    def _within(self) -> np.ndarray:
        return self.patches.within

    @cached_property
    def _shell_rows(self) -> np.ndarray:
        """Triangles of the patches that belong to shells, one per set of corners."""
        first = np.full(self.found.n_key, -1)
        n = len(self.found.of_patches)
        first[self.found.of_patches[::-1]] = np.arange(n)[::-1]
        first[self._bare] = -1
        return first[first >= 0]

    def _pieces(self, rows: np.ndarray) -> np.ndarray:
        """Connected piece of each element: joined by edges that belong to no shell."""
        patches = self.patches
        n = len(patches.local)
        number = np.full(len(self.found.of_patches), -1)
        number[rows] = np.arange(len(rows))
        is_shell = np.zeros(len(number), dtype=bool)
        is_shell[self._shell_rows] = True

        mine = np.flatnonzero(number[patches.element] >= 0)
        t, of = patches.triangles[mine], number[patches.element[mine]]
        used = np.zeros(n, dtype=bool)
        used[t] = True
        beside = patches.triangles[is_shell[patches.element]]
        one, two, three = (used.take(beside[:, k]) for k in range(3))
        beside = beside[(one & two) | (one & three) | (two & three)]
        edges = _edges(t, n)

        # edges of shells part pieces: what is on their two sides may be in two units
        edges[is_among(edges, distinct(_edges(beside, n)))] = -1
        order = np.argsort(edges, kind="stable")
        same = np.flatnonzero((np.diff(edges[order]) == 0) & (edges[order[1:]] >= 0))
        pairs = of[np.stack([order[same], order[same + 1]], axis=1) // 3]
        joined = number[patches.joined]
        joined = joined[(joined >= 0).all(axis=1)]
        return join_pairs(np.concatenate([pairs, joined]), len(rows))


def lie_on(patches: Elements, found: Matched, surfaces: list[int]) -> np.ndarray:
    """Whether each key is a triangle of one of the surfaces."""
    out = np.zeros(found.n_key, dtype=bool)
    out[found.of_patches[np.isin(patches.surface_of_triangle, surfaces)]] = True
    return out


def _gathered(marks: np.ndarray, region: np.ndarray) -> np.ndarray:
    """Marks (n, 2), combined over all elements of each region."""
    whole = np.zeros_like(marks)
    for k in range(2):
        whole[region[marks[:, k]], k] = True
    return whole[region]


def _edges(triangles: np.ndarray, n: int) -> np.ndarray:
    """Edges of triangles, three for each, one number for both ways of each."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    return np.minimum(a, b) * n + np.maximum(a, b)
