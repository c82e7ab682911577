"""Sums over faces of cells: those of faces that an earlier scene has are taken from there.

A face is what one surface has between two cells, and made of whole patches. If all of its patches
are those of one earlier face, which has no others, both have the same triangles and runs in the
same order: what was summed over one holds for the other, to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np

_MOST = 8  # kinds of sums that are kept: a loop over levels would add one for each


@dataclass(eq=False)
class FaceSums:
    """What is known of the faces of some cells.

    Attributes
    ----------
    of_patch : ndarray of int64, shape (n_patch,), or None
        Face that each patch is a part of, or -1; None where faces are not made of whole patches.
    n_face : int
    before : ndarray of int64, shape (n_face,)
        Earlier face that each face is, or -1.
    earlier, found : dict
        Rows (n_face, n) by kind of sum, of the earlier faces and of these; NaN where unknown.
    """

    of_patch: np.ndarray | None
    n_face: int
    before: np.ndarray
    earlier: dict[Hashable, np.ndarray] = field(default_factory=dict)
    found: dict[Hashable, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        of_patch: np.ndarray | None,
        n_face: int,
        earlier: FaceSums | None = None,
        after: np.ndarray | None = None,
    ) -> FaceSums:
        """Return the sums of some faces, of which none is known unless earlier faces are given.

        `after` has the patch that each earlier patch is now, or -1 if it has changed.
        """
        before = np.full(n_face, -1, dtype=np.int64)
        if of_patch is None or earlier is None or after is None or earlier.of_patch is None:
            return cls(of_patch, n_face, before)

        # lowest and highest earlier face among the patches of each face; -1 for a patch that is new
        source = np.full(len(of_patch), -1, dtype=np.int64)
        stay = np.flatnonzero(after >= 0)
        source[after[stay]] = earlier.of_patch[stay]
        rows = np.flatnonzero(of_patch >= 0)
        low, high = np.full(n_face, earlier.n_face), before.copy()
        np.minimum.at(low, of_patch[rows], source[rows])
        np.maximum.at(high, of_patch[rows], source[rows])

        # and no patch of the earlier face is missing
        held = earlier.of_patch[earlier.of_patch >= 0]
        n_before = np.bincount(held, minlength=earlier.n_face)
        same = np.flatnonzero((low == high) & (low >= 0))
        n_now = np.bincount(of_patch[rows], minlength=n_face)
        same = same[n_before[low[same]] == n_now[same]]
        before[same] = low[same]
        return cls(of_patch, n_face, before, earlier.found)

    def complete(
        self,
        kind: Hashable,
        wanted: np.ndarray,
        run: Callable[[np.ndarray], np.ndarray],
    ) -> np.ndarray:
        """
        Return the sums of the faces that are wanted; only those that are not known are found.

        Parameters
        ----------
        kind : hashable
            What is summed.
        wanted : ndarray of bool, shape (n_face,)
        run : callable
            Takes which faces are to be summed, and returns rows (n_face, n).

        Returns
        -------
        ndarray of float64, shape (n_face, n)
            NaN for faces that are not wanted.
        """
        known = self.earlier.get(kind)
        rows = np.flatnonzero(wanted & (self.before >= 0))
        if known is None:
            rows = rows[:0]
        else:
            rows = rows[~np.isnan(known[self.before[rows], 0])]
        asked = wanted.copy()
        asked[rows] = False

        found = run(asked)
        found[~asked] = np.nan
        if known is not None:
            found[rows] = known[self.before[rows]]
        if len(self.found) >= _MOST:
            self.found.pop(next(iter(self.found)))
        self.found[kind] = found
        return found
