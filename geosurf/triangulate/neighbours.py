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

from collections.abc import Callable
from typing import Any

import numpy as np

from geosurf.conventions import FAULT_DIMS, HORIZON_DIMS, elevation_sign
from geosurf.conventions.axes import LABELS, USUAL, on_map_axes
from geosurf.errors import InputError
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import Noun
from geosurf.triangulate.mesh import PlainMesh

NAMES = ("easting", "northing", "elevation")


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
    import xarray as xr

    z = np.ma.filled(np.ma.asarray(value.values).astype(np.float64), np.nan).T
    attrs = {"units": "m"} | ({} if positive is None else {"positive": positive})

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
    import xarray as xr

    table = value.get_dataframe()
    columns = [
        np.asarray(table[key], dtype=float) for key in (value.xname, value.yname, value.zname)
    ]
    if role == "horizon":
        attrs = {"units": "m"} | ({} if positive is None else {"positive": positive})
        data = dict(zip(NAMES, columns, strict=True))
        return xr.Dataset(
            {key: ("point", data[key], attrs if key == "elevation" else {}) for key in NAMES}
        )
    if not hasattr(value, "pname"):
        raise InputError(
            f"{what}: points of xtgeo are in no order. Give fault sticks (xtgeo.Polygons), a mesh "
            "or a grid."
        )
    columns[2] = columns[2] * elevation_sign(positive, what)
    return _sticks(what, np.stack(columns, axis=1), np.asarray(table[value.pname]))


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
    import xarray as xr

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
        return xr.DataArray(z, coords, dims, attrs={"positive": "up", "units": "m"})
    meaning = {"units": "m", "positive": "up"}
    return xr.Dataset(
        {
            "easting": (FAULT_DIMS, x),
            "northing": (FAULT_DIMS, y),
            "elevation": (FAULT_DIMS, z, meaning),
        }
    )


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
    import xarray as xr

    kinds = sorted(set(value.geometry.geom_type))
    flat = int((~value.geometry.has_z).sum())
    if flat:
        raise InputError(
            f"{what}: rows of the GeoDataFrame ({flat}) have no third coordinate. "
            "Give points or lines with elevations."
        )
    if role == "horizon" and kinds == ["Point"]:
        points = np.stack([value.geometry.x, value.geometry.y, value.geometry.z], axis=1)
        attrs = {"units": "m"} | ({} if positive is None else {"positive": positive})
        found: Any = xr.Dataset(
            {k: ("point", points[:, i], attrs if i == 2 else {}) for i, k in enumerate(NAMES)}
        )
        found.attrs |= {} if value.crs is None else {"crs": value.crs.to_string()}
        return found
    if role == "fault" and kinds == ["LineString"]:
        scale = (1.0, 1.0, elevation_sign(positive, what))
        sticks = tuple(np.array(line.coords, dtype=float) * scale for line in value.geometry)
        made = FaultSticks(_name(what), sticks)
        if value.crs is not None:
            object.__setattr__(made, "crs", value.crs.to_string())
        return made
    wanted = "points" if role == "horizon" else "lines (fault sticks)"
    raise InputError(
        f"{what}: the GeoDataFrame holds {', '.join(kinds)}; a {role} takes {wanted} with "
        "elevations."
    )


def _of_pandas(value: Any, what: str, role: str, positive: str | None) -> Any:
    """DataFrame with columns such as X_UTME, Y_UTMN, Z_TVDSS, and POLY_ID for sticks."""
    import xarray as xr

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
        attrs = {"units": "m"} | ({} if positive is None else {"positive": positive})
        return xr.Dataset(
            {k: ("point", columns[i], attrs if i == 2 else {}) for i, k in enumerate(NAMES)},
            attrs=dict(value.attrs),
        )
    columns[2] = columns[2] * elevation_sign(positive, what)
    return _sticks(what, np.stack(columns, axis=1), np.asarray(value[label[0]]))


def _sticks(what: str, points: np.ndarray, label: np.ndarray) -> FaultSticks:
    """Sticks, one for each label, in the order of their first points."""
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
