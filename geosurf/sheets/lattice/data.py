"""Horizon data in any form -> picks on one lattice, or scattered points with a lattice over them.

Points that sit on a lattice, rotated or not, are recognised; several may share a node.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from geosurf.conventions import elevation_sign, first_given, is_number, metres_per_unit, place
from geosurf.conventions.axes import COORDINATES, points_in
from geosurf.conventions.checks import are_points
from geosurf.conventions.crs import crs_of
from geosurf.errors import HorizonError, InputError
from geosurf.model import Lattice, TriSurface
from geosurf.model.expected import name_of
from geosurf.sheets.lattice.picks import Frame, Picks, fit_steps, frame_of_lattice
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.horizon import EXTRAPOLATED
from geosurf.triangulate.neighbours import own_form
from geosurf.triangulate.spikes import check_marks, check_spikes

# ---- scattered ----------------------------------------
# Scattered points and a lattice over them: the unknowns sit on the lattice, the data do not.
#
# A point gives the height of the surface between the four nodes of its cell, by bilinear
# interpolation.


FEWEST = 30  # points
LEAN = 1e-3  # width of the points, in their length, below which they are on one line
MOST = 1_000_000  # nodes
NEIGHBOURS = 24  # points to which a piece of parabola is fitted, to estimate their noise


@dataclass(frozen=True, eq=False)
class Scattered(Picks):
    """Points on no lattice.

    Attributes
    ----------
    uv : ndarray (n, 2)
        Column and row of each point; `node` is the nearest one.
    """

    uv: np.ndarray

    several = None  # every point is one of its own
    one_each = False
    on_nodes = False

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of some points."""
        return self.uv[rows]

    def missed(self, values: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Points in use, bool (n_point,): all of them, by a little at least."""
        return np.flatnonzero(used)

    def misfit(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distance [m] of some points from the sheet in their cells; NaN where one is absent."""
        nodes, share = self.corners()
        return np.abs((values[nodes[rows]] * share[rows]).sum(axis=1) - self.z[rows])

    def corners_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The four nodes (n, 4) of the cells of some points, and their shares (n, 4) in it."""
        nodes, share = self.corners()
        return nodes[rows], share[rows]

    def corners(self) -> tuple[np.ndarray, np.ndarray]:
        """The four nodes (n, 4) of each point's cell, and their shares (n, 4) in it."""
        n_row, n_col = self.frame.shape

        # the last row and column belong to the cells before them
        j, i = (
            np.clip(np.floor(c).astype(np.int64), 0, n - 2)
            for c, n in zip(self.uv.T, (n_col, n_row), strict=True)
        )
        x, y = self.uv[:, 0] - j, self.uv[:, 1] - i
        a = i * n_col + j
        nodes = np.stack([a, a + 1, a + n_col, a + n_col + 1], axis=1)
        return nodes, np.stack([(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y], axis=1)


def scattered(name: str, points: np.ndarray, spacing: float) -> Scattered:
    """Points (n, 3) and a lattice over them, along easting and northing, `spacing` metres wide."""
    what = f"horizon {name!r}"
    refuse_too_few(points, what)

    # multiples of the spacing: the same lattice whatever points are added inside
    low = np.floor(points[:, :2].min(axis=0) / spacing) * spacing
    last = np.ceil((points[:, :2].max(axis=0) - low) / spacing).astype(np.int64)
    n_col, n_row = (max(int(n), 3) + 1 for n in last)
    if n_col * n_row > MOST:
        raise HorizonError(
            f"{what}: a lattice of {spacing:g} m would have {n_row} x {n_col} nodes; at most "
            f"{MOST} are solved for. Give a larger spacing, such as {proposed_spacing(points):.3g}."
        )
    easting, northing = (low[k] + spacing * np.arange(n) for k, n in ((0, n_col), (1, n_row)))

    # uv (n, 2): column and row of each point, between nodes
    frame = Frame((n_row, n_col), low, spacing * np.eye(2), easting, northing)
    uv = (points[:, :2] - low) / spacing

    # the nearest node stands for a point where only its neighbourhood matters
    near = np.rint(uv).astype(np.int64)
    j, i = np.clip(near, 0, [n_col - 1, n_row - 1]).T
    return Scattered(name, frame, i * n_col + j, points[:, 2], uv)


def refuse_too_few(points: np.ndarray, what: str) -> None:
    """Raise an error if points are too few for a surface, or all on one line."""
    if len(points) < FEWEST:
        raise HorizonError(
            f"{what}: {len(points)} scattered points are too few for a surface, {FEWEST} is the "
            "least. Give more points."
        )

    # singular values: length and width of the cloud in the map
    middle = points[:, :2].mean(axis=0)
    length = np.linalg.svd(points[:, :2] - middle, compute_uv=False)
    if length[1] < LEAN * length[0]:
        ends = points[[points[:, k].argmin() for k in (0, 1)]]
        raise HorizonError(
            f"{what}: all {len(points)} points are on one line, through {place(ends[0])}. Give "
            "points on both sides of it."
        )


def proposed_spacing(points: np.ndarray) -> float:
    """Spacing [m] of a lattice with one cell for each point, where there are points."""
    # the sixth neighbour: median over all points, so that clusters and gaps do not count
    xy = np.unique(points[:, :2], axis=0)
    far = cKDTree(xy).query(xy, k=min(7, len(xy)))[0][:, -1]
    # a circle with six others in it besides its middle has the area of six cells
    return float(np.median(far) * np.sqrt(np.pi / 6.0))


def noise_of_points(picks: Scattered, used: np.ndarray) -> float:
    """Standard deviation of noise [m]: what parabolas through neighbours leave over."""
    rows = np.flatnonzero(used)
    if len(rows) < NEIGHBOURS:
        return 0.0

    # parabolas through 24 neighbours of 2000 points at most; heights relative to the point
    sample = rows[:: max(len(rows) // 2000, 1)]
    near = rows[cKDTree(picks.uv[rows]).query(picks.uv[sample], k=NEIGHBOURS)[1]]
    x, y = np.moveaxis(picks.uv[near] - picks.uv[sample][:, None], -1, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    z = picks.z[near] - picks.z[sample][:, None]

    # what the parabola leaves over, with 24 - 6 degrees of freedom
    basis = np.linalg.qr(terms)[0]
    left = z - (basis @ (np.swapaxes(basis, 1, 2) @ z[..., None]))[..., 0]
    return float(np.sqrt(np.median((left**2).sum(axis=1)) / (NEIGHBOURS - 6)))


# ---- read ----------------------------------------
# Data are asked once, here; all that follows takes what they were found to be.


@dataclass(frozen=True, eq=False)
class Given:
    """Horizon data as they were given.

    Attributes
    ----------
    picks : Picks
    crs : str or None
        Their coordinate reference system.
    are_points : bool
        Whether they are points: a grid has been made of picks already.
    extrapolated : ndarray of bool, shape (n_row, n_col), or None
        Nodes of a grid that `extend_horizon` has continued.
    fewer_nodes : bool
        Whether a tolerance has left out nodes.
    """

    picks: Picks
    crs: str | None
    are_points: bool = False
    extrapolated: np.ndarray | None = None
    fewer_nodes: bool = False


def read_data(
    data: Any,
    name: str | None,
    positive: str | None = None,
    length_unit: str | None = None,
    spacing: float | None = None,
    *,
    on_lattice: bool = False,
) -> Given:
    """Read horizon data: picks on a lattice, or scattered points.

    Scattered are points that sit on no lattice, which `on_lattice` refuses, or all points if a
    spacing is given.

    Raises
    ------
    HorizonError
        If the data cannot be used; the message states what to do.
    """
    if spacing is not None and not (is_number(spacing) and spacing > 0):
        raise InputError(f"spacing is {spacing!r}, expected metres above 0.")
    data = own_form(data, name or "horizon", "horizon", positive)
    if not are_points(data):
        if spacing is not None:
            raise InputError(
                f"spacing is {spacing:g} m, but the data are a grid, which has its own. "
                "Leave it out."
            )
        return _read_grid(data, name, positive, length_unit)

    # without a spacing, points that sit on a lattice keep it
    title, points = points_of(data, name, positive, length_unit)
    what = f"horizon {title!r}"
    found = find_lattice(points[:, :2], what) if spacing is None else None
    if found is not None:
        picks = Picks(title, *found, points[:, 2])
    elif on_lattice:
        raise HorizonError(
            f"{what}: the points sit on no lattice of right angles. Give a grid, or points on one."
        )
    else:
        refuse_too_few(points, what)
        picks = scattered(title, points, spacing or proposed_spacing(points))
    return Given(picks, crs_of(data), are_points=True)


def _read_grid(data: Any, name: str | None, positive: str | None, length_unit: str | None) -> Given:
    """Read a grid, or a surface that was made of one."""
    if isinstance(data, TriSurface):
        if data.lattice is None:
            raise HorizonError(
                f"horizon {data.name!r} is a mesh without a lattice, which cannot be torn. "
                "Give the grid or the points that it was made from."
            )
        picks = _picks_of_lattice(data.lattice, name_of(name, "horizon") if name else data.name)
        return Given(picks, data.crs, fewer_nodes="volume_error" in data.vertex_data)
    surface = triangulate_horizon(data, name=name, positive=positive, length_unit=length_unit)
    check_spikes(surface)
    lattice = surface.lattice
    assert lattice is not None
    extrapolated = None
    if EXTRAPOLATED in surface.vertex_data and lattice.right_handed:
        extrapolated = np.zeros(lattice.shape, dtype=bool)
        extrapolated[lattice.present] = surface.vertex_data[EXTRAPOLATED]
    picks = _picks_of_lattice(lattice, surface.name)
    return Given(picks, surface.crs, extrapolated=extrapolated)


def _picks_of_lattice(lattice: Lattice, name: str) -> Picks:
    """The nodes of a lattice that have values."""
    frame, z = frame_of_lattice(lattice, f"horizon {name!r}")
    present = np.isfinite(z)
    # no index array for a grid without holes: pick k is that of node k
    if present.all():
        return Picks(name, frame, None, z.ravel())
    node = np.flatnonzero(present)
    return Picks(name, frame, node, z.ravel()[node])


def points_of(
    data: Any, name: str | None, positive: str | None, length_unit: str | None
) -> tuple[str, np.ndarray]:
    """Name and points (n, 3) of a table or array: easting, northing, elevation [m]."""
    own = getattr(data, "attrs", {}).get("name") or "horizon"
    title = str(own) if name is None else name_of(name, "horizon")
    what = f"horizon {title!r}"

    # tables name their columns, and may say units and direction; arrays are in this order
    if hasattr(data, "data_vars") or hasattr(data, "columns"):
        there = list(data.variables if hasattr(data, "data_vars") else data.columns)
        missing = [k for k in COORDINATES if k not in there]
        if missing:
            raise HorizonError(
                f"{what}: points lack {missing}, there are {sorted(map(str, there))}. "
                "Give easting, northing and elevation, one value per point."
            )
        attrs = data["elevation"].attrs
        declared = attrs.get("positive", data.attrs.get("positive"))
        positive = _agreed(declared, positive, what)
        length_unit = first_given(length_unit, attrs.get("units"), "m")
        points = points_in(data)
    else:
        try:
            points = np.asarray(data)
        except ValueError as error:  # rows of several lengths, such as vertices and triangles
            raise HorizonError(
                f"{what}: found a {type(data).__name__} with arrays of several shapes, expected "
                "points (n, 3). Give those, or a grid."
            ) from error
        length_unit = first_given(length_unit, "m")
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: points have shape {points.shape}, expected numbers (n, 3): easting, "
            "northing, elevation."
        )

    # a point without a number would be a hole that nobody drew: an error, not a gap
    points = points.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise HorizonError(
            f"{what}: {len(bad)} points are not finite, the first is point {bad[0]}. Leave out "
            "points that are undefined."
        )

    # elevations in metres, positive up, from here on
    try:
        scale = elevation_sign(positive, what) * metres_per_unit(length_unit, what)
    except InputError as error:
        raise HorizonError(str(error)) from error
    points[:, 2] *= scale
    check_marks(title, points)
    return title, points


def _agreed(attribute: str | None, argument: str | None, what: str) -> str | None:
    """Whether a table of points has elevations or depths, by its attribute or by the argument."""
    if attribute is not None and argument is not None and attribute != argument:
        raise HorizonError(
            f"{what}: attrs['positive'] of its elevations is {attribute!r}, the argument positive "
            f"is {argument!r}. Leave the argument out, or correct the attribute."
        )
    return argument if attribute is None else attribute


OFF = 0.05  # cells from its node from which a point is not on the lattice
SCATTERED = 0.2  # share of the points off the lattice from which they are scattered
KEPT, MOST_KEPT = 12, 100_000  # lattices that are remembered, of so many points at most
Found = tuple[Frame, np.ndarray] | None


def find_lattice(xy: np.ndarray, what: str) -> Found:
    """The lattice that points sit on, and the node of each; None if they are scattered.

    It is remembered: a scene asks for the footprint of a horizon and then for its sheet, and each
    realisation of an ensemble has the same places.
    """
    if len(xy) < 9:
        raise HorizonError(f"{what}: {len(xy)} points do not make a lattice. Give more points.")
    return _found_before(xy.tobytes(), what) if len(xy) <= MOST_KEPT else _find_lattice(xy, what)


@lru_cache(maxsize=KEPT)
def _found_before(xy: bytes, what: str) -> Found:
    """The same for places as bytes."""
    return _find_lattice(np.frombuffer(xy).reshape(-1, 2), what)


def _find_lattice(xy: np.ndarray, what: str) -> Found:
    """The same, found anew."""
    guess = _first_guess(xy, what)
    if guess is None:
        return None
    corner, step = guess

    # from a point in the middle, where the first guess of the steps is exact enough to count
    origin = xy[np.argmin(np.hypot(*(xy - np.median(xy, axis=0)).T))]
    corner = origin
    span = float(np.hypot(*np.ptp(xy, axis=0)))
    radius = 8.0 * float(np.hypot(*step.T).max())
    while True:  # the fit is carried outward, so that small errors of the step never add up
        near = np.hypot(*(xy - origin).T) <= radius
        ij = np.rint(np.linalg.solve(step.T, (xy[near] - corner).T).T)
        corner, step = fit_steps(ij, xy[near])
        if radius >= span:
            break
        radius *= 4.0

    # distance from the nearest node [cells]: a few points off are a mistake, many no lattice
    uv = np.linalg.solve(step.T, (xy - corner).T).T
    ij = np.rint(uv).astype(np.int64)
    off = np.abs(uv - ij).max(axis=1)
    worst = int(off.argmax())
    if (off > OFF).mean() > SCATTERED:
        return None
    if off[worst] > OFF:
        where = place(xy[worst])
        raise HorizonError(
            f"{what}: {int((off > OFF).sum())} of {len(xy)} points lie off the lattice that the "
            f"others sit on, the farthest at {where}, {off[worst]:.2f} cells off. Leave "
            "them out, or give spacing= to take all points as scattered."
        )

    # number nodes from the lower left; few points far apart are no grid
    low = ij.min(axis=0)
    n_col, n_row = (int(n) for n in ij.max(axis=0) - low + 1)
    if n_col * n_row > 64 * len(xy) + 4096:
        raise HorizonError(
            f"{what}: {len(xy)} points on a lattice of {n_row} x {n_col} nodes are too few to "
            "carry a surface. Give spacing= to take them as scattered points."
        )
    corner = corner + low @ step
    grid = np.stack(np.meshgrid(np.arange(n_col), np.arange(n_row)), axis=-1).reshape(-1, 2)
    full = corner + grid @ step
    node = (ij[:, 1] - low[1]) * n_col + ij[:, 0] - low[0]
    full[node] = xy  # nodes with picks keep the coordinates that they came with
    full = full.reshape(n_row, n_col, 2)
    _on_lines(full, node, xy)
    full.flags.writeable = node.flags.writeable = False
    return Frame((n_row, n_col), corner, step, full[..., 0], full[..., 1]), node


def _on_lines(full: np.ndarray, node: np.ndarray, xy: np.ndarray) -> None:
    """Put nodes without a pick exactly on their column and row, where all picks of it are.

    A fitted place may be off by a rounding, and then the rim of the data would lie inside a box
    that has the same rim.
    """
    # where all points of a line share a coordinate, its empty nodes take that one, too
    row, col = np.divmod(node, full.shape[1])
    for k, line in ((0, col), (1, row)):
        order = np.argsort(line, kind="stable")
        numbers, first = np.unique(line[order], return_index=True)
        low, high = (f.reduceat(xy[order, k], first) for f in (np.minimum, np.maximum))
        straight = low == high
        lines = full[..., k].T if k == 0 else full[..., k]
        lines[numbers[straight]] = low[straight][:, None]


def _first_guess(xy: np.ndarray, what: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Steps (2, 2) from neighbours of points near the middle: right-handed, columns eastward.

    None if no line across the shortest step has two points.
    """
    # points at one place to a millimetre are picks of one node
    east, north = np.rint(xy * 1e3).astype(np.int64).T
    order = np.lexsort((north, east))  # stable: the first of equal ones stays in front
    east, north = east[order], north[order]
    is_first = np.append(True, (east[1:] != east[:-1]) | (north[1:] != north[:-1]))
    places = xy[np.sort(order[is_first])]
    if len(places) < 9:
        raise HorizonError(f"{what}: {len(places)} places do not make a lattice. Give more points.")

    # the shortest vectors between neighbours lie along an axis, or along both
    middle = places[cKDTree(places).query(np.median(places, axis=0), k=min(2000, len(places)))[1]]
    length, near = cKDTree(middle).query(middle, k=5)
    vectors = middle[near[:, 1:]] - middle[:, None]
    vectors = vectors[_near_shortest(length[:, 1:])]

    # axes repeat every 90 degrees: four times the angle points the same way for all
    angle = np.arctan2(vectors[:, 1], vectors[:, 0])
    turn = np.angle(np.exp(4j * angle).mean()) / 4.0
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    along = np.abs(vectors @ axes.T)
    first = int(along[:, 1].sum() > along[:, 0].sum())
    steps = np.ones(2)
    steps[first] = np.median(along[along[:, first] > along[:, 1 - first], first])

    # the other step, however long: from point to point on the lines across
    line, at = ((middle - middle[0]) @ axes[[first, 1 - first]].T).T
    line = np.rint(line / steps[first])
    order = np.lexsort((at, line))
    across = np.diff(at[order])[np.diff(line[order]) == 0.0]
    if not len(across):
        return None
    steps[1 - first] = np.median(across[_near_shortest(across)])
    return np.zeros(2), axes * steps[:, None]


def _near_shortest(lengths: np.ndarray) -> np.ndarray:
    """Which lengths are about that of a tenth of the shortest ones; fewer are mistakes."""
    return np.abs(lengths / np.quantile(lengths, 0.1) - 1.0) < 0.3
