"""Compute thickness maps by block: vertical (isochore) and normal to bedding (isopach)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import xarray

from geosurf.conventions import (
    HORIZON_DIMS,
    check_name,
    check_word,
    counted,
    is_number,
    length_text,
    metres_of,
)
from geosurf.errors import GeosurfWarning, InputError, InvariantError
from geosurf.kernels.lattices.sets import distinct, rim_edges
from geosurf.kernels.search.columns import cross_columns, elevations
from geosurf.measure.faces import faces_of
from geosurf.measure.locate import keys_at, runs_of_keys
from geosurf.model import Patches, Unit, Units
from geosurf.model.expected import expect
from geosurf.model.pieces import Pieces, corners_of

KINDS = ("isochore", "isopach")
CELLS = 100  # of the default map, along its longer side
MOST_CELLS = 1e8
_WORDS = {
    "isochore": (
        "vertical thickness",
        (
            "length of rock on the vertical line through each node, summed over all intervals; "
            "exact for the triangulated model"
        ),
    ),
    "isopach": (
        "thickness normal to bedding, by the local dip",
        (
            "vertical thickness times the cosine of the dip of the highest horizon that the "
            "vertical line enters the unit through; where it enters through none (a fault, the "
            "top of the model), of the lowest that it leaves through; NaN where there is neither. "
            "Exact where top and base are parallel planes"
        ),
    ),
}


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes of a requested map.

    Attributes
    ----------
    coords : dict
        Of the map, as xarray takes them.
    dims : tuple of str
    shape : tuple of int
    feet : ndarray of float64, shape (n, 2)
        Easting and northing of all nodes, row by row [m].
    cell_area : float or None
        [m2], where nodes are the middles of equal cells that fill the box.
    """

    coords: dict[str, Any]
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    feet: np.ndarray
    cell_area: float | None


def thickness_map(
    units: Units,
    zone: str,
    grid: Any = None,
    *,
    kind: str = "isochore",
    contact: str | None = None,
    horizons: Sequence[str] = (),
) -> xarray.DataArray:
    """
    Map the thickness of a zone, block by block.

    Parameters
    ----------
    units : Units
    zone : str
        ``"Top/Base"``, ``"above Top"`` ...
    grid : None, float or xarray object
        Where: None for the middles of equal cells, 100 along the longer side of the box;
        a number for the middles of cells about as wide [m]; or anything with coordinates
        ``northing`` and ``easting`` [m], such as a horizon.
    kind : {"isochore", "isopach"}
        Vertical, or normal to bedding (an approximation, see ``attrs["definition"]``).
    contact : str, optional
        One interval between fluid contacts, ``"above OWC"``; default: all together.
    horizons : sequence of str
        Names of the surfaces that are bedding, for isopachs.

    Returns
    -------
    xarray.DataArray
        (block, northing, easting) [m]. NaN where a block has none of the zone above or below the
        node. A node on the rim of a triangle takes the value next to it towards the middle of the
        box. On the middles of cells, the sum times ``attrs["cell_area"]`` converges to the volume.
        The coordinate ``sliver`` marks blocks that are slivers in this zone.

    Raises
    ------
    InputError
        For an unknown zone, kind or contact, or a grid that has no coordinates.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = thickness_map(scene.units, "Top/Base", 200.0)
    >>> found.dims, found.shape, found.attrs["units"]
    (('block', 'northing', 'easting'), (2, 15, 20), 'm')
    """
    expect(units, Units, "thickness_map takes Units", "pass the result of carve_units")
    check_word(kind, KINDS, f"kind is {kind!r}, expected one of {KINDS}.")
    chosen = units_of_zone(units, zone, contact)
    nodes = nodes_of(grid, units.box)

    # one layer of the map for each block, in the order of the units
    blocks = list(dict.fromkeys(unit.block for unit in chosen))
    values = np.full((len(blocks), len(nodes.feet)), np.nan)

    # several units of one block (pieces, contact intervals) are added up on one layer
    row_of = {name: row for row, name in enumerate(units)}
    west, east, south, north = units.box[:4]
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    rows = [row_of[unit.name] for unit in chosen]
    cosine = np.ones((len(blocks), len(nodes.feet))) if kind == "isopach" else None
    lines: list[_Lines] = [_Lines() for _ in chosen]
    for part, passages_of in passages(units, rows, nodes.feet, middle):
        feet = nodes.feet[part]
        for k, (unit, of_unit) in enumerate(zip(chosen, passages_of, strict=True)):
            _check_balance(unit, of_unit, feet)
            lines[k].add(part, of_unit)
        if cosine is None:
            continue
        for i, block in enumerate(blocks):
            mine = [(u, p) for u, p in zip(chosen, passages_of, strict=True) if u.block == block]
            cosine[i, part] = _cosine(mine, len(feet), horizons)
    for i, block in enumerate(blocks):
        of_block = [k for k, unit in enumerate(chosen) if unit.block == block]
        values[i] = _block([lines[k] for k in of_block], len(nodes.feet))
    if cosine is not None:
        values *= cosine
    large = {unit.block for unit in units.without_slivers if unit.zone == zone}
    words, definition = _WORDS[kind]
    attrs: dict[str, Any] = {
        "units": "m",
        "long_name": f"{words} of {zone}" + (f", {contact}" if contact else ""),
        "definition": definition,
        "zone": zone,
        "kind": kind,
    }
    attrs |= {"contact": contact} if contact else {}
    if nodes.cell_area is not None:
        attrs |= {"cell_area": nodes.cell_area, "cell_area_units": "m2"}
    return xarray.DataArray(
        values.reshape(len(blocks), *nodes.shape),
        dims=("block", *nodes.dims),
        coords={
            "block": ("block", np.array(blocks, dtype=object)),
            "sliver": ("block", np.array([block not in large for block in blocks])),
            **nodes.coords,
        },
        name="thickness",
        attrs=attrs,
    )


