"""Open files with other packages. Run by their interpreter; it knows nothing of geosurf.

``python peer_reader.py TASKS.json``: a list of tasks with ``package``, ``path`` and ``repeat``.
Each becomes ``{"error": ...}`` or ``{"seconds": ..., "points": <file.npy>}``, printed as JSON. An
empty list prints which packages there are.
"""

from __future__ import annotations

import importlib.util
import json
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

PACKAGES = (
    "xtgeo", "meshio", "pyvista", "trimesh", "rioxarray", "geopandas", "pandas", "opengeode",
    "resqpy",
)  # fmt: skip
# what other packages raise for files that they do not take
REFUSALS = (
    OSError, ValueError, TypeError, LookupError, AttributeError, RuntimeError, ImportError,
    SystemExit,
)  # fmt: skip


def xtgeo(path: Path) -> np.ndarray:
    """Nodes, vertices, points or corners of cells."""
    import xtgeo

    suffix = path.suffix
    if suffix == ".ts":
        # z is depth there
        return np.asarray(xtgeo.triangulated_surface_from_file(str(path)).vertices) * [1, 1, -1]
    if suffix in (".egrid", ".roff", ".grdecl"):
        form = {"egrid": "egrid", "roff": "roff", "grdecl": "grdecl"}[suffix[1:]]
        return np.array([[float(xtgeo.grid_from_file(str(path), fformat=form).nactive)]])
    if suffix == ".pol":
        frame = xtgeo.polygons_from_file(str(path)).get_dataframe()
        return frame[["X_UTME", "Y_UTMN", "Z_TVDSS"]].dropna().to_numpy(dtype=float)
    if suffix in (".poi", ".xyz"):
        frame = xtgeo.points_from_file(str(path), fformat="xyz").get_dataframe()
        return frame[["X_UTME", "Y_UTMN", "Z_TVDSS"]].dropna().to_numpy(dtype=float)
    surface = xtgeo.surface_from_file(str(path))
    x, y = surface.get_xy_values(asmasked=False)
    z = np.ma.filled(surface.values.astype(float), np.nan)
    found = np.column_stack([np.ravel(x), np.ravel(y), np.ravel(z)])
    return found[~np.isnan(found[:, 2])]


def meshio(path: Path) -> np.ndarray:
    """Vertices of a mesh."""
    import meshio

    return np.asarray(meshio.read(path).points)


def pyvista(path: Path) -> np.ndarray:
    """Vertices of a mesh or of all blocks, centres of cells of image data; glTF has y upwards."""
    import pyvista as pv

    found = pv.read(path)
    if path.suffix == ".vti":
        return np.asarray(found.cell_centers().points)
    points = np.concatenate([np.asarray(one.points, dtype=float) for one in leaves(found)])
    return points[:, [0, 2, 1]] * [1, -1, 1] if path.suffix in (".glb", ".gltf") else points


def leaves(found: Any) -> list[Any]:
    """Meshes of blocks within blocks."""
    if not hasattr(found, "keys") or hasattr(found, "points"):
        return [found]
    return [leaf for k in range(len(found)) if found[k] is not None for leaf in leaves(found[k])]


def trimesh(path: Path) -> np.ndarray:
    """Vertices of a mesh or scene; glTF has y upwards."""
    import trimesh

    found = trimesh.load(str(path), process=False)
    if not hasattr(found, "geometry"):
        return np.asarray(found.vertices)
    points = []
    for node in found.graph.nodes_geometry:
        matrix, name = found.graph[node]
        points.append(found.geometry[name].vertices @ matrix[:3, :3].T + matrix[:3, 3])
    return np.concatenate(points)[:, [0, 2, 1]] * [1, -1, 1]


def rioxarray(path: Path) -> np.ndarray:
    """Nodes of a grid that states its reference system."""
    import rioxarray
    import xarray as xr

    if path.suffix == ".nc":
        data = xr.open_dataset(path, decode_coords="all")["elevation"]
        if data.rio.crs is None:
            raise ValueError("no reference system")
        x, y = data.easting.values, data.northing.values
    else:
        data = rioxarray.open_rasterio(path, masked=True)[0]
        x, y = data.x.values, data.y.values
    if x.ndim == 1:
        x, y = np.meshgrid(x, y)
    found = np.column_stack([x.ravel(), y.ravel(), data.values.ravel()])
    return found[~np.isnan(found[:, 2])]


