"""Objects of other packages, as geosurf takes them: by what they have, without importing anything.

====================================  ==================================================
object                                what it becomes
====================================  ==================================================
xtgeo `RegularSurface`                a horizon (DataArray); the direction must be given
xtgeo `Points`                        a table of points; the direction must be given
xtgeo `Polygons`                      fault sticks, one for each id; likewise
pyvista `PolyData`                    (vertices, triangles); polygons are split
pyvista `PolyData` without cells      points (n, 3)
pyvista `StructuredGrid`, one layer   a horizon (DataArray), or a fault (Dataset)
meshio `Mesh`                         (vertices, triangles)
`vertices` and `faces`                trimesh: (vertices, triangles)
`vertices` and `triangles`            xtgeo, LoopStructural: (vertices, triangles)
`vertices` and `edges` (n, 3)         GemPy: (vertices, triangles)
arrays of vertices and triangles      (vertices, triangles), without twins of corners
arrays (n, 3) in a list               fault sticks
grid of xarray on other axes          a horizon over northing and easting
geopandas `GeoDataFrame`              points (n, 3), or fault sticks from lines
pandas `DataFrame`                    points by usual names; with the number of a stick: sticks
====================================  ==================================================

Vertices of meshes are elevations in metres, as everywhere in geosurf. Reference systems go along.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from geosurf.conventions import FAULT_DIMS, HORIZON_DIMS, elevation_sign
from geosurf.conventions.axes import COORDINATES, LABELS, USUAL, on_map_axes
from geosurf.conventions.crs import are_same, crs_of, label
from geosurf.conventions.machine import need
from geosurf.errors import InputError, warn_of
from geosurf.lazy import xarray as xr
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import Noun, with_crs
from geosurf.model.expected import name_of
from geosurf.triangulate.mesh import PlainMesh


def own_form(value: Any, name: str, role: str, positive: str | None = None) -> Any:
    """
    Return an object of another package as geosurf takes it; anything else as it is.

    Parameters
    ----------
    value : object
    name : str
        Of the horizon or fault, for messages.
    role : {"horizon", "fault"}
    positive : {"up", "down"}, optional
        Whether lines of other packages hold elevations or depths: these do not know it.

    Raises
    ------
    InputError
        If the object holds no surface, such as a volume mesh.

    Examples
    --------
    >>> class Mesh:  # as trimesh has it
    ...     vertices = [[0, 0, 0], [9, 0, 0], [0, 9, 5]]
    ...     faces = [[0, 1, 2]]
    >>> vertices, triangles = own_form(Mesh(), "F1", "fault")
    >>> vertices.shape, triangles.tolist()
    ((3, 3), [[0, 1, 2]])
    """
    if isinstance(value, tuple) and not isinstance(value, PlainMesh) and _are_mesh(value):
        return _without_twins(np.asarray(value[0], dtype=np.float64), np.asarray(value[1]))
    if role == "fault" and _are_sticks(value):
        sign = elevation_sign(positive or "up", f"fault {name!r}")
        return FaultSticks(name, tuple(np.array(s, dtype=float) * (1, 1, sign) for s in value))
    if role == "horizon" and len(getattr(value, "dims", ())) == 2 and hasattr(value, "rename"):
        return on_map_axes(value)
    # geosurf's own and xarray's objects, arrays, tables, paths: nothing to do
    plain = isinstance(value, Noun | FaultSticks | TriSurface | str | tuple | list | np.ndarray)
    if plain or hasattr(value, "data_vars") or hasattr(value, "coords"):
        return value
    what = f"{role} {name!r}"
    for is_one, convert in FORMS:
        if is_one(value):
            return convert(value, what, role, positive)
    return value


def _are_mesh(value: tuple[Any, ...]) -> bool:
    """Whether these are vertices (n, 3) and triangles (m, 3), as programs hand meshes on."""
    if len(value) != 2:
        return False
    shapes = [np.shape(part) for part in value if isinstance(part, np.ndarray)]
    whole = isinstance(value[1], np.ndarray) and value[1].dtype.kind in "iu"
    return whole and len(shapes) == 2 and all(len(one) == 2 and one[1] == 3 for one in shapes)


def _are_sticks(value: Any) -> bool:
    """Whether these are points (n, 3) of lines, and no mesh: corners of triangles are integers."""
    if not isinstance(value, list | tuple | np.ndarray) or isinstance(value, PlainMesh):
        return False
    try:
        parts = [np.asarray(part) for part in value]
    except ValueError:  # rows of different lengths
        return False
    points = all(p.ndim == 2 and p.shape[1] == 3 and p.dtype.kind in "fiu" for p in parts)
    return points and len(parts) > 0 and not (len(parts) == 2 and parts[1].dtype.kind in "iu")


def _has(*names: str) -> Callable[[Any], bool]:
    return lambda value: all(hasattr(value, name) for name in names)


def _grid_of_xtgeo(value: Any, what: str, role: str, positive: str | None) -> Any:
    """RegularSurface: values (column, row), masked where undefined."""
    z = np.ma.filled(np.ma.asarray(value.values).astype(np.float64), np.nan).T
    attrs = _meaning(positive)

    # nodes from origin and steps, as files of grids are read: axes have no rounding of rotations
    along = np.arange(value.ncol) * float(value.xinc)
    across = np.arange(value.nrow) * float(value.yinc) * float(value.yflip)
    if value.rotation % 360.0 == 0.0:
        coords: Any = {"northing": value.yori + across, "easting": value.xori + along}
        return xr.DataArray(z, coords, HORIZON_DIMS, attrs=attrs)
    turn = np.radians(value.rotation)
    x = value.xori + along * np.cos(turn) - across[:, None] * np.sin(turn)
    y = value.yori + along * np.sin(turn) + across[:, None] * np.cos(turn)
    dims = ("row", "column")
    return xr.DataArray(z, {"easting": (dims, x), "northing": (dims, y)}, dims, attrs=attrs)


def _xyz_of_xtgeo(value: Any, what: str, role: str, positive: str | None) -> Any:
    """Points or Polygons: a table with named columns."""
    table = value.get_dataframe()
    columns = [
        np.asarray(table[key], dtype=float) for key in (value.xname, value.yname, value.zname)
    ]
    if role == "horizon":
        return _points(columns, positive, {})
    if not hasattr(value, "pname"):
        raise InputError(
            f"{what}: points of xtgeo are in no order. Give fault sticks (xtgeo.Polygons), a mesh "
            "or a grid."
        )
    return _sticks(what, columns, np.asarray(table[value.pname]), positive)


def _name(what: str) -> str:
    return what.split("'", 1)[1].rsplit("'", 1)[0]


def _mesh_of_pyvista(value: Any, what: str, role: str, positive: str | None) -> Any:
    """PolyData: polygons become triangles, points alone stay points."""
    points = np.array(value.points, dtype=np.float64)
    if not len(value.faces):
        if role == "fault":
            raise InputError(f"{what}: the PolyData has no faces. Give a surface, or fault sticks.")
        return points
    faces = np.asarray(value.triangulate().faces).reshape(-1, 4)[:, 1:]
    mesh = PlainMesh((points, faces.astype(np.int64)))

    # as `TriSurface.to_pyvista` and .vtp files of geosurf hold it
    if len(found := getattr(value, "field_data", {}).get("crs", ())):
        mesh.crs = str(np.asarray(found).ravel()[0])
    return mesh


def _grid_of_pyvista(value: Any, what: str, role: str, positive: str | None) -> Any:
    """StructuredGrid of one layer."""
    if 1 not in value.dimensions:
        raise InputError(
            f"{what}: a StructuredGrid of {' x '.join(map(str, value.dimensions))} nodes is a "
            "volume. Give one layer of it, or grid.extract_surface()."
        )
    x, y, z = (np.squeeze(np.asarray(part, dtype=float)) for part in (value.x, value.y, value.z))
    if x.ndim != 2:
        raise InputError(f"{what}: the StructuredGrid has one row of nodes only.")
    if role == "horizon":
        dims = ("row", "column")
        coords = {"easting": (dims, x), "northing": (dims, y)}
        return xr.DataArray(z, coords, dims, attrs=_meaning("up"))
    data = {"easting": (FAULT_DIMS, x), "northing": (FAULT_DIMS, y)}
    return xr.Dataset({**data, "elevation": (FAULT_DIMS, z, _meaning("up"))})


def _mesh_of_meshio(value: Any, what: str, role: str, positive: str | None) -> Any:
    """Mesh: its triangles; other cells are refused, since dropping them would lose parts."""
    other = [kind for kind in value.cells_dict if kind not in ("triangle", "vertex", "line")]
    if other or "triangle" not in value.cells_dict:
        raise InputError(
            f"{what}: the mesh has cells of {', '.join(value.cells_dict) or 'no kind'}; geosurf "
            "takes triangles. Split or leave out the others."
        )
    return np.array(value.points, dtype=np.float64), np.array(value.cells_dict["triangle"])


def _mesh_of(key: str) -> Callable[[Any, str, str, str | None], Any]:
    """Two arrays by their names."""

    def convert(value: Any, what: str, role: str, positive: str | None) -> Any:
        vertices = np.array(value.vertices, dtype=np.float64)
        triangles = np.array(getattr(value, key))
        if vertices.ndim != 2 or triangles.ndim != 2 or triangles.shape[1] != 3:
            raise InputError(
                f"{what}: vertices have the shape {vertices.shape} and {key} {triangles.shape}; "
                "expected (n, 3) each. Split polygons into triangles."
            )
        return _without_twins(vertices, triangles.astype(np.int64))

    return convert


def _without_twins(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drop triangles with two corners at exactly one place, which GemPy makes; join these corners.

    Their sides lie on each other, so that the surface stays the same and closed.
    """
    inside = (triangles >= 0).all() and (triangles < len(vertices)).all()
    if not inside or not len(triangles):
        return vertices, triangles  # the surface says what is wrong
    corners = vertices[triangles]
    twins = (corners == np.roll(corners, -1, axis=1)).all(axis=2)
    if not twins.any():
        return vertices, triangles

    # each of the corners stands for the first one at its place
    rows = np.unique(np.concatenate([triangles[twins], np.roll(triangles, -1, axis=1)[twins]]))
    _, first, same = np.unique(vertices[rows], axis=0, return_index=True, return_inverse=True)
    stands = np.arange(len(vertices))
    stands[rows] = rows[first][same.ravel()]
    joined = stands[triangles]
    return vertices, joined[(joined != np.roll(joined, -1, axis=1)).all(axis=1)]