def units_of_zone(units: Units, zone: str, contact: str | None = None) -> list[Unit]:
    """Units of a zone, and of one contact interval if asked, or an InputError with the names."""
    zones = list(dict.fromkeys(unit.zone for unit in units.values()))
    check_name(zone, zones, f"unknown zone {zone!r}. Zones are")
    in_zone = [unit for unit in units.values() if unit.zone == zone]
    if contact is None:
        return in_zone
    known = sorted({unit.contact for unit in in_zone if unit.contact})
    refusal = f"zone {zone!r} has no contact interval {contact!r}. Its intervals are"
    check_name(contact, known, refusal)
    return [unit for unit in in_zone if unit.contact == contact]


def nodes_of(grid: Any, box: tuple[float, ...]) -> Nodes:
    """Return the nodes of a map from what a user asks for; see `thickness_map`."""
    w, e, s, n = box[:4]
    if grid is None:
        grid = max(e - w, n - s) / CELLS
    if not hasattr(grid, "coords"):
        return _cells(grid, w, e, s, n)

    # coordinates in metres, whatever unit they declare
    axes = []
    for name in HORIZON_DIMS:
        if name not in grid.coords:
            raise InputError(
                f"the grid of the map has no coordinate {name!r}, only {sorted(grid.coords)}. "
                "Give northing and easting [m], or the width of a cell."
            )
        axis = grid.coords[name]
        values = metres_of(axis, f"coordinate {name!r} of the map")
        if not np.isfinite(values).all():
            raise InputError(f"coordinate {name!r} of the map has values that are not finite.")
        axes.append((axis.dims, values))

    # one dimension each: a rectangle; both over the same two: a rotated or curved grid
    (north_dims, north), (east_dims, east) = axes
    if north.ndim == east.ndim == 1 and north_dims != east_dims:
        return _rectangle(north, east, None, (*north_dims, *east_dims))
    if north_dims != east_dims:
        raise InputError(
            f"the grid of the map has northing over {north_dims} and easting over {east_dims}; "
            "give both over one dimension each, or both over the same."
        )
    coords = {
        name: (north_dims, values, _axis_attrs(name))
        for name, values in zip(HORIZON_DIMS, (north, east), strict=True)
    }

    # map nodes as points (n_node, 2), whatever the shape of the grid
    feet = np.stack([east.ravel(), north.ravel()], axis=1)
    return Nodes(coords, tuple(north_dims), north.shape, feet, None)


