"""Horizon data in any form -> picks on one lattice: which node, what elevation.

Points that sit on a lattice, rotated or not, are recognised; several may share a node. The
lattice is found from the steps between neighbours: their lengths and, since a lattice looks the
same after a quarter turn, the mean of exp(4i angle).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.conventions import elevation_sign, first_given, metres_per_unit, place
from geosurf.errors import HorizonError, InputError
from geosurf.model import TriSurface
from geosurf.sheets.lattice.frame import Frame, fit_steps, frame_of_lattice
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.spikes import check_marks, check_spikes

OFF = 0.05  # cells from its node from which a point is not on the lattice
SCATTERED = 0.2  # share of the points off the lattice from which there is none


@dataclass(frozen=True, eq=False)
class Picks:
    """Horizon data on a lattice.

    Attributes
    ----------
    name : str
    frame : Frame
    given_node : ndarray of int64, shape (n,), or None
        Row times n_col plus column; several picks may share one. None: pick k is that of node k.
    z : ndarray of float64, shape (n,)
        Elevation [m].
    """

    name: str
    frame: Frame
    given_node: np.ndarray | None
    z: np.ndarray

    @cached_property
    def node(self) -> np.ndarray:
        """Node of each pick, int64 (n,); asked for some picks, `nodes_of` costs less."""
        return np.arange(len(self.z)) if self.given_node is None else self.given_node

    def nodes_of(self, rows: np.ndarray) -> np.ndarray:
        """Nodes of some picks."""
        return rows if self.one_each else self.node[rows]

    @property
    def n_node(self) -> int:
        """Number of nodes of the lattice."""
        return self.frame.shape[0] * self.frame.shape[1]

    @cached_property
    def _rising(self) -> bool:
        """Whether picks come node by node, one each."""
        return self.given_node is None or bool((self.node[1:] > self.node[:-1]).all())

    @cached_property
    def one_each(self) -> bool:
        """Whether pick k is that of node k, for all nodes."""
        if self.given_node is None:
            return True
        return self._rising and len(self.node) == self.n_node

    @cached_property
    def _by_node(self) -> tuple[np.ndarray, np.ndarray]:
        """Picks node by node, and their nodes."""
        order = np.argsort(self.node, kind="stable")
        return order, self.node[order]

    @cached_property
    def several(self) -> np.ndarray | None:
        """Whether nodes have more than one pick, bool (n_node,); None if none has."""
        if self._rising or not (many := np.bincount(self.node, minlength=self.n_node) > 1).any():
            return None
        return many

    @cached_property
    def means(self) -> np.ndarray:
        """Mean of the picks of each node (n_node,), NaN without; not to be written to."""
        if self.one_each:
            return self.z
        if self.several is None:
            found = np.full(self.n_node, np.nan)
            found[self.node] = self.z
            return found
        count = np.bincount(self.node, minlength=self.n_node)
        with np.errstate(invalid="ignore"):
            return np.bincount(self.node, self.z, self.n_node) / count

    def of_nodes(self, nodes: np.ndarray) -> np.ndarray:
        """Picks of some nodes, both increasing."""
        if self.one_each:
            return nodes
        if self._rising:
            at = np.searchsorted(self.node, nodes)
            return at[self.node[np.minimum(at, len(self.node) - 1)] == nodes]
        order, node = self._by_node
        start, stop = (np.searchsorted(node, nodes, side=side) for side in ("left", "right"))
        count = stop - start
        rows = np.repeat(start - np.cumsum(count) + count, count) + np.arange(count.sum())
        return np.sort(order[rows])

    def means_at(self, nodes: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Mean of the picks in use, bool (n_pick,), at some increasing nodes; NaN without."""
        rows = self.of_nodes(nodes)
        rows = rows[used[rows]]
        at = np.searchsorted(nodes, self.nodes_of(rows))
        count = np.bincount(at, minlength=len(nodes))
        with np.errstate(invalid="ignore"):
            return np.bincount(at, self.z[rows], len(nodes)) / count

    def columns(self, rows: np.ndarray) -> np.ndarray:
        """Column and row (n, 2) of some picks."""
        return self.frame.uv_of_node(self.nodes_of(rows))

    def corners_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (n, k) that some picks lie between, and their shares (n, k): one node each."""
        return self.nodes_of(rows)[:, None].copy(), np.ones((len(rows), 1))

    @property
    def on_nodes(self) -> bool:
        """Whether each pick is the height of a node."""
        return True

    def missed(self, values: np.ndarray, used: np.ndarray) -> np.ndarray:
        """Picks in use, bool (n_pick,), that heights (n_node,) do not meet bit for bit."""
        values = values if self.one_each else values[self.node]
        return np.flatnonzero((values != self.z) & used)

    def misfit(self, values: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Distance [m] of some picks from heights (n_node,) of a sheet."""
        return np.abs(values[self.nodes_of(rows)] - self.z[rows])

    def places(self, picks: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of some picks."""
        return np.column_stack([self.frame.node_places(self.nodes_of(picks)), self.z[picks]])


def picks_of(
    data: Any, name: str | None, positive: str | None = None, length_unit: str | None = None
) -> Picks:
    """Read horizon data: a DataArray, a gridded TriSurface, a table or array of points.

    Raises
    ------
    HorizonError
        If the data cannot be used; the message says what to do.
    """
    if isinstance(data, TriSurface):
        if data.lattice is None:
            raise HorizonError(
                f"horizon {data.name!r} is a mesh without a lattice, which cannot be torn. "
                "Give the grid or the points that it was made from."
            )
        return _from_lattice(data.renamed(name or data.name))
    if are_points(data):
        return points_on_lattice(*points_of(data, name, positive, length_unit))
    surface = triangulate_horizon(data, name=name, positive=positive, length_unit=length_unit)
    check_spikes(surface)
    return _from_lattice(surface)


def _from_lattice(surface: TriSurface) -> Picks:
    assert surface.lattice is not None
    frame, z = frame_of_lattice(surface.lattice, f"horizon {surface.name!r}")
    there = np.isfinite(z)
    if there.all():
        return Picks(surface.name, frame, None, z.ravel())
    node = np.flatnonzero(there)
    return Picks(surface.name, frame, node, z.ravel()[node])


def are_points(data: Any) -> bool:
    """Whether data are a table or an array of points."""
    table = hasattr(data, "data_vars") or hasattr(data, "columns")
    return table or isinstance(data, np.ndarray | list | tuple)


def points_on_lattice(title: str, points: np.ndarray) -> Picks:
    """Picks of points (n, 3) that sit on a lattice."""
    what = f"horizon {title!r}"
    found = find_lattice(points[:, :2], what)
    if found is None:
        raise HorizonError(
            f"{what}: the points sit on no lattice of right angles. Give a grid, or points on one."
        )
    return Picks(title, *found, points[:, 2])


def points_of(
    data: Any, name: str | None, positive: str | None, length_unit: str | None
) -> tuple[str, np.ndarray]:
    """Name and points (n, 3) of a table or array: easting, northing, elevation [m]."""
    title = str(name or getattr(data, "attrs", {}).get("name") or "horizon")
    what = f"horizon {title!r}"
    if hasattr(data, "data_vars") or hasattr(data, "columns"):
        there = list(data.variables if hasattr(data, "data_vars") else data.columns)
        missing = [k for k in ("easting", "northing", "elevation") if k not in there]
        if missing:
            raise HorizonError(
                f"{what}: points lack {missing}, there are {sorted(map(str, there))}. "
                "Give easting, northing and elevation, one value per point."
            )
        attrs = data["elevation"].attrs
        declared = attrs.get("positive", data.attrs.get("positive"))
        positive = _agreed(declared, positive, what)
        length_unit = first_given(length_unit, attrs.get("units"), "m")
        points = np.stack(
            [np.ravel(data[k].values) for k in ("easting", "northing", "elevation")], axis=1
        )
    else:
        points = np.asarray(data)
        length_unit = first_given(length_unit, "m")
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise HorizonError(
            f"{what}: points have shape {points.shape}, expected numbers (n, 3): easting, "
            "northing, elevation."
        )
    points = points.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise HorizonError(
            f"{what}: {len(bad)} points are not finite, the first is point {bad[0]}. Leave out "
            "points that are undefined."
        )
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


def find_lattice(xy: np.ndarray, what: str) -> tuple[Frame, np.ndarray] | None:
    """The lattice that points sit on, and the node of each; None if they are scattered."""
    if len(xy) < 9:
        raise HorizonError(f"{what}: {len(xy)} points do not make a lattice. Give more points.")
    guess = _first_guess(xy, what)
    if guess is None:
        return None
    corner, step = guess
    origin = xy[np.argmin(np.hypot(*(xy - np.median(xy, axis=0)).T))]
    corner = origin
    span = float(np.hypot(*np.ptp(xy, axis=0)))
    radius = 8.0 * float(np.hypot(*step[0]))
    while True:  # the fit is carried outward, so that small errors of the step never add up
        near = np.hypot(*(xy - origin).T) <= radius
        ij = np.rint(np.linalg.solve(step.T, (xy[near] - corner).T).T)
        corner, step = fit_steps(ij, xy[near])
        if radius >= span:
            break
        radius *= 4.0
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
    return Frame((n_row, n_col), corner, step, full[..., 0], full[..., 1]), node


def _on_lines(full: np.ndarray, node: np.ndarray, xy: np.ndarray) -> None:
    """Put nodes without a pick exactly on their column and row, where all picks of it are.

    A fitted place may be off by a rounding, and then the rim of the data would lie inside a box
    that has the same rim.
    """
    row, col = np.divmod(node, full.shape[1])
    for k, line in ((0, col), (1, row)):
        order = np.argsort(line, kind="stable")
        some, first = np.unique(line[order], return_index=True)
        low, high = (f.reduceat(xy[order, k], first) for f in (np.minimum, np.maximum))
        straight = low == high
        lines = full[..., k].T if k == 0 else full[..., k]
        lines[some[straight]] = low[straight][:, None]


def _first_guess(xy: np.ndarray, what: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Steps (2, 2) from neighbours of points near the middle: right-handed, columns eastward.

    None if neighbours lie in no two ways at right angles.
    """
    from scipy.spatial import cKDTree

    _, first = np.unique(np.rint(xy * 1e3).astype(np.int64), axis=0, return_index=True)
    places = xy[np.sort(first)]
    if len(places) < 9:
        raise HorizonError(f"{what}: {len(places)} places do not make a lattice. Give more points.")
    middle = places[cKDTree(places).query(np.median(places, axis=0), k=min(2000, len(places)))[1]]
    length, near = cKDTree(middle).query(middle, k=5)
    vectors = (middle[near[:, 1:]] - middle[:, None]).reshape(-1, 2)
    short = length[:, 1:].ravel() < 1.3 * np.median(length[:, 1])
    vectors = vectors[short]
    angle = np.arctan2(vectors[:, 1], vectors[:, 0])
    turn = np.angle(np.exp(4j * angle).mean()) / 4.0
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    along = np.abs(vectors @ axes.T)
    steps = []
    for k in range(2):
        mine = along[:, k] > 0.9 * np.hypot(*vectors.T)
        if not mine.any():
            return None
        steps.append(float(np.median(along[mine, k])))
    return np.zeros(2), axes * np.array(steps)[:, None]
