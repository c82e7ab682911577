"""One object of each kind that can be written, and the places that its file should hold."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import xarray as xr

import geosurf as gs
from geosurf.conventions.axes import COORDINATES

CRS = "EPSG:23031"
UPRIGHT = (".zmap", ".zmp", ".cps3", ".cps", ".asc")  # formats without rotation
ORIGIN = np.array([461_500.25, 5_926_500.1])


def grid_of(n_row: int, n_column: int, rotation: float, noise: float = 0.5) -> xr.DataArray:
    """A map with a rim and a hole without values; rotated ones have two-dimensional coordinates."""
    rng = np.random.default_rng(1)
    row, column = np.indices((n_row, n_column))
    along, across = 25.0 * column, 20.0 * row
    z = -1700 + 100 * np.sin(along / 3000) * np.cos(across / 4000)
    z += rng.normal(0, noise, z.shape)
    z[:1] = z[:, -2:] = z[n_row // 2, : n_column // 3] = np.nan
    attrs = {"units": "m", "positive": "up", "long_name": "Top", "crs": CRS}
    if rotation == 0.0:
        coords: Any = {"northing": ORIGIN[1] + across[:, 0], "easting": ORIGIN[0] + along[0]}
        return xr.DataArray(z, dims=("northing", "easting"), coords=coords, attrs=attrs)
    turn = np.radians(rotation)
    coords = {
        "easting": (("row", "column"), ORIGIN[0] + along * np.cos(turn) - across * np.sin(turn)),
        "northing": (("row", "column"), ORIGIN[1] + along * np.sin(turn) + across * np.cos(turn)),
    }
    return xr.DataArray(z, dims=("row", "column"), coords=coords, attrs=attrs)


def mesh_of(n: int) -> gs.TriSurface:
    """A surface of 2 (n - 1)^2 triangles with coordinates that have no short decimals."""
    rng = np.random.default_rng(2)
    x, y = (axis.ravel() / 3.0 for axis in np.meshgrid(np.arange(n) * 25.0, np.arange(n) * 25.0))
    vertices = np.column_stack([x + ORIGIN[0], y + ORIGIN[1], rng.normal(-1700, 0.5, n * n)])
    i = np.arange(n * n).reshape(n, n)
    low = np.stack([i[:-1, :-1], i[:-1, 1:], i[1:, 1:]], axis=-1).reshape(-1, 3)
    high = np.stack([i[:-1, :-1], i[1:, 1:], i[1:, :-1]], axis=-1).reshape(-1, 3)
    surface = gs.TriSurface("Top", "horizon", vertices, np.concatenate([low, high]))
    surface.crs = CRS
    return surface


def points_of(n: int) -> xr.Dataset:
    """Scattered points with a column of words."""
    rng = np.random.default_rng(3)
    place = np.array([*ORIGIN, -1700.0]) + rng.normal(0, 1000, (n, 3))
    data = {axis: ("point", place[:, k]) for k, axis in enumerate(COORDINATES)}
    return xr.Dataset(data | {"pick": ("point", [f"P{k}" for k in range(n)])}, attrs={"crs": CRS})


def subjects() -> dict[str, Any]:
    """One object for each kind of `geosurf.write.WRITERS`."""
    world = gs.synthetic.tilted_planes(n=9)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = gs.Scene(world.horizons, world.faults, world.box, crs=CRS)
        units = scene.units
        corner_points = gs.build_grid(scene, cell=(2000, 1500), layers=2)
    lines = scene.cutoffs("Top", "F1")
    corners = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]])
    one, faces = np.zeros(1, dtype=int), np.array([[0, 2, 1]])
    tets = gs.TetMesh(
        corners,
        np.zeros(3),
        np.arange(4)[None],
        one,
        ("A",),
        faces,
        one,
        np.array([[-1, 0]]),
        ("B",),
    )
    return {
        "TriSurface": mesh_of(20),
        "Curves": scene.curves,
        "Patches": scene.patches,
        "Unit": next(iter(units.values())),
        "Units": units,
        "TetMesh": tets,
        "FaultSticks": gs.FaultSticks("F1", tuple(lines)),
        "horizon (DataArray)": grid_of(31, 41, 30.0),
        "Dataset of lines": scene.fault_polygons("Top"),
        "Dataset of points": points_of(50),
        "Dataset on a grid": scene.sample(cell=(500, 500, 100)),
        "Dataset": units.table.reset_coords()[["volume", "area"]],
        "DataFrame": points_of(50).to_dataframe(),
        "list of lines": lines,
        "CornerPointGrid": corner_points,
        "surfaces": scene,
    }


def places(kind: str, obj: Any) -> np.ndarray | None:
    """What a file of an object should hold: points (n, 3), or volumes (n, 1); None if neither."""
    if kind == "horizon (DataArray)":
        return nodes(obj)
    if kind in ("TriSurface", "Patches", "Unit", "TetMesh"):
        return np.asarray(obj.vertices)
    if kind == "Units":
        return np.concatenate([unit.vertices for unit in obj.values()])
    if kind == "surfaces":
        names = (*obj.horizon_names, *obj.fault_names)
        return np.concatenate([obj.surface(name).vertices for name in names])
    if kind == "Curves":
        return np.asarray(obj.points)
    if kind in ("Dataset of points", "DataFrame", "Dataset of lines"):
        return np.column_stack([np.asarray(obj[axis]) for axis in COORDINATES])
    if kind == "FaultSticks":
        return np.concatenate(obj.sticks)
    return np.concatenate(obj) if kind == "list of lines" else None


def nodes(horizon: xr.DataArray) -> np.ndarray:
    """Easting, northing and value of all nodes that have one, shape (n, 3)."""
    x, y, z = xr.broadcast(horizon.easting, horizon.northing, horizon.reset_coords(drop=True))
    found = np.column_stack([one.transpose(*horizon.dims).values.ravel() for one in (x, y, z)])
    return found[~np.isnan(found[:, 2])].astype(np.float64)


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Largest distance from a place of either to the nearest of the other [m]."""
    from scipy.spatial import cKDTree

    if not len(one) or not len(other) or one.shape[1] != other.shape[1]:
        return 0.0 if len(one) == len(other) else np.inf
    if one.shape == other.shape and (one == other).all():
        return 0.0  # most answers: a search in trees takes longer
    middle = one.mean(axis=0)
    a, b = one - middle, other - middle
    return float(max(cKDTree(a).query(b)[0].max(), cKDTree(b).query(a)[0].max()))


__all__ = [
    "UPRIGHT",
    "difference",
    "grid_of",
    "mesh_of",
    "nodes",
    "places",
    "points_of",
    "subjects",
]