def _of_geopandas(value: Any, what: str, role: str, positive: str | None) -> Any:
    """GeoDataFrame: points for a horizon, lines for the sticks of a fault."""
    kinds = sorted(set(value.geometry.geom_type))
    flat = int((~value.geometry.has_z).sum())
    if flat:
        raise InputError(
            f"{what}: rows of the GeoDataFrame ({flat}) have no third coordinate. "
            "Give points or lines with elevations."
        )
    crs = None if value.crs is None else value.crs.to_string()
    if role == "horizon" and kinds == ["Point"]:
        columns = [np.asarray(getattr(value.geometry, axis)) for axis in "xyz"]
        return _points(columns, positive, {} if crs is None else {"crs": crs})
    if role == "fault" and kinds == ["LineString"]:
        scale = (1.0, 1.0, elevation_sign(positive, what))
        sticks = tuple(np.array(line.coords, dtype=float) * scale for line in value.geometry)
        return with_crs(FaultSticks(_name(what), sticks), crs)
    wanted = "points" if role == "horizon" else "lines (fault sticks)"
    raise InputError(
        f"{what}: the GeoDataFrame holds {', '.join(kinds)}; a {role} takes {wanted} with "
        "elevations."
    )


def _of_pandas(value: Any, what: str, role: str, positive: str | None) -> Any:
    """DataFrame with columns such as X_UTME, Y_UTMN, Z_TVDSS, and POLY_ID for sticks."""
    found = {str(name).strip().lower(): name for name in value.columns}
    at = [[found[one] for one in names if one in found] for names in USUAL.values()]
    label = [found[one] for one in LABELS if one in found]
    if any(len(names) != 1 for names in at) or (role == "fault" and not label):
        needed = "easting, northing and elevation" + (
            ", and POLY_ID for the number of the stick" if role == "fault" else ""
        )
        raise InputError(
            f"{what}: the columns of the table are {', '.join(map(str, value.columns))}; it needs "
            f"{needed}. Rename its columns."
        )
    columns = [np.asarray(value[names[0]], dtype=np.float64) for names in at]
    if role == "horizon":
        return _points(columns, positive, value.attrs)
    return _sticks(what, columns, np.asarray(value[label[0]]), positive)


