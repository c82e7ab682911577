"""On which side of each horizon the triangles of a fault lie, as the column leaves the horizons.

A triangle lies above a horizon if the cells on both of its sides do. Cells come from topology and
exact signs (see `geosurf.carve.cells`), so this is exact; it is the rule that gives units their
zones, so a fault that ends at a horizon bounds no unit beyond it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.column import apply_column, rim_of_leak
from geosurf.carve.zones import ABOVE, BELOW, UNKNOWN, owned_by, signatures
from geosurf.model import Patches, check_column


@dataclass(frozen=True)
class HorizonSides:
    """Sides of all horizons on which the cells of a model lie.

    Attributes
    ----------
    patches : Patches
    cells : Cells
    horizons : tuple of str
        Youngest first.
    side : ndarray of int64, shape (n_horizon, n_cell + 1)
        ABOVE, BELOW, or UNKNOWN.
    """

    patches: Patches
    cells: Cells
    horizons: tuple[str, ...]
    side: np.ndarray

    def of_fault(self, fault: str, horizon: str) -> FaultSides:
        """Return where the triangles of a fault lie.

        Parameters
        ----------
        fault, horizon : str
        """
        patches, cells = self.patches, self.cells
        rows = np.flatnonzero(patches.surface_of_triangle == patches.names.index(fault))
        face, around = cells.beside(rows)

        side = self.side[self.horizons.index(horizon)][around]
        known = around != OUTSIDE
        above = (known & (side == ABOVE)).any(axis=1)
        below = (known & (side == BELOW)).any(axis=1)
        unknown = (known & (side == UNKNOWN)).any(axis=1)

        of_horizon = np.zeros(len(cells.surface_of), dtype=bool)
        for name in self.horizons:
            of_horizon[owned_by(cells, patches.names.index(name))] = True
        within = of_horizon[face] & (face >= 0) & above & below
        return FaultSides(rows, known.any(axis=1), above, below, unknown, within)

    def open_rim(
        self, horizon: str, near: np.ndarray | None = None
    ) -> tuple[float, np.ndarray] | None:
        """Return length [m] and a place of the rim around which a horizon has no two sides.

        Parameters
        ----------
        horizon : str
        near : ndarray of float64, shape (n, 3), optional
            The place of the rim that is nearest to one of these points (local coordinates).
        """
        unknown = self.side[self.horizons.index(horizon)] == UNKNOWN
        unknown[OUTSIDE] = False
        return rim_of_leak(
            self.patches, self.cells, self.patches.names.index(horizon), unknown, near
        )


@dataclass(frozen=True)
class FaultSides:
    """Where the triangles of a fault lie in relation to one horizon.

    Attributes
    ----------
    rows : ndarray of int64, shape (n,)
        The triangles, rows of `Patches.triangles`.
    inside : ndarray of bool, shape (n,)
        Whether they lie in the model.
    above, below, unknown : ndarray of bool, shape (n,)
        Whether a cell next to each one does, or lies on neither side.
    within : ndarray of bool, shape (n,)
        Whether it coincides with a horizon that has the one cell above it, the other below.
    """

    rows: np.ndarray
    inside: np.ndarray
    above: np.ndarray
    below: np.ndarray
    unknown: np.ndarray
    within: np.ndarray


def horizon_sides(patches: Patches, column: Mapping[str, str] | None = None) -> HorizonSides:
    """
    Find the sides of all horizons on which the cells of a model lie.

    Parameters
    ----------
    patches : Patches
        Of horizons, youngest first, faults, fluid contacts and walls, as for `carve_units`.
    column : mapping of str to str, optional
        As for `carve_units`.

    Raises
    ------
    GeometryError
        As `carve_units`: no walls, or a horizon outside the box.

    Examples
    --------
    >>> from geosurf import TriSurface, build_walls, rebuild_surfaces
    >>> corners = [[-1, -1, 4], [9, -1, 4], [9, 9, 4], [-1, 9, 4]]
    >>> top = TriSurface("Top", "horizon", corners, [[0, 1, 2], [0, 2, 3]])
    >>> fault = TriSurface("F1", "fault", [[4, -1, 0], [4, 9, 0], [4, 4, 9]], [[0, 1, 2]])
    >>> box = (0, 8, 0, 8, 0, 8)
    >>> found = horizon_sides(rebuild_surfaces([top, fault, *build_walls(box)]))
    >>> sides = found.of_fault("F1", "Top")
    >>> bool(sides.above.any()), bool((sides.above & sides.below).any())
    (True, False)
    """
    roles = [source.role for source in patches.sources]
    horizons = [i for i, role in enumerate(roles) if role == "horizon"]
    contacts = [i for i, role in enumerate(roles) if role == "contact"]
    names = tuple(patches.names[i] for i in horizons)
    cells = find_cells(patches)
    signature = signatures(patches, cells, [*horizons, *contacts])
    side, _ = apply_column(signature[: len(horizons)], check_column(names, column))
    return HorizonSides(patches, cells, names, side)


def outside_of_model(
    patches: Patches, found: FaultSides, stays: np.ndarray, horizon: str
) -> np.ndarray:
    """Return which triangles of a fault stay outside of the model: those that go on from inside.

    Parameters
    ----------
    patches : Patches
    found : FaultSides
    stays : ndarray of bool, shape (n,)
        Which triangles inside the model stay.
    horizon : str
        At which the fault ends; nothing goes on across it.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    outer = np.flatnonzero(~found.inside)
    if len(outer) == 0:
        return np.zeros(len(found.rows), dtype=bool)

    # neighbours across an edge that is not on the horizon
    keys = _edge_keys(patches, found.rows)
    ends = np.flatnonzero(patches.surface_of_triangle == patches.names.index(horizon))
    ends = ends[np.isin(patches.triangles[ends], patches.triangles[found.rows]).any(axis=1)]
    on_horizon = np.isin(keys, _edge_keys(patches, ends))
    order = np.argsort(keys.ravel(), kind="stable")
    order = order[~on_horizon.ravel()[order]]
    same = keys.ravel()[order][1:] == keys.ravel()[order][:-1]
    a, b = order[:-1][same] // 3, order[1:][same] // 3

    # pieces outside; each takes what the triangles inside say that it hangs on
    n = len(found.rows)
    both = ~found.inside[a] & ~found.inside[b]
    links = coo_array((np.ones(both.sum()), (a[both], b[both])), shape=(n, n))
    _, piece = connected_components(links, directed=False)
    kept, gone = np.zeros((2, n), dtype=bool)
    for inner, onward in ((a, b), (b, a)):
        across = found.inside[inner] & ~found.inside[onward]
        kept[piece[onward[across & stays[inner]]]] = True
        gone[piece[onward[across & ~stays[inner]]]] = True
    result: np.ndarray = ~found.inside & (kept & ~gone)[piece]
    return result


def _edge_keys(patches: Patches, rows: np.ndarray) -> np.ndarray:
    """A number for each edge of some triangles, int64 (n, 3)."""
    t = patches.triangles[rows]
    ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2)
    keys: np.ndarray = ends.min(axis=2) * len(patches.local) + ends.max(axis=2)
    return keys