def geopandas(path: Path) -> np.ndarray:
    """Points of all features of a file that states its reference system."""
    import geopandas
    import shapely

    frame = geopandas.read_file(path)
    if frame.crs is None or frame.crs.to_epsg() != 23031:
        raise ValueError(f"reference system {frame.crs}")
    return shapely.get_coordinates(frame.geometry, include_z=True)


def pandas(path: Path) -> np.ndarray:
    """Coordinates or volumes of a table."""
    import pandas

    frame = (pandas.read_parquet if path.suffix == ".parquet" else pandas.read_csv)(path)
    names = {str(name).lower(): name for name in frame.columns}
    for keys in (("x", "y", "z"), ("easting", "northing", "elevation")):
        if all(key in names for key in keys):
            return frame[[names[key] for key in keys]].to_numpy(dtype=float)
    raise ValueError(f"columns {list(names)[:6]}")


def opengeode(path: Path) -> np.ndarray:
    """Vertices of a surface, of points or of lines, or of all surfaces of a structural model."""
    import opengeode
    import opengeode_geosciences
    import opengeode_geosciencesio
    import opengeode_io

    packages = (opengeode, opengeode_io, opengeode_geosciences, opengeode_geosciencesio)
    for package in packages:
        for name in dir(package):
            if name.endswith("Library"):
                getattr(package, name).initialize()
    load = {
        ".ts": opengeode.load_triangulated_surface3D,
        ".vs": opengeode.load_point_set3D,
        ".pl": opengeode.load_edged_curve3D,
        ".ml": opengeode_geosciences.load_structural_model,
    }
    found = load[path.suffix](str(path))
    meshes = [one.mesh() for one in found.surfaces()] if path.suffix == ".ml" else [found]
    rows = [mesh.point(k) for mesh in meshes for k in range(mesh.nb_vertices())]
    return np.array([[row.value(axis) for axis in range(3)] for row in rows])


def resqpy(path: Path) -> np.ndarray:
    """Points of all triangulated sets and grids of a package, with z upwards."""
    import resqpy.model
    import resqpy.surface

    model = resqpy.model.Model(str(path))
    found = []
    for uuid in model.uuids(obj_type="TriangulatedSetRepresentation"):
        surface = resqpy.surface.Surface(model, uuid=uuid)
        found.append((surface.crs_uuid, surface.triangles_and_points()[1]))
    for uuid in model.uuids(obj_type="Grid2dRepresentation"):
        mesh = resqpy.surface.Mesh(model, uuid=uuid)
        found.append((mesh.crs_uuid, mesh.full_array_ref().reshape(-1, 3)))
    points = []
    for crs_uuid, part in found:
        crs = resqpy.crs.Crs(model, uuid=crs_uuid)
        points.append(part * [1, 1, -1 if crs.z_inc_down else 1] + [crs.x_offset, crs.y_offset, 0])
    joined = np.concatenate(points)
    return joined[~np.isnan(joined).any(axis=1)]


READ: dict[str, Callable[[Path], np.ndarray]] = {
    "xtgeo": xtgeo,
    "meshio": meshio,
    "pyvista": pyvista,
    "trimesh": trimesh,
    "rioxarray": rioxarray,
    "geopandas": geopandas,
    "pandas": pandas,
    "opengeode": opengeode,
    "resqpy": resqpy,
}


def run(task: dict[str, Any]) -> dict[str, Any]:
    """Open one file, some times."""
    path, best = Path(task["path"]), float("inf")
    try:
        for _ in range(task.get("repeat", 1)):
            start = time.process_time()
            points = READ[task["package"]](path)
            best = min(best, time.process_time() - start)
    except REFUSALS as error:
        return {"error": f"{type(error).__name__}: {error}"[:200]}
    target = Path(task["out"])
    np.save(target, np.asarray(points, dtype=float))
    return {"seconds": best, "points": str(target)}


def available() -> list[str]:
    """Packages that are installed here; importing all of them takes half a minute."""
    return [name for name in PACKAGES if importlib.util.find_spec(name) is not None]


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    tasks = json.loads(Path(sys.argv[1]).read_text())
    sys.stdout.write(json.dumps([run(task) for task in tasks] if tasks else available()))