def _cells(width: Any, w: float, e: float, s: float, n: float) -> Nodes:
    """Middles of equal cells that fill the box, about as wide as asked for."""
    if isinstance(width, bool) or not isinstance(width, int | float | np.number):
        raise InputError(
            f"the grid of a map is {type(width).__name__}; give the width of a cell [m], or an "
            "xarray object with coordinates northing and easting."
        )
    if not (is_number(width) and width > 0):
        raise InputError(f"cells of {width} m: the width must be above 0. Give a width in metres.")

    # whole numbers of cells that fill the box: each is about as wide as asked
    width = max(float(width), 1e-9 * (e - w))  # finer is refused in any case, and overflows
    n_col, n_row = (max(1, round(size / width)) for size in (e - w, n - s))
    if n_col * n_row > MOST_CELLS:
        raise InputError(
            f"cells of {width:g} m give a map of {n_col:.3g} x {n_row:.3g} cells; the limit "
            f"is {MOST_CELLS:g} cells. Choose a larger width."
        )
    dx, dy = (e - w) / n_col, (n - s) / n_row
    east, north = w + (np.arange(n_col) + 0.5) * dx, s + (np.arange(n_row) + 0.5) * dy
    return _rectangle(north, east, dx * dy, HORIZON_DIMS)


def _rectangle(
    north: np.ndarray, east: np.ndarray, cell_area: float | None, dims: tuple[str, ...]
) -> Nodes:
    x, y = np.meshgrid(east, north)
    coords = {
        name: (dim, values, _axis_attrs(name))
        for name, dim, values in zip(HORIZON_DIMS, dims, (north, east), strict=True)
    }
    return Nodes(coords, dims, x.shape, np.stack([x.ravel(), y.ravel()], axis=1), cell_area)


def _axis_attrs(name: str) -> dict[str, str]:
    return {"units": "m", "long_name": name}


