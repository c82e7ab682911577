"""Continue a gridded horizon beyond its rim, and fill its holes, by the smoothest surface.

The trend of the rim, a quadratic, is taken off first. What is left is averaged over some cells next
to the rim, so that its noise is not extrapolated, and continued so that its third differences are
least. Last, the extension is bent to meet the rim itself; that bend dies within a few cells. Planes
and quadratics are continued exactly; the error on a fold grows with the cube of the distance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray
from scipy.ndimage import binary_dilation, binary_fill_holes, distance_transform_edt

from geosurf.conventions import area_text, is_number, length_text, real_numbers
from geosurf.conventions.checks import are_points
from geosurf.errors import GeosurfWarning, HorizonError, InputError
from geosurf.faults.distance import in_ring
from geosurf.model import Sheet, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.expected import box_of_sides, flag_of, outline_of
from geosurf.sheets.faults.network import Network
from geosurf.sheets.faults.traces import mesh_in_frame
from geosurf.sheets.lattice.picks import Frame, frame_of_lattice
from geosurf.sheets.lattice.solve import Graph, grounded, lattice_graph, smoothest, steps_to_known
from geosurf.sheets.mesh.finish import check_crs, fault_surfaces
from geosurf.sheets.tear import tear_horizon
from geosurf.triangulate import triangulate_horizon
from geosurf.triangulate.horizon import EXTRAPOLATED
from geosurf.triangulate.outline import check_outline

MOST = 4_000_000  # nodes of the lattice that is made
AVERAGED = (2.0, 20.0)  # cells next to the rim over which noise is averaged: least and most
RIM = 4  # further nodes next to these, which hold the surface
_PURE = 1e4  # scale at which first and second differences count for nothing


def extend_horizon(
    horizon: Any,
    area: Any = None,
    *,
    distance: float = 0.0,
    fill_holes: bool = False,
    faults: Mapping[str, Any] | Sequence[TriSurface] = (),
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
) -> xarray.DataArray:
    """
    Continue a gridded horizon to a box or area, up to a stated distance, and fill its holes.

    Nodes with data keep their values. New nodes lie on the same lattice, rotated as it is, and
    continue the horizon by the smoothest surface: planes and quadratics exactly.

    Parameters
    ----------
    horizon : xarray.DataArray, TriSurface, or points
        A grid with even steps, as for `triangulate_horizon`. Points become one first, as
        `tear_horizon` makes it with the same `faults`.
    area : sequence of 4 or 6 floats, array_like of shape (n, 2), or None
        West, east, south, north (bottom, top) of a box, or easting and northing around a polygon
        [m]. None: everywhere, as far as `distance` reaches.
    distance : float
        How far new nodes may be from the nearest node with data [m]. Nodes beyond stay NaN.
    fill_holes : bool
        Whether holes that data surround are filled as well, however wide they are.
    faults : mapping of str to fault, or sequence of TriSurface
        The surface is continued from its own side of these only. What a fault separates from all
        data stays NaN.
    name, positive, length_unit : str, optional
        As for `triangulate_horizon`.

    Returns
    -------
    xarray.DataArray
        Elevations [m], positive up. The coordinate ``extrapolated``, bool, marks new nodes: maps
        hatch them, and `Scene.warnings` lists their area and their largest distance from data.

    Raises
    ------
    HorizonError
        If the horizon is not a grid with even steps.
    InputError
        If the area or the distance cannot be used, or faults are in another coordinate reference
        system.

    See Also
    --------
    tear_horizon : rebuilds a horizon near its faults.

    Examples
    --------
    >>> import geosurf as gs
    >>> plane = gs.synthetic.tilted_planes(n=9).horizons["Top"]
    >>> wide = gs.extend_horizon(plane, (-900, 4900, -900, 3900), distance=1600.0)
    >>> plane.shape, wide.shape, int(wide.extrapolated.sum())
    ((9, 9), (15, 13), 114)
    >>> scene = gs.Scene({"Top": wide})
    >>> scene.box[:4]
    (-1000.0, 5000.0, -1125.0, 4125.0)
    """
    fill = flag_of(fill_holes, "fill_holes")
    if not (is_number(distance) and distance >= 0):
        raise InputError(f"distance is {distance!r}; give metres, 0 or more.")
    if distance == 0 and not fill:
        raise InputError("nothing to do: give distance= in metres, fill_holes=True, or both.")

    # the grid in the frame of its lattice, and the faults that it must not be continued across
    words: dict[str, Any] = {"name": name, "positive": positive, "length_unit": length_unit}
    if are_points(horizon):
        sheet = tear_horizon(horizon, faults, **words)
        surface = in_crs_of(as_lattice(sheet), [sheet])
    else:
        surface = triangulate_horizon(horizon, **words)
    if surface.lattice is None:
        raise HorizonError(
            f"horizon {surface.name!r} is a mesh, and only grids can be continued. Give the grid "
            "that it was made from."
        )
    walls = fault_surfaces(faults)
    check_crs(surface.name, surface.crs, walls)
    frame, z = frame_of_lattice(surface.lattice, f"horizon {surface.name!r}")
    corners = None if area is None else _corners(area)

    # the lattice that holds the area, and which of its nodes are new
    frame, z = _enlarged(frame, z, corners, float(distance))
    new = _new_nodes(frame, np.isfinite(z), corners, float(distance), fill)
    z = _continued(frame, z, new, walls)

    # nodes that no link ties to data got no value
    new &= np.isfinite(z)
    return _as_array(surface.name, frame, z, new, surface.crs)


def warning_of_extrapolation(horizon: TriSurface) -> GeosurfWarning | None:
    """Return a warning of the nodes that `extend_horizon` gave a horizon; None if it has none.

    Examples
    --------
    >>> import geosurf as gs
    >>> plane = gs.synthetic.tilted_planes(n=9).horizons["Top"]
    >>> wide = gs.extend_horizon(plane, distance=500.0)
    >>> print(warning_of_extrapolation(gs.triangulate_horizon(wide, name="Top")).effect)
    Horizon 'Top' is extrapolated over 6.75 km², up to 500 m from its data.
    """
    mark, lattice = horizon.vertex_data.get(EXTRAPOLATED), horizon.lattice
    if mark is None or lattice is None or not mark.any():
        return None

    # imported where there is something to measure: scipy.ndimage takes 0.2 s to load
    frame, _ = frame_of_lattice(lattice, f"horizon {horizon.name!r}")

    # distance in metres of each extrapolated node from the nearest node with data
    data = np.zeros(lattice.shape, dtype=bool)
    data[lattice.present] = ~mark
    wide, tall = frame.spacing.tolist()
    vertices = np.flatnonzero(lattice.present)
    far = distance_transform_edt(~data, sampling=(tall, wide)).ravel()[vertices]
    size = area_text(float(mark.sum()) * wide * tall)
    return GeosurfWarning(
        "extrapolated",
        horizon.name,
        f"Horizon {horizon.name!r} is extrapolated over {size}, up to "
        f"{length_text(float(far.max()))} from its data.",
        "Check it on the map, where it is hatched; a smaller distance= or aoi= leaves it out.",
        horizon.vertices[int(far.argmax())],
    )


def as_lattice(sheet: Sheet) -> TriSurface:
    """Return a torn horizon as a grid, without gaps at faults, with its extrapolated nodes."""
    mark, present = sheet.extrapolated, sheet.lattice.present
    marks = None if mark is None else {EXTRAPOLATED: mark[present]}
    return TriSurface(sheet.name, "horizon", lattice=sheet.lattice, vertex_data=marks)


def _corners(area: Any) -> np.ndarray:
    """Corners (n, 2) of a box or polygon."""
    try:
        values = real_numbers(area)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"area is {area!r}; give (west, east, south, north), a box, or corners (n, 2) [m]."
        ) from error
    if values.ndim != 1:
        return check_outline(values)
    heights = (0.0, 1.0) if len(values) == 4 else ()
    return outline_of(box_of_sides([*values.tolist(), *heights]))


def _enlarged(
    frame: Frame, z: np.ndarray, corners: np.ndarray | None, distance: float
) -> tuple[Frame, np.ndarray]:
    """The lattice with further rows and columns around it, and its values, NaN on these."""
    n_row, n_col = z.shape

    # rows and columns as far as the distance reaches, no more than the area needs; a share of a
    # step is taken for rounding. The horizon's own rows and columns always stay
    steps = np.ceil(distance / frame.spacing - 1e-9).astype(np.int64)
    low, high = -steps, np.array([n_col - 1, n_row - 1]) + steps
    if corners is not None:
        uv = frame.to_lattice(corners)
        low = np.maximum(low, np.floor(uv.min(axis=0) + 1e-6).astype(np.int64))
        high = np.minimum(high, np.ceil(uv.max(axis=0) - 1e-6).astype(np.int64))
    low, high = np.minimum(low, 0), np.maximum(high, (n_col - 1, n_row - 1))
    columns, rows = (high - low + 1).tolist()
    if columns * rows > MOST and columns * rows > z.size:
        raise InputError(
            f"the extended horizon would have {columns * rows} nodes, more than {MOST}. Give a "
            "smaller area or distance."
        )

    # where the old lattice lies in the new one
    at = slice(-low[1], n_row - low[1]), slice(-low[0], n_col - low[0])
    wide = np.full((rows, columns), np.nan)
    wide[at] = z

    # nodes of the horizon keep the coordinates that they came with
    if frame.easting.ndim == 1:
        easting = _longer(frame.easting, int(low[0]), columns)
        northing = _longer(frame.northing, int(low[1]), rows)
    else:
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        places = frame.to_world(np.stack([u, v], axis=-1).astype(np.float64))
        easting, northing = places[..., 0].copy(), places[..., 1].copy()
        there = np.isfinite(frame.easting) & np.isfinite(frame.northing)
        easting[at][there], northing[at][there] = frame.easting[there], frame.northing[there]
    corner = frame.corner + low @ frame.step
    return Frame((rows, columns), corner, frame.step, easting, northing), wide


def _longer(axis: np.ndarray, first: int, n: int) -> np.ndarray:
    """An axis with n nodes, of which the first is that many steps from its own."""
    step = (axis[-1] - axis[0]) / (len(axis) - 1)
    longer = axis[0] + np.arange(first, first + n) * step
    longer[-first : len(axis) - first] = axis
    return longer


def _new_nodes(
    frame: Frame, known: np.ndarray, corners: np.ndarray | None, distance: float, fill: bool
) -> np.ndarray:
    """Which nodes get a value, bool (n_row, n_col)."""
    wide, tall = frame.spacing.tolist()

    # holes belong to `fill`, not to `distance`; a hole at the border is no hole
    far = distance_transform_edt(~known, sampling=(tall, wide))
    holes = binary_fill_holes(known) & ~known
    new = ~known & ~holes & (far <= distance * (1 + 1e-9))
    if corners is not None:
        # two rows more than the area, so that all triangles that its rim crosses exist
        nodes = np.stack(np.meshgrid(*map(np.arange, frame.shape[::-1])), axis=-1)
        inside = in_ring(nodes, frame.to_lattice(corners))
        new &= binary_dilation(inside, np.ones((3, 3)), iterations=2)
    if fill:
        new |= holes
    return new


def _continued(
    frame: Frame, z: np.ndarray, new: np.ndarray, walls: Sequence[TriSurface]
) -> np.ndarray:
    """Elevations with those of new nodes; first across faults, to trace them, then up to them."""
    if not new.any():
        return z

    # the traces of faults over new nodes need heights there: a first solve without tears
    heights = _solved(frame, z, new, None)
    if not walls:
        return heights
    meshes = [mesh_in_frame(wall, frame) for wall in walls]
    network = Network(meshes, heights, frame)
    if not network.traces:
        return heights
    return _solved(frame, z, new, network.cuts.bits(z.size))


def _solved(frame: Frame, z: np.ndarray, new: np.ndarray, cut: np.ndarray | None) -> np.ndarray:
    """Elevations with those of new nodes that uncut links tie to data; NaN at the others."""
    # noise is averaged over about as many cells as new nodes reach out, within limits
    widest = float(distance_transform_edt(new).max())  # cells
    averaged = float(np.clip(widest, *AVERAGED))
    collar = int(np.ceil(2.0 * averaged)) + RIM
    near = distance_transform_edt(~new) <= collar

    # band: new nodes, and a collar of data around them, which is all that they depend on
    band = np.flatnonzero((new | near & np.isfinite(z)).ravel())
    graph = lattice_graph(band, frame.shape, cut)
    is_new = new.ravel()[band]

    # new nodes that a fault separates from all data have no solution: they leave the band
    tied = np.ones(len(band), dtype=bool)
    tied[is_new] = grounded(graph, np.where(is_new, np.cumsum(is_new) - 1, -1))
    if not tied.all():
        band = band[tied]
        graph, is_new = lattice_graph(band, frame.shape, cut), is_new[tied]

    # the trend of the rim
    uv = frame.cells_of_node(band)

    # centred and scaled, or squares of cells would cost the normal matrix its digits
    uv = (uv - uv.mean(axis=0)) / max(float(np.ptp(uv, axis=0).max()), 1.0)
    u, v = uv.T
    terms = np.column_stack([np.ones(len(u)), u, v, u * u, u * v, v * v])
    heights = z.ravel()[band]
    shape, *_ = np.linalg.lstsq(terms[~is_new], heights[~is_new], rcond=None)
    trend = terms @ shape
    rest = np.where(is_new, 0.0, heights - trend)

    # what is left of it, smooth, and then what that misses at the rim
    steps = steps_to_known(graph, np.where(is_new, -1, 0))
    smooth = _smooth(graph, rest, is_new, steps <= collar - RIM, frame.stretch, averaged)
    number = np.where(is_new, np.cumsum(is_new) - 1, -1)

    # exact at data: what the averaged surface misses there is continued, too, and dies soon
    missed = smoothest(graph, number, np.where(is_new, 0.0, rest - smooth), frame.stretch)
    out = z.copy().ravel()
    out[band[is_new]] = trend[is_new] + smooth[is_new] + missed
    return out.reshape(z.shape)


def _smooth(
    graph: Graph,
    rest: np.ndarray,
    is_new: np.ndarray,
    free: np.ndarray,
    stretch: np.ndarray,
    averaged: float,
) -> np.ndarray:
    """The smoothest surface (n,): drawn to data near new nodes, through data farther away."""
    # weight of data: averaged**-6, as third differences squared scale with length to the sixth
    unknown = is_new | free
    number = np.where(unknown, np.cumsum(unknown) - 1, -1)
    pull = np.where(is_new, 0.0, averaged**-6.0)[unknown]
    heights = rest.copy()
    heights[unknown] = smoothest(
        graph, number, rest, stretch, bend=0.0, pull=pull, target=rest[unknown], scale=_PURE
    )
    return heights


def _as_array(
    name: str, frame: Frame, z: np.ndarray, new: np.ndarray, crs: str | None
) -> xarray.DataArray:
    """The horizon as a labelled grid."""
    attrs = {"units": "m", "positive": "up", **({} if crs is None else {"crs": crs})}
    if frame.easting.ndim == 1:
        dims: tuple[str, str] = ("northing", "easting")
        coords: dict[str, Any] = {"northing": frame.northing, "easting": frame.easting}
    else:
        dims = ("row", "column")
        coords = {"easting": (dims, frame.easting), "northing": (dims, frame.northing)}
    coords[EXTRAPOLATED] = (dims, new)
    return xarray.DataArray(z, coords, dims, name=name, attrs=attrs)
