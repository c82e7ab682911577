"""Apply the rules of the stratigraphic column: sides of horizons -> zones, cell by cell.

Layers are laid down oldest first. Each horizon, when its turn comes, first stops at the
base below it (onlap), unless it erodes; then all older horizons end on it. So for each
pair that crosses one rule counts: the younger one wins where it is ``erosional`` or
``discontinuous``; else the older one where it is a ``base`` or ``discontinuous``, or where
only the younger one is ``yielding``; else the younger (what is between them has no thickness
there). After
each turn the horizons are in order, so the zone of a cell is the first horizon that it is above.

What is unknown may stay so where no rule asks: in three-valued logic (Kleene 1952), "and" is
the lower of two sides, "or" the higher.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.carve.cells import OUTSIDE, Cells, find_cells
from geosurf.carve.zones import ABOVE, BELOW, UNKNOWN, own_sides, owned_by, signatures
from geosurf.conventions import check_word, length_text, place
from geosurf.errors import InputError, OpenUnitError
from geosurf.kernels.lattices.sets import pairs_of_equal
from geosurf.kernels.meshes.mesh import edge_keys, join_pairs
from geosurf.model import Patches, TriSurface, check_column
from geosurf.model.column import BASE as LAPPED
from geosurf.model.column import CONFORMABLE, ERODES, EROSIONAL, IS_LAPPED, YIELDING
from geosurf.model.expected import listed

# ---- horizon sides ----------------------------------------
# On which side of each horizon the triangles of a fault lie, as the column leaves the horizons.
#
# A triangle lies above a horizon if the cells on both of its sides do. Cells come from topology and
# exact signs (see `geosurf.carve.cells`), so this is exact; it is the rule that gives units their
# zones, so a fault that ends at a horizon bounds no unit beyond it.


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

        on_horizon = np.zeros(len(cells.surface_of), dtype=bool)
        for name in self.horizons:
            on_horizon[owned_by(cells, patches.names.index(name))] = True
        within = on_horizon[face] & (face >= 0) & above & below
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
    patches: Patches, fault: FaultSides, stays: np.ndarray, horizon: str
) -> np.ndarray:
    """Return which triangles of a fault stay outside of the model: those that go on from inside.

    Parameters
    ----------
    patches : Patches
    fault : FaultSides
    stays : ndarray of bool, shape (n,)
        Which triangles inside the model stay.
    horizon : str
        At which the fault ends; nothing goes on across it.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    outer = np.flatnonzero(~fault.inside)
    if len(outer) == 0:
        return np.zeros(len(fault.rows), dtype=bool)

    # neighbours across an edge that is not on the horizon
    keys = edge_keys(patches.triangles[fault.rows], len(patches.local)).reshape(-1, 3)
    ends = np.flatnonzero(patches.surface_of_triangle == patches.names.index(horizon))
    ends = ends[np.isin(patches.triangles[ends], patches.triangles[fault.rows]).any(axis=1)]
    on_horizon = np.isin(keys, edge_keys(patches.triangles[ends], len(patches.local)))
    one, two = pairs_of_equal(keys.ravel(), np.flatnonzero(~on_horizon))
    a, b = one // 3, two // 3

    # pieces outside; each takes what the triangles inside say that it hangs on
    n = len(fault.rows)
    both = ~fault.inside[a] & ~fault.inside[b]
    piece = join_pairs(np.stack([a[both], b[both]], axis=1), n)
    kept, gone = np.zeros((2, n), dtype=bool)
    for inner, onward in ((a, b), (b, a)):
        across = fault.inside[inner] & ~fault.inside[onward]
        kept[piece[onward[across & stays[inner]]]] = True
        gone[piece[onward[across & ~stays[inner]]]] = True
    return ~fault.inside & (kept & ~gone)[piece]


# ---- leaks ----------------------------------------
# Where a horizon or contact leaks: its rim is open inside cells whose sides matter.