def _meaning(positive: str | None) -> dict[str, str]:
    """What elevations mean, as far as that is known."""
    return {"units": "m"} | ({} if positive is None else {"positive": positive})


def _points(columns: Sequence[Any], positive: str | None, attrs: Mapping[Any, Any]) -> xr.Dataset:
    """Points of a horizon."""
    told: tuple[dict[str, str], ...] = ({}, {}, _meaning(positive))
    named = {key: ("point", *of) for key, *of in zip(COORDINATES, columns, told, strict=True)}
    return xr.Dataset(named, attrs=dict(attrs))


def _sticks(
    what: str, columns: Sequence[Any], label: np.ndarray, positive: str | None
) -> FaultSticks:
    """Sticks, one for each label, in the order of their first points."""
    points = np.stack(columns, axis=1) * (1.0, 1.0, elevation_sign(positive, what))
    parts = tuple(points[label == k] for k in dict.fromkeys(label.tolist()))
    return FaultSticks(_name(what), parts)


# what tells an object, and what turns it; the first that fits
FORMS: tuple[tuple[Callable[[Any], bool], Callable[..., Any]], ...] = (
    (_has("xori", "yflip", "values", "ncol", "nrow"), _grid_of_xtgeo),
    (_has("get_dataframe", "xname", "yname", "zname"), _xyz_of_xtgeo),
    (_has("geometry", "columns", "crs"), _of_geopandas),
    (_has("columns", "iloc", "attrs"), _of_pandas),
    (_has("points", "faces", "triangulate"), _mesh_of_pyvista),
    (_has("dimensions", "x", "y", "z", "n_cells"), _grid_of_pyvista),
    (_has("points", "cells_dict"), _mesh_of_meshio),
    (_has("vertices", "faces"), _mesh_of("faces")),
    (_has("vertices", "triangles"), _mesh_of("triangles")),
    (_has("vertices", "edges"), _mesh_of("edges")),
)


