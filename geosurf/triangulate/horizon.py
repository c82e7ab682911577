"""Make a `TriSurface` of a horizon, or raise an error that names the problem and the remedy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geosurf.conventions import (
    elevation_sign,
    first_given,
    is_number,
    metres_per_unit,
    rising_diagonal,
)
from geosurf.conventions.crs import crs_of
from geosurf.errors import HorizonError
from geosurf.lazy import xarray
from geosurf.model import Lattice, TriSurface
from geosurf.model.base import with_crs
from geosurf.model.expected import name_of
from geosurf.triangulate.decimate import can_be_decimated, decimate_frame
from geosurf.triangulate.grids import (
    StoredGrid,
    check_array,
    check_axis,
    check_cells,
    check_values,
    coordinates_of,
    decimate_stored,
    is_stored,
    lack_of_memory,
    read_stored,
    scale_of,
)
from geosurf.triangulate.mesh import refuse_flat_triangles, triangulate_mesh
from geosurf.triangulate.neighbours import own_form

EXTRAPOLATED = "extrapolated"  # the coordinate of a grid that marks nodes without data


def triangulate_horizon(
    da: xarray.DataArray | TriSurface | tuple[Any, ...] | list[Any],
    *,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    tolerance: float = 0.0,
) -> TriSurface:
    """Turn a horizon into a triangulated surface.

    Nodes become vertices, row by row; a triangle exists only where its three
    nodes do. One rule splits all cells of a grid: of the two diagonals the one
    that runs from south-west to north-east (`geosurf.conventions.rising_diagonal`
    has the ties). It looks at the world, not at rows and columns, so a grid that
    is read in another direction gives the same triangles. Triangles are made
    on first use; until then the surface is only a lattice.

    Parameters
    ----------
    da : xarray.DataArray, TriSurface, (vertices, triangles), or a surface of another package
        Other packages: see docs/guides/other_packages.md. A mesh has vertices (n_vertex, 3) and
        triangles (n_triangle, 3). A grid has either dims
        ``("northing", "easting")`` with 1-D coordinates that increase, or decrease as in rasters
        (rows or columns are then turned round), or any two dims with 2-D coordinates ``easting``
        and ``northing`` (rotated and curvilinear grids). NaN marks absent nodes. Horizontal
        coordinates are metres unless their own ``attrs["units"]`` differ.
    name : str, optional
        Default: the name of the array, or ``"horizon"``.
    positive : {"up", "down"}, optional
        Whether values are elevation or depth. Default: ``da.attrs["positive"]``; vertices are
        elevations.
    length_unit : str, optional
        Unit of the values. Default: ``da.attrs["units"]``; metres for vertices.
    tolerance : float
        0: all nodes. Above 0 [m]: every k-th node of a large grid, nowhere farther than this from
        all of its nodes, vertically. All nodes stay where fewer are farther off, of grids with
        fewer than 40 000 nodes, with absent nodes, or with 2-D coordinates that have no even steps.
        What was met is in ``vertex_data``: ``"vertical_error"`` [m] around each vertex, and
        ``"volume_error"`` [m3], whose sum bounds the change of any volume below or above the
        horizon. A grid in a store that does not fit into memory is read in bands.

    Returns
    -------
    TriSurface
        Role "horizon", normals up; metres, elevation positive up. With its `Lattice`. Arrays of
        float64 in metres, positive up, from south-west to north-east, are not copied: leave them
        as they are afterwards.

    Raises
    ------
    HorizonError
        If dims, coordinates, values, `positive` or `length_unit` cannot be used, or
        if a curvilinear grid is folded, or if a tolerance is not a length.

    See Also
    --------
    triangulate_fault : the same for faults.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> depth = xr.DataArray(
    ...     np.full((3, 4), 1850.0), dims=("northing", "easting"),
    ...     coords={"northing": [0.0, 50.0, 100.0], "easting": [0.0, 50.0, 100.0, 150.0]},
    ... )
    >>> top = triangulate_horizon(depth, name="Top", positive="down", length_unit="m")
    >>> top.n_triangle, top.bounds
    (12, (0.0, 150.0, 0.0, 100.0, -1850.0, -1850.0))

    A dome of 320 000 triangles, to half a metre:

    >>> import geosurf as gs
    >>> dome = gs.synthetic.dome_and_flat_fault(n=401).horizons["Top"]
    >>> coarse = triangulate_horizon(dome, tolerance=0.5)
    >>> coarse.n_triangle, bool(coarse.vertex_data["vertical_error"].max() <= 0.5)
    (20000, True)
    """
    return horizon_over(
        da, (), name=name, positive=positive, length_unit=length_unit, tolerance=tolerance
    )


def horizon_over(
    da: Any,
    maps: Iterable[Lattice],
    *,
    copy: bool = False,
    name: str | None = None,
    positive: str | None = None,
    length_unit: str | None = None,
    tolerance: float = 0.0,
    noun: str = "horizon",
) -> TriSurface:
    """Return the surface of `triangulate_horizon`, over one of some maps if it has the same.

    Parameters
    ----------
    maps : iterable of Lattice
        Of other horizons with 2-D coordinates. What has the same ones, to the last bit, refers to
        theirs, and to what is known of them.
    copy : bool
        Whether to copy what others can write to.
    noun : str
        What messages call it.
    """
    if name is not None:
        name = name_of(name, "horizon")
    title = str(name or getattr(da, "name", None) or "horizon")
    what = f"{noun} {title!r}"
    if not (is_number(tolerance) and tolerance >= 0):
        raise HorizonError(
            f"{what}: tolerance is {tolerance!r}. Give a length in metres, or 0 for all nodes."
        )
    da = own_form(da, title, "horizon", positive)
    if isinstance(da, TriSurface | tuple | list):
        return _from_mesh(da, title, positive, length_unit, tolerance)
    check_array(da, what)
    scale = scale_of(da, what, positive, length_unit)
    if is_stored(da):
        if tolerance > 0 and lack_of_memory([da]) is not None:
            return decimate_stored([StoredGrid.of(da, title, scale)], tolerance)[0]
        da = read_stored(da, title)
    easting, northing = coordinates_of(da, what)
    values = np.asarray(da.values, dtype=np.float64)
    if copy and scale == 1.0:
        values = _own(values)
    on = next((one for one in maps if easting.ndim == 2 and one.has_map(easting, northing)), None)
    if on is None:
        both = (_own(easting), _own(northing)) if copy else (easting, northing)
        lattice = _lattice_of(*both, values, scale)
    else:
        lattice = _without_minus_zero(on.with_elevation(values * scale if scale != 1.0 else values))
    # Only 1-D axes have an order to check; the check costs a pass, so floats decide first.
    if easting.ndim == 1 and not lattice.has_rising_axes:
        check_axis("easting", easting, what)
        check_axis("northing", northing, what)
    check_values(lattice, what)

    # The diagonal of the cells follows from the coordinates, not from the order of rows.
    if on is None:
        lattice = lattice.turned_as(rising_diagonal(lattice.easting, lattice.northing), None)
    check_cells(lattice, what)

    made = TriSurface(title, "horizon", lattice=lattice, vertex_data=_marks_of(da, lattice))
    return _with_fewer_nodes(with_crs(made, crs_of(da)), tolerance)


def _with_fewer_nodes(horizon: TriSurface, tolerance: float) -> TriSurface:
    """A horizon with every k-th node, or with all of them where it needs these."""
    # loaded by those who leave nodes out

    if tolerance == 0 or not can_be_decimated(horizon):
        return horizon
    found = decimate_frame([horizon], tolerance)
    return found[0] if found else horizon


def decimated_horizons(
    grids: Mapping[str, Any], words: Mapping[str, Mapping[str, str]], tolerance: float
) -> dict[str, TriSurface]:
    """
    Return horizons of every k-th node, by name, of grids in a store that memory does not hold.

    Parameters
    ----------
    grids : mapping of str to xarray.DataArray
        Those with the same axes keep the same rows and columns.
    words : mapping of str to mapping
        ``positive`` and ``length_unit`` of grids that do not declare them.
    tolerance : float
        [m].

    Raises
    ------
    HorizonError
        If a grid is rotated, has absent nodes, or needs more nodes than fit into memory.
    """
    groups: list[list[StoredGrid]] = []
    for name, da in grids.items():
        given = words[name].get("positive"), words[name].get("length_unit")
        grid = StoredGrid.of(da, name, scale_of(da, f"horizon {name!r}", *given))
        same = [group for group in groups if group[0].has_axes_of(grid)]
        if same:
            same[0].append(grid)
        else:
            groups.append([grid])
    surfaces = [surface for group in groups for surface in decimate_stored(group, tolerance)]
    return {surface.name: surface for surface in surfaces}


def _marks_of(da: Any, lattice: Lattice) -> dict[str, np.ndarray] | None:
    """Which vertices have no data, of a grid that `extend_horizon` continued; None for others."""
    if EXTRAPOLATED not in da.coords:
        return None
    mark: np.ndarray = np.asarray(da.coords[EXTRAPOLATED].transpose(*da.dims).values, dtype=bool)

    # 1-D axes may have been turned around, and the mark with them
    if lattice.easting.ndim == 1:  # lattices run from the south-west
        northing, easting = da.coords["northing"].values, da.coords["easting"].values
        rows = slice(None, None, -1 if northing[0] > northing[-1] else 1)
        columns = slice(None, None, -1 if easting[0] > easting[-1] else 1)
        mark = mark[rows, columns]
    return {EXTRAPOLATED: mark[lattice.present]}


def _from_mesh(
    obj: Any, title: str, positive: str | None, length_unit: str | None, tolerance: float
) -> TriSurface:
    """A horizon from vertices and triangles."""
    what = f"horizon {title!r}"
    scale = elevation_sign(first_given(positive, "up"), what)
    scale *= metres_per_unit(first_given(length_unit, "m"), what)
    surface = triangulate_mesh(obj, title, "horizon", scale=scale, words=(positive, length_unit))
    if surface.lattice is not None:
        return _with_fewer_nodes(surface, tolerance)
    if tolerance > 0:
        raise HorizonError(
            f"{what}: tolerance is {tolerance:g}, but geosurf simplifies grids only, not "
            "meshes. Leave tolerance= out."
        )
    refuse_flat_triangles(surface)
    return surface


def _lattice_of(
    easting: np.ndarray, northing: np.ndarray, elevation: np.ndarray, scale: float
) -> Lattice:
    """The lattice of some nodes, from the south-west: rasters have their northernmost row first."""
    # Copies, because kernels take contiguous arrays.
    if easting.ndim == 1 and easting.item(0) > easting.item(len(easting) - 1):
        easting, elevation = easting[::-1].copy(), elevation[:, ::-1].copy()
    if northing.ndim == 1 and northing.item(0) > northing.item(len(northing) - 1):
        northing, elevation = northing[::-1].copy(), elevation[::-1].copy()

    if scale != 1.0:
        elevation = elevation * scale
    return _without_minus_zero(Lattice(easting, northing, elevation))


def _without_minus_zero(lattice: Lattice) -> Lattice:
    """The lattice: -0.0 and 0.0 are equal and have different bytes, and the same data the same."""
    if not lattice.survey.minus_zero:
        return lattice
    return Lattice(
        lattice.easting, lattice.northing, lattice.elevation + 0.0, lattice.rising, lattice.reverse
    )


def _own(values: np.ndarray) -> np.ndarray:
    """An array that nobody else can write to."""
    return values if never_changes(values) else values.copy()


def never_changes(values: Any) -> bool:
    """Return whether an array is read-only, as is the array whose memory it uses."""
    if not isinstance(values, np.ndarray):
        return False
    while isinstance(values, np.ndarray):
        if values.flags.writeable:
            return False
        values = values.base
    return values is None or isinstance(values, bytes)