def raise_leak(patches: Patches, cells: Cells, surface: int, torn: np.ndarray) -> None:
    """State where the rim of a horizon or contact is open, inside cells where that matters."""
    source = patches.sources[surface]
    what, name = source.role, source.name
    if not torn[own_sides(cells, surface)[2]].any():
        cells = cells.in_full
        rows = torn[cells.cell_of_side].any(axis=1)
        where = patches.local[cells.triangles[rows]].mean(axis=(0, 1)) + patches.origin
        remedy = (
            f"Extend the {what} into the block, or keep the box on one side of it. Where two "
            f"faults cross closer to the {what} than their throws together, the block between "
            "them has no room for it: move a fault until they cross farther away."
        )
        if source.sectors:
            remedy = (
                f"Faults cross next to the {what} there, and the piece between them is narrower "
                f"than its cells. Give the {what} on finer cells to throw_horizon, as from its "
                ".interp(easting=..., northing=...)."
            )
        raise OpenUnitError(
            f"cannot determine whether {place(where)} lies above or below {what} {name!r}: "
            f"the {what} is not in that block, and the blocks around it lie on both sides. "
            f"{remedy}",
            place=where,
            surfaces=(name,),
        )
    rim = rim_of_leak(patches, cells, surface, torn)
    if rim is None:
        raise OpenUnitError(
            f"{what} {name!r} does not separate the space above from the space below: it "
            "folds back, or a surface crosses itself and was not split there. Check the "
            "orientation of its triangles, or rebuild with self_intersections=True.",
            surfaces=(name,),
        )
    whole, middle = rim
    ahead = first_beyond(patches, middle, surface)
    other, gap = None, ""
    if ahead is not None:
        other = patches.sources[ahead[0]]
        gap = f" It ends {length_text(ahead[1])} before {_in_words(other)} there."
    raise OpenUnitError(
        f"units leak around {what} {name!r}: {length_text(whole)} of its rim are open "
        f"inside the model box, for example at {place(middle)}.{gap} {_remedy(source, other)}",
        place=middle,
        surfaces=(name,),
    )


def _in_words(other: TriSurface) -> str:
    """A surface that a rim does not reach."""
    if other.role != "wall":
        return f"{other.role} {other.name!r}"
    of_area = other.name == "aoi"
    return f"the {'side of the area of interest' if of_area else f'{other.name} side of the model'}"


def _remedy(source: TriSurface, other: TriSurface | None) -> str:
    """What closes the rim of a horizon or contact: it depends on the surface that comes next."""
    area = "area of interest" if other is not None and other.name == "aoi" else "box"
    if source.role != "horizon":
        return f"Shrink the {area} to the {source.role}, or extend or fill the {source.role}."
    call = "extend_horizon(horizon, distance=..., fill_holes=True), extend_m and fill_holes in a "
    fill = f"extend or fill it: {call}scenario."
    if other is not None and other.role == "fault":
        if source.torn is None:
            return f"Tear it there (tear=True), or {fill}"
        return (
            f"It is cut at faults already: extend or fill its data ({call}scenario), then tear or "
            "throw these at all faults of the scene."
        )
    return f"Shrink the {area} to the horizon, or {fill} Or give the fault that cuts it there."


def rim_of_leak(
    patches: Patches, cells: Cells, surface: int, torn: np.ndarray, near: np.ndarray | None = None
) -> tuple[float, np.ndarray] | None:
    """Return length [m] and a place of the open rim of a surface in some cells; None without one.

    The place is the middle of the longest edge, or that which is nearest to one of the points
    `near` (n, 3), in local coordinates.
    """
    cells = cells.in_full
    faces = owned_by(cells, surface)
    faces = faces[torn[cells.cell_of_side[faces]].any(axis=1)]
    t = cells.triangles

    # open rim: edges of the surface that no other triangle has
    keys = edge_keys(t, len(patches.local)).reshape(-1, 3)
    every, times = np.unique(keys, return_counts=True)
    rim = np.intersect1d(np.unique(keys[faces]), every[times == 1])
    if len(rim) == 0:
        return None
    a, b = (patches.local[end] for end in np.divmod(rim, len(patches.local)))
    length = np.linalg.norm(b - a, axis=1)
    middles = 0.5 * (a + b)
    if near is None:
        middles = middles[length == length.max()]
    else:
        from scipy.spatial import KDTree

        away = KDTree(near).query(middles)[0]
        middles = middles[away == away.min()]
    middle = middles[np.lexsort(middles.T[::-1])[0]] + patches.origin  # whatever the order of edges
    return math.fsum(length), middle


