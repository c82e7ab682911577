"""What closed a sheet, as numbers: where the tear of slightly other data starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class DataUse:
    """
    What a sheet made of its data.

    Attributes
    ----------
    ignored : ndarray of bool (n_data,)
        Data that were not used.
    wrong : ndarray of bool (n_data,)
        Data among these that are on a wrong side, in the map or at their own height.
    near : tuple of ndarray of int64
        By fault: the data near it, increasing.
    side : tuple of ndarray of int8
        By fault: the side of each of these, 1 in the hanging wall and -1 in the footwall.
    """

    ignored: np.ndarray
    wrong: np.ndarray
    near: tuple[np.ndarray, ...]
    side: tuple[np.ndarray, ...]

    def flipped(self, fault: int, near: np.ndarray, side: np.ndarray) -> np.ndarray:
        """
        Return which data near a fault are on its other side now.

        Parameters
        ----------
        fault : int
        near, side : ndarray
            As of the class, of data that have moved.

        Examples
        --------
        >>> none = np.zeros(5, dtype=bool)
        >>> use = DataUse(none, none, (np.array([1, 3]),), (np.array([1, -1]),))
        >>> use.flipped(0, np.array([0, 1, 3]), np.array([1, 1, 1])).tolist()
        [3]
        """
        rows, before = self.near[fault], self.side[fault]
        if not len(rows):
            return near[:0]
        at = np.minimum(np.searchsorted(rows, near), len(rows) - 1)
        found: np.ndarray = near[(rows[at] == near) & (before[at] != side)]
        return found


@dataclass(frozen=True, eq=False)
class BaseHeights:
    """
    Heights of a sheet next to its faults, from which traces of slightly other data are drawn.

    Attributes
    ----------
    nodes : ndarray of int64 (n,)
        Nodes that were solved for, increasing.
    off_data : ndarray (n,)
        How far each lies above the mean of its data [m]; NaN without data.
    bridged : ndarray of int64
        Nodes between both walls of a fault.
    walls : tuple of ndarray (4, n)
        By trace: share of its length, distance of the left and the right cut-off [cells], throw
        [m].
    smear : ndarray (n,) or None
        Spread of the errors of ignored data, by distance from a fault [m].
    apart : tuple of int
        Traces whose walls were rebuilt without each other.
    """

    nodes: np.ndarray
    off_data: np.ndarray
    bridged: np.ndarray
    walls: tuple[np.ndarray, ...]
    smear: np.ndarray | None
    apart: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class TearPlan:
    """
    The trims and remedies of a sheet, for another sheet of the same lattice and faults.

    Attributes
    ----------
    shape : tuple of int
        Rows and columns of the lattice.
    trims, given_trims : tuple of float
        By fault, in use and as they were at first [cells].
    use : DataUse
    order : int
        Of the differences that are small in the surface.
    traces : tuple of (int, str, str)
        Fault of each trace, and how it ends.
    early : tuple of (int, int, int)
        A trace, 0 for its first or 1 for its last end, and by how many links its tear ends early.
    rings : tuple of tuples of (int, int)
        For each further ring of ghosts the pairs of nodes at whose edges it is.
    level : tuple of (float, float)
        Places around which the sheet goes on level past its fault [cells].
    left_out : tuple of (int, float, float)
        Parts of traces that tear nothing: trace, first and last place along it [cells].
    loss : float
        Throw that is lost there [m times cells].
    searched : bool
        Whether remedies were searched for; False if a given plan closed the sheet.
    base : BaseHeights or None
        None for scattered points, and where blocks without data were filled.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.torn("normal", n=41)
    >>> plan = gs.tear_horizon(world.horizons["Top"], world.faults).plan
    >>> plan.traces, plan.left_out, plan.searched
    (((0, 'tip', 'tip'),), (), True)
    """

    shape: tuple[int, ...]
    trims: tuple[float, ...]
    given_trims: tuple[float, ...]
    use: DataUse
    order: int
    traces: tuple[tuple[int, str, str], ...]
    early: tuple[tuple[int, int, int], ...] = ()
    rings: tuple[tuple[tuple[int, int], ...], ...] = ()
    level: tuple[tuple[float, float], ...] = ()
    left_out: tuple[tuple[int, float, float], ...] = ()
    loss: float = 0.0
    searched: bool = True
    base: BaseHeights | None = None