# ---- reprojection ----------------------------------------
# Coordinates from one coordinate reference system into another, through pyproj.


# A stated accuracy beyond this is worth a warning: picks and grids are seldom better [m].
ACCURATE = 1.0


def reproject(obj: Any, crs: str, *, source: str | None = None) -> Any:
    """
    Return a surface, grid or table in another coordinate reference system.

    Easting and northing are converted node by node, elevations stay. One operation of PROJ
    converts the whole object, the most accurate one that is installed for its area.

    Parameters
    ----------
    obj : DataArray, Dataset, TriSurface or FaultSticks
        A horizon; a table of points, tops or polygons, or a fault; a mesh; fault sticks.
    crs : str
        The new system, projected and in metres: ``"EPSG:32631"``.
    source : str, optional
        The system of an object that declares none.

    Returns
    -------
    DataArray, Dataset, TriSurface or FaultSticks
        A converted grid has easting and northing of each node, over (row, column): a regular grid
        is not regular in another system.

    Raises
    ------
    InputError
        If the object declares no system, declares another than `source`, cannot be converted, or
        lies outside the area of either system.
    DependencyError
        If pyproj is not installed.

    Examples
    --------
    >>> import geosurf as gs
    >>> top = gs.synthetic.graben(n=9).horizons["Top"].assign_attrs(crs="EPSG:23031")
    >>> gs.reproject(top, "EPSG:23031") is top  # nothing to convert
    True
    """
    crs = name_of(crs, "coordinate reference system")
    known = obj.crs if isinstance(obj, TriSurface | FaultSticks) else crs_of(obj, any_unit=True)
    what = repr(getattr(obj, "name", None) or "the object")
    if source is not None and not isinstance(source, str):
        raise InputError(f'source is {source!r}; give a text such as "EPSG:23031".')
    if known is None and source is None:
        raise InputError(
            f"{what} declares no coordinate reference system. Name it: gs.reproject(obj, {crs!r}, "
            'source="EPSG:...").'
        )
    if known is not None and source is not None and are_same(known, source) is False:
        raise InputError(
            f"{what} is in {label(known)}, but source is {source!r}. Leave source out."
        )
    known = known or str(source)
    if are_same(known, crs) and source is None:
        return obj

    # One way for each form; all end in `_converted`.
    if isinstance(obj, TriSurface):
        return _surface(obj, known, crs)
    if isinstance(obj, FaultSticks):
        return _moved_sticks(obj, known, crs)
    if hasattr(obj, "coords") and {"easting", "northing"} <= {*obj.coords, *_variables(obj)}:
        return _labelled(obj, known, crs, what)
    raise InputError(
        f"{what}: cannot convert {type(obj).__name__}. Give a horizon or table with easting and "
        "northing, a TriSurface or FaultSticks."
    )


def _variables(obj: Any) -> tuple[str, ...]:
    return tuple(getattr(obj, "data_vars", ()))