# ---- what a surface does not reach: the first surface that its open rim would meet if it went on -


BLOCK = 1 << 17  # triangles that are looked at together


def first_beyond(patches: Patches, middle: np.ndarray, surface: int) -> tuple[int, float] | None:
    """
    Return the surface that a rim would meet straight on, and how far away [m]; None without one.

    Parameters
    ----------
    patches : Patches
    middle : ndarray of float64, shape (3,)
        Middle of an edge of the rim, in world coordinates.
    surface : int
        Row of `patches.sources` that the rim belongs to.
    """
    at = middle - patches.origin
    own = patches.surface_of_triangle == surface
    direction = _outward(patches.local[patches.triangles[own]], at)
    others = np.flatnonzero(~own)
    best: tuple[int, float] | None = None
    for start in range(0, len(others), BLOCK):
        rows = others[start : start + BLOCK]
        away = _along(patches.local[patches.triangles[rows]], at, direction)
        k = int(np.argmin(away))
        if np.isfinite(away[k]) and (best is None or away[k] < best[1]):
            best = int(patches.surface_of_triangle[rows[k]]), float(away[k])
    return best


def _outward(corners: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Unit vector out of a surface, in its plane, at the middle of an edge."""
    ends = np.roll(corners, -1, axis=1)
    away = ((0.5 * (corners + ends) - at) ** 2).sum(axis=2)
    row, k = np.unravel_index(int(np.argmin(away)), away.shape)
    along = ends[row, k] - corners[row, k]
    out = at - corners[row, (k + 2) % 3]
    out = out - (out @ along) / (along @ along) * along
    return out / np.linalg.norm(out)


def _along(corners: np.ndarray, at: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Distances along a ray to triangles (n, 3, 3), infinite where it misses; to rounding.

    T. Moeller, B. Trumbore (1997), Fast, Minimum Storage Ray/Triangle Intersection.
    """
    side, other_side = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, other_side)
    size = np.einsum("nc,nc->n", side, p)
    parallel = size == 0.0
    size = np.where(parallel, 1.0, size)
    from_corner = at - corners[:, 0]
    u = np.einsum("nc,nc->n", from_corner, p) / size
    q = np.cross(from_corner, side)
    v = (q @ direction) / size
    t = np.einsum("nc,nc->n", other_side, q) / size
    # a ray through an edge may miss both of its triangles by rounding
    slack = 1e-9
    hits = ~parallel & (u >= -slack) & (v >= -slack) & (u + v <= 1.0 + slack) & (t >= 0.0)
    return np.where(hits, t, np.inf)


@dataclass(frozen=True)
class Turn:
    """One horizon that yielded to another, in some cells.

    Attributes
    ----------
    loser, winner : int
        Numbers of the horizons, 0 for the youngest.
    rule : str
    before, after : ndarray of int64, shape (n_cell + 1,)
        Side of the loser, as clipped so far, that each cell is on.
    """

    loser: int
    winner: int
    rule: str
    before: np.ndarray
    after: np.ndarray