class _Lines:
    """Passages of one unit, without triangles."""

    def __init__(self) -> None:
        self.parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, feet: np.ndarray | slice, through: Passages) -> None:
        """Add those of some feet."""
        foot = through.foot + (feet.start or 0) if isinstance(feet, slice) else feet[through.foot]
        self.parts.append((foot.astype(np.int32), through.way.astype(np.int8), through.elevation))

    def by_foot(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Foot, way and elevation of all, foot by foot: sums have the order of a single group."""
        foot, sign, elevation = (np.concatenate(of) for of in zip(*self.parts, strict=True))
        self.parts.clear()
        order = np.argsort(foot, kind="stable")
        return foot[order], sign[order], elevation[order]


def _block(lines: Sequence[_Lines], n_foot: int) -> np.ndarray:
    """Thickness at the feet of some units that do not overlap; NaN where there is none."""
    total, seen = np.zeros(n_foot), np.zeros(n_foot, dtype=bool)
    for of_unit in lines:
        foot, sign, elevation = of_unit.by_foot()
        if not len(foot):
            continue

        # heights count from a level near the unit, so that little is lost in the sum
        level = np.round(elevation.mean())

        # each line leaves through the top (+) and enters through the base (-): the sum is thickness
        total += np.bincount(foot, sign * (elevation - level), minlength=n_foot)
        seen[foot] = True
    return np.where(seen, total, np.nan)


def _check_balance(unit: Unit, found: Passages, feet: np.ndarray) -> None:
    """A line leaves a closed shell as often as it enters it."""
    count = np.bincount(found.foot, found.way, minlength=len(feet))
    bad = np.flatnonzero(count)
    if len(bad):
        x, y = feet[bad[0]].tolist()
        raise InvariantError(
            f"unit {unit.name!r} is left more often than entered at easting {x:.3f}, northing "
            f"{y:.3f}; please report this with the surfaces."
        )


def _cosine(
    by_unit: Sequence[tuple[Unit, Passages]], n: int, horizons: Sequence[str]
) -> np.ndarray:
    """Cosine of the dip of bedding at each foot: the highest way in, or else the lowest way out."""
    best = np.full(n, np.nan)
    for sign in (-1, 1):  # ways out first: ways in count more
        height, cosine = np.full(n, np.inf), np.full(n, np.nan)
        for unit, through in by_unit:
            bedding = np.isin(unit.surface_names, horizons)[through.surface]
            rows = np.flatnonzero(bedding & (through.way == sign))
            rows = rows[np.argsort(sign * through.elevation[rows], kind="stable")]

            # of each foot the last row stays: the highest way in, the lowest way out
            last = np.full(n, -1, dtype=np.int64)
            last[through.foot[rows]] = np.arange(len(rows))
            at = np.flatnonzero(last >= 0)
            depth = -sign * through.elevation[rows[last[at]]]
            better = depth < height[at]
            at = at[better]
            a, b, c = np.moveaxis(through.corners[rows[last[at]]], 1, 0)
            normal = np.cross(b - a, c - a)
            height[at] = depth[better]
            cosine[at] = np.abs(normal[:, 2]) / np.linalg.norm(normal, axis=1)
        best = np.where(np.isnan(cosine), best, cosine)
    return best


AT_ONCE = 1 << 18  # lines whose triangles of grids are in memory


@dataclass(frozen=True, eq=False)
class Passages:
    """Where vertical lines enter and leave one unit.

    Attributes
    ----------
    foot : ndarray of int64, shape (n,)
        Row of the feet.
    way : ndarray of int64, shape (n,)
        +1 where the line, upwards, leaves the unit; -1 where it enters.
    elevation : ndarray of float64, shape (n,)
        Local [m].
    corners : ndarray of float64, shape (n, 3, 3)
        Of the triangle there, outward; local.
    surface : ndarray of int64, shape (n,)
        Row of the surface.
    """

    foot: np.ndarray
    way: np.ndarray
    elevation: np.ndarray
    corners: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class _Met:
    """Triangles that lines pass, as their surfaces have them, and the units on both sides."""

    foot: np.ndarray
    way: np.ndarray
    corners: np.ndarray
    surface: np.ndarray
    sides: np.ndarray

    @classmethod
    def of(
        cls, corners: np.ndarray, surface: np.ndarray, sides: np.ndarray, feet: np.ndarray,
        middle: np.ndarray,
    ) -> _Met:  # fmt: skip
        """Search triangles (n, 3, 3), given the surface of each and the units beside it."""
        x = corners.reshape(-1, 3)
        found = cross_columns(x, np.arange(len(x)).reshape(-1, 3), feet, middle)
        at = found.triangle
        return cls(found.foot, found.way, corners[at], surface[at], sides[at])


def passages(
    units: Units, rows: Sequence[int], feet: np.ndarray, middle: np.ndarray
) -> Iterator[tuple[np.ndarray | slice, list[Passages]]]:
    """
    Find where vertical lines enter and leave some units, some lines at a time.

    Parameters
    ----------
    units : Units
    rows : sequence of int
        Of the units.
    feet : ndarray of float64, shape (n_foot, 2)
        Easting and northing [m].
    middle : ndarray of float64, shape (2,)
        Feet on the rim of a triangle count as if they were a little nearer to this.

    Yields
    ------
    rows : slice
        Of some feet; each foot is among one of these.
    found : list of Passages
        One for each unit; feet are counted among these rows.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> west, east, south, north = world.box[:4]
    >>> middle = np.array([0.5 * (west + east), 0.5 * (south + north)])
    >>> ((_, found),) = passages(units, [0, 1], middle[None], middle)
    >>> sorted(len(one.foot) for one in found)
    [0, 2]
    """
    listed = list(units.values())
    try:
        pieces, sides = units.piece_sides
    except InputError:  # units that were not carved have their triangles only
        yield slice(None), [_of_shell(listed[u], feet, middle) for u in rows]
        return
    elements = [units.elements_of(u) for u in rows]
    wanted = distinct(*elements)
    local, middle = feet - pieces.origin[:2], middle - pieces.origin[:2]

    # triangles near curves are few, and searched for all lines at once; grids are not
    near = _on_triangles(pieces, sides, wanted, local, middle)
    number = np.full(len(feet), -1)
    for low in range(0, max(len(feet), 1), AT_ONCE):
        part = slice(low, low + AT_ONCE)
        number[part] = np.arange(len(feet[part]))
        of = _among(near, number)
        number[part] = -1
        met = _joined([of, *_on_grids(pieces, sides, wanted, local[part], middle)])
        yield part, [_of_unit(met, u, local[part]) for u in rows]


def _among(met: _Met, number: np.ndarray) -> _Met:
    """What lines from the feet with a number pass, by that number; others have -1."""
    rows = np.flatnonzero(number[met.foot] >= 0)
    found = _Met(*(getattr(met, one.name)[rows] for one in fields(_Met)))
    return replace(found, foot=number[found.foot])


def _of_shell(unit: Unit, feet: np.ndarray, middle: np.ndarray) -> Passages:
    """Passages of the listed triangles of a unit."""
    local = feet - unit.origin[:2]
    crossings = cross_columns(unit.local, unit.triangles, local, middle - unit.origin[:2])
    corners = unit.local[unit.triangles[crossings.triangle]]
    surface = unit.surface_of_triangle[crossings.triangle]
    return Passages(crossings.foot, crossings.way, crossings.elevation, corners, surface)


def _on_triangles(
    pieces: Pieces, sides: np.ndarray, wanted: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> _Met:
    """Lines through triangles that no run has."""
    rows = wanted[: np.searchsorted(wanted, len(pieces.triangles))]
    corners = pieces.x[pieces.triangles[rows]]
    return _Met.of(corners, pieces.surface[rows], sides[rows], feet, middle)


def _on_grids(
    pieces: Pieces, sides: np.ndarray, wanted: np.ndarray, feet: np.ndarray, middle: np.ndarray
) -> list[_Met]:
    """Lines through runs, one surface after the other."""
    n_core, met = len(pieces.triangles), []
    for i, (source, strips) in enumerate(zip(pieces.sources, pieces.strips, strict=True)):
        lattice = source.lattice
        first = n_core + int(pieces.first_run[i])
        low, high = np.searchsorted(wanted, [first, n_core + int(pieces.first_run[i + 1])])
        if low == high or strips is None or lattice is None:
            continue
        runs = wanted[low:high] - first
        keys = keys_at(lattice, pieces.origin, feet, middle)
        if keys is None:  # a grid that folds on the map: its triangles are searched
            keys, run = strips.keys_of(runs)
            corners = corners_of(lattice, keys, pieces.origin)
            of = np.full(len(keys), i), sides[first + run]
            met.append(_Met.of(corners, *of, feet, middle))
            continue

        # runs that bound none of the units are left out
        run = runs_of_keys(lattice, strips, keys)
        is_wanted = np.zeros(len(strips.runs) + 1, dtype=bool)
        is_wanted[runs] = True
        foot = np.flatnonzero(is_wanted[run])
        corners = corners_of(lattice, keys[foot], pieces.origin)
        way = np.full(len(foot), 1 if lattice.right_handed != lattice.turned else -1)
        met.append(_Met(foot, way, corners, np.full(len(foot), i), sides[first + run[foot]]))
    return met


def _joined(parts: list[_Met]) -> _Met:
    """All parts as one."""
    return _Met(
        *(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(_Met))
    )


def _of_unit(met: _Met, u: int, feet: np.ndarray) -> Passages:
    """Passages of one unit: triangles turned outward, each from its lowest corner on."""
    rows = np.flatnonzero((met.sides == u).any(axis=1))
    front = met.sides[rows, 0] == u
    corners, foot = met.corners[rows], met.foot[rows]
    corners[front] = corners[front][:, [0, 2, 1]]
    corners = _from_lowest(corners)

    # the order of triangles of the shell where a sum has more than two terms: the same last digit
    order = np.argsort(foot, kind="stable")
    many = np.flatnonzero(np.bincount(foot)[foot[order]] > 2) if len(foot) else order
    keys = corners[order[many]].reshape(-1, 9)[:, ::-1].T
    order[many] = order[many][np.lexsort([*keys, foot[order[many]]])]
    rows, front, corners, foot = rows[order], front[order], corners[order], foot[order]
    way = np.where(front, -met.way[rows], met.way[rows])
    return Passages(foot, way, elevations(corners, feet[foot]), corners, met.surface[rows])


def _from_lowest(corners: np.ndarray) -> np.ndarray:
    """Triangles (n, 3, 3) from their westernmost corner on; then southern, then lower ones."""

    def before(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Whether corners a come before corners b."""
        comes_before = a[:, 2] < b[:, 2]
        for k in (1, 0):
            comes_before = (a[:, k] < b[:, k]) | ((a[:, k] == b[:, k]) & comes_before)
        return comes_before

    n = np.arange(len(corners))
    first = np.where(before(corners[:, 1], corners[:, 0]), 1, 0)
    first = np.where(before(corners[:, 2], corners[n, first]), 2, first)
    return corners[n[:, None], (first[:, None] + np.arange(3)) % 3]


# ---- gridded ----------------------------------------
# Put a horizon of a model on the nodes of a grid, and state what that loses at its faults.


def horizon_on_grid(
    patches: Patches, units: Units, horizon: str, grid: Any = None
) -> tuple[xarray.DataArray, GeosurfWarning | None]:
    """
    Return a horizon as a grid, and what it loses at faults, if it does.

    Parameters
    ----------
    patches, units : Patches, Units
    horizon : str
    grid : None, float or xarray object
        As for `thickness_map`.

    Returns
    -------
    (xarray.DataArray, GeosurfWarning or None)
        See `Scene.horizon_grid`.
    """
    nodes, faces = nodes_of(grid, units.box), faces_of(patches, units, horizon, "horizon")
    west, east, south, north = units.box[:4]
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)]) - faces.origin[:2]
    met = cross_columns(faces.x, faces.triangles, nodes.feet - faces.origin[:2], middle)
    values = np.full(len(nodes.feet), -np.inf)
    np.maximum.at(values, met.foot, met.elevation + faces.origin[2])
    count = np.bincount(met.foot, minlength=len(values))
    attrs = {"units": "m", "positive": "up", "long_name": f"elevation of {horizon}"}
    on_grid = xarray.DataArray(
        np.where(count > 0, values, np.nan).reshape(nodes.shape),
        nodes.coords, nodes.dims, horizon, attrs,
    )  # fmt: skip

    # rims of the horizon on faults: both walls, where they are apart
    ends = rim_edges(faces.triangles)
    rows = [i for i, source in enumerate(patches.sources) if source.role == "fault"]
    on_fault = np.isin(faces.point, patches.triangles[np.isin(patches.surface_of_triangle, rows)])
    a, b = faces.x[ends[on_fault[ends].all(axis=1)]].transpose(1, 0, 2)
    length, doubled = float(np.linalg.norm(b - a, axis=1).sum()), int((count > 1).sum())
    if not length and not doubled:
        return on_grid, None
    lost = (
        f"The grid of horizon {horizon!r} has no walls at faults: along {length_text(length)} of "
        "cut-offs it ends or slopes within one cell of them. "
        f"{counted(int((count == 0).sum()), 'node')} in fault gaps or outside the model have no "
        f"value; {counted(doubled, 'node')} where the horizon is doubled, as at reverse faults, "
        "have the upper elevation."
    )
    on_grid.attrs["lost"] = lost
    remedy = "Write scene.patches.surface(name) to keep the walls, or give smaller cells: grid=25."
    return on_grid, GeosurfWarning("grid", horizon, lost, remedy)