def _surface(surface: TriSurface, known: str, crs: str) -> TriSurface:
    # as a mesh: the rules for grids (diagonals, rows that rise) belong to the old axes
    vertices = surface.vertices.copy()
    what = f"{surface.role} {surface.name!r}"
    vertices[:, 0], vertices[:, 1] = _converted(vertices[:, 0], vertices[:, 1], known, crs, what)
    data = surface.vertex_data
    made = TriSurface(surface.name, surface.role, vertices, surface.triangles, vertex_data=data)
    return with_crs(made, crs)


def _moved_sticks(fault: FaultSticks, known: str, crs: str) -> FaultSticks:
    # all sticks at once: one operation for the fault
    points = np.concatenate(fault.sticks)
    x, y = _converted(points[:, 0], points[:, 1], known, crs, f"fault {fault.name!r}")
    points = np.stack([x, y, points[:, 2]], axis=1)
    ends = np.cumsum([len(stick) for stick in fault.sticks])[:-1]
    return with_crs(FaultSticks(fault.name, tuple(np.split(points, ends))), crs)


def _labelled(obj: Any, known: str, crs: str, what: str) -> Any:
    """Grids and tables of xarray, without the old declarations."""
    old = [key for key in ("spatial_ref", "crs", obj.attrs.get("grid_mapping")) if key]
    obj = obj.drop_vars([key for key in old if key in obj.coords]).copy()
    obj.attrs = {key: value for key, value in obj.attrs.items() if key != "grid_mapping"}
    obj.encoding = {key: value for key, value in obj.encoding.items() if key != "grid_mapping"}
    x, y = obj["easting"], obj["northing"]
    if x.dims != y.dims:  # axes of a regular grid
        east, north = np.meshgrid(x.values, y.values)
        obj = obj.transpose("northing", "easting", ...).drop_vars(["easting", "northing"])
        obj = obj.rename(northing="row", easting="column")
        dims: Any = ("row", "column")
    else:
        east, north, dims = x.values, y.values, x.dims
    new = _converted(east, north, known, crs, what)
    named = {
        key: (dims, part, {"units": "m"})
        for key, part in zip(("easting", "northing"), new, strict=True)
    }
    made = obj.assign(named) if "easting" in _variables(obj) else obj.assign_coords(named)
    return made.assign_attrs(crs=crs)


def _converted(
    x: np.ndarray, y: np.ndarray, known: str, crs: str, what: str
) -> tuple[np.ndarray, np.ndarray]:
    """Easting and northing in the new system [m]."""
    need("converting coordinates takes", "pyproj")
    from pyproj import CRS, Transformer
    from pyproj.aoi import AreaOfInterest
    from pyproj.exceptions import CRSError, ProjError
    from pyproj.transformer import TransformerGroup

    try:
        start, end = CRS.from_user_input(known), CRS.from_user_input(crs)
    except CRSError as error:
        raise InputError(
            f"{what}: PROJ does not know {label(known)!r} or {label(crs)!r}. Give EPSG codes, "
            'such as "EPSG:32631".'
        ) from error
    if not end.is_projected or any(a.unit_conversion_factor != 1.0 for a in end.axis_info[:2]):
        raise InputError(f"{label(crs)!r} is not projected in metres. Give one that is.")

    # the area in degrees: operations between datums hold in countries
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    try:
        to_degrees = Transformer.from_crs(start, start.geodetic_crs, always_xy=True)
        lon, lat = to_degrees.transform(x, y)
        area = AreaOfInterest(
            float(np.min(lon)), float(np.min(lat)), float(np.max(lon)), float(np.max(lat))
        )
        best = TransformerGroup(start, end, always_xy=True, area_of_interest=area).transformers[0]
        made_x, made_y = best.transform(x, y)
    except (ProjError, IndexError) as error:
        raise InputError(f"{what}: PROJ cannot convert it to {label(crs)} ({error}).") from error
    if not (np.isfinite(made_x).all() and np.isfinite(made_y).all()):
        raise InputError(
            f"{what}: some coordinates lie outside the area of {label(known)} or {label(crs)}. "
            "Check the declared system."
        )
    if not 0.0 <= best.accuracy <= ACCURATE:
        size = f"{best.accuracy:g} m" if best.accuracy >= 0.0 else "unknown"
        warn_of(
            "crs",
            what.split("'")[1] if "'" in what else what,
            f"{what} was converted to {label(crs)} by {best.description!r}, whose stated "
            f"accuracy is {size}.",
            "Convert all inputs the same way, or install the grids of PROJ for the area.",
        )
    return np.asarray(made_x), np.asarray(made_y)