def apply_column(signature: np.ndarray, rules: Sequence[str]) -> tuple[np.ndarray, list[Turn]]:
    """
    Side of each horizon, as the column leaves it, that each cell is on.

    Parameters
    ----------
    signature : ndarray of int64, shape (n_horizon, n_cell + 1)
        Side of each horizon as given, youngest first.
    rules : sequence of str
        One for each horizon.

    Returns
    -------
    ndarray of int64, shape (n_horizon, n_cell + 1)
        What is above a horizon is above all older ones.
    list of Turn
        All that changed a cell, in the order of time.

    Examples
    --------
    A cell below Top and above Base is where they cross the wrong way; erosion takes it away:

    >>> import numpy as np
    >>> sides, turns = apply_column(np.array([[1, 1], [-1, 1]]), ["erosional", "conformable"])
    >>> sides.tolist(), [(turn.loser, turn.winner, turn.rule) for turn in turns]
    ([[1, 1], [1, 1]], [(1, 0, 'erosional')])
    """
    side = signature.copy()
    turns: list[Turn] = []

    def clip(loser: int, winner: int, rule: str, after: np.ndarray) -> None:
        """One surface yields to another; note it where that changes anything."""
        if not np.array_equal(after, side[loser]):
            turns.append(Turn(loser, winner, rule, side[loser].copy(), after))
            side[loser] = after

    # from the oldest to the youngest, as layers were laid down
    for k in reversed(range(len(rules))):
        older = range(k + 1, len(rules))

        # an eroding horizon cuts through the base below it instead of ending on it
        if rules[k] not in ERODES:
            # horizons are in order by now, so that the youngest base is the highest
            # what yields ends on the next one that does not
            yields = rules[k] == YIELDING
            base = next(
                (j for j in older if rules[j] in IS_LAPPED or (yields and rules[j] != YIELDING)),
                None,
            )
            if base is not None:
                # "above both": a cell counts as above k only if it is above the base, so k ends on
                # it
                clip(k, base, LAPPED, np.minimum(side[k], side[base]))

        # older horizons end at k: what is above k is above them
        rule = EROSIONAL if rules[k] in ERODES else CONFORMABLE
        for j in older:
            clip(j, k, rule, np.maximum(side[j], side[k]))
    return side, turns


def zones_of(patches: Patches, cells: Cells, side: np.ndarray, horizons: list[int]) -> np.ndarray:
    """
    Zone of each cell, int64 (n_cell + 1,): the first horizon that it is above; -1 outside.

    Raises
    ------
    OpenUnitError
        If a horizon does not separate what is above it from what is below, where it counts.
    """
    # a cell whose side nobody knows was reached around the rim of the horizon: a leak
    for k, horizon in enumerate(horizons):
        unknown = side[k] == UNKNOWN
        unknown[0] = False
        if unknown.any():
            raise_leak(patches, cells, horizon, unknown)

    # argmax finds the first horizon that a cell is above; the last row catches what is below all of
    # them
    lowest = np.ones((1, side.shape[1]), dtype=bool)  # below all horizons, if there are any
    zone = np.concatenate([side == ABOVE, lowest]).argmax(axis=0)
    zone[0] = -1
    return zone


def reservoir_of(zones: Sequence[str], reservoir: Any = None) -> tuple[str, ...]:
    """
    Return the zones of the reservoir, youngest first: those between two horizons, or as given.

    Parameters
    ----------
    zones : sequence of str
        See `names_of_zones`.
    reservoir : sequence of str, optional
        Default: the zones between the first and the last horizon; all where nothing is between.

    Raises
    ------
    InputError
        For an unknown zone, or no zone at all.

    Examples
    --------
    >>> from geosurf.model.column import names_of_zones
    >>> zones = names_of_zones(["Top", "Middle", "Base"])
    >>> reservoir_of(zones), reservoir_of(zones, ["Middle/Base"])
    (('Top/Middle', 'Middle/Base'), ('Middle/Base',))
    >>> reservoir_of(names_of_zones(["Top"]))
    ('above Top', 'below Top')
    """
    if reservoir is None:
        return tuple(zones[1:-1] or zones)
    how = f"give a list of zones, as in reservoir={list(zones[1:-1] or zones)[:1]}"
    given = () if isinstance(reservoir, str) else listed(reservoir, "reservoir takes zones", how)
    for zone in given:
        check_word(zone, zones, f"reservoir: unknown zone {zone!r}. Zones are {list(zones)}.")
    if not given:
        raise InputError(f"reservoir is {reservoir!r}; {how}, or leave it out.")
    return tuple(zone for zone in zones if zone in given)
