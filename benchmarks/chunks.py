"""Horizons larger than memory: time and memory next to reading their store once.

``python -m benchmarks.chunks --nodes 20000 --folder FOLDER`` writes a Zarr store of two horizons
there (5.4 GB for 20 000 x 20 000 nodes); it stays for the next run. Each row is a process of its
own: reading all chunks once, then curves and volumes without and with bounds next to the store,
then measures of a model that is there already. With ``--rim`` horizons end at oblique lines, beyond
which nodes are absent (NaN). With ``--rotated`` each node has coordinates of its own in the store,
which are read with the elevations.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs

CHUNK, STEP = 1000, 12.5
MEASURES = {
    "certificate": "certificate",
    "map": "thickness map, 100 x 100 cells",
    "fine map": "thickness map, 2000 x 2000 cells",
    "sample": "sample of 10 000 points",
    "section": "section along the map",
    "picture": "map of a horizon",
    "units": "picture of all units",
}
WAYS = ("read", "curves", "volumes", "tolerance", *MEASURES)
TOLERANCE = 2.5  # [m]: the noise alone is up to 1.2


def turned(x: Any, y: Any) -> tuple[Any, Any]:
    """Coordinates that are rotated by 30 degrees."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    return c * x - s * y, s * x + c * y


def write_store(path: Path, n: int, rim: bool = False, rotated: bool = False) -> None:
    """Write two waves with noise, n x n nodes each, in chunks."""
    import dask.array as da
    import xarray as xr

    axis = np.arange(n) * STEP

    def wave(block: np.ndarray, shift: float, block_info: Any = None) -> np.ndarray:
        (first, last), (left, right) = block_info[None]["array-location"]
        x, y = np.meshgrid(axis[left:right], axis[first:last])
        noise = np.random.default_rng(first * n + left).standard_normal(x.shape)
        z = -2000.0 + shift + 80 * np.sin(x / 7000) * np.cos(y / 9000) + 0.2 * noise
        size = n * STEP
        absent = (x + 0.2 * y < 0.1 * size) | (x - 0.1 * y > 0.95 * size)
        found: np.ndarray = np.where(absent, np.nan, z) if rim else z
        return found

    empty = da.zeros((n, n), chunks=CHUNK)
    attrs = {"units": "m", "positive": "up"}
    values = {
        name: (("northing", "easting"), empty.map_blocks(wave, shift, dtype=float), attrs)
        for name, shift in (("Top", 0.0), ("Base", -200.0))
    }
    grids = xr.Dataset(values, {"northing": axis, "easting": axis})
    if rotated:  # each node has an easting and a northing
        y, x = da.meshgrid(*2 * [da.from_array(axis, CHUNK)], indexing="ij")
        plain = grids.drop_vars(["northing", "easting"])
        plain = plain.rename(northing="row", easting="column")
        places = zip(("easting", "northing"), turned(x, y), strict=True)
        grids = plain.assign_coords({key: (("row", "column"), of) for key, of in places})
    grids.to_zarr(path, mode="w", consolidated=False)


def faults(n: int, rotated: bool = False) -> dict[str, gs.TriSurface]:
    """Three dipping planes across the map."""
    size = n * STEP
    found = {}
    for k, (start, dip) in enumerate(((0.2, 1500.0), (0.5, -2000.0), (0.75, 1000.0))):
        a, b = start * size, (start + 0.1) * size
        deep = [[a, -1000, -4000], [b, size + 1000, -4000]]
        high = [[b + dip, size + 1000, 0], [a + dip, -1000, 0]]
        corners = np.array([*deep, *high], dtype=np.float64)
        if rotated:
            corners[:, :2] = np.stack(turned(*corners.T[:2]), axis=1)
        found[f"F{k + 1}"] = gs.TriSurface(f"F{k + 1}", "fault", corners, [[0, 1, 2], [0, 2, 3]])
    return found


def run(way: str, path: Path) -> dict[str, Any]:
    """Do one of `WAYS` in this process, and return what it took."""
    import xarray as xr

    warnings.simplefilter("ignore")
    wall, processor = time.perf_counter(), time.process_time()
    grids = xr.open_zarr(path, consolidated=False)
    if way == "read":
        for grid in (grids.Top, grids.Base):
            for first in range(0, grid.shape[0], CHUNK):
                np.asarray(grid.data[first : first + CHUNK]).max()
    else:
        n = grids.Top.shape[0]
        horizons = {
            name: gs.triangulate_horizon(grids[name], name=name, lazy=True)
            for name in ("Top", "Base")
        }
        tolerance = TOLERANCE if way == "tolerance" else None
        network = faults(n, rotated=grids.easting.ndim == 2)
        scene = gs.Scene(horizons, network, tolerance=tolerance)
        if way in MEASURES:
            _ = scene.units
            wall, processor = time.perf_counter(), time.process_time()
            measure(scene, way)
        elif way == "tolerance":
            _ = scene.volumes
            assert scene.volume_error_bound > 0.0
        else:
            _ = scene.curves if way == "curves" else (scene.curves, scene.volumes)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    took = time.perf_counter() - wall, time.process_time() - processor
    return {"wall": took[0], "processor": took[1], "memory": most}


def measure(scene: gs.Scene, way: str) -> None:
    """Do one of `MEASURES`."""
    west, east, south, north, bottom, top = scene.box
    if way == "certificate":
        assert scene.check().ok
    elif way == "map":
        scene.thickness("Top/Base")
    elif way == "fine map":
        scene.thickness("Top/Base", max(east - west, north - south) / 2000)
    elif way == "sample":
        rng = np.random.default_rng(0)
        low, high = (west, south, bottom), (east, north, top)
        scene.sample(rng.uniform(low, high, size=(10_000, 3)), codes=True)
    elif way == "section":
        scene.section([(west, 0.3 * south + 0.7 * north), (east, 0.6 * south + 0.4 * north)])
    elif way == "units":
        with tempfile.TemporaryDirectory() as folder:
            gs.render_scene(scene, Path(folder) / "units.png", show=("units",), exploded=0.3)
    else:
        scene.plot_map("Top")


def row(name: str, way: str, path: Path, once: dict[str, Any] | None) -> dict[str, Any]:
    """Print one row of the table, measured in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.chunks", "--way", way, "--folder", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    ratios = [found[key] / (once or found)[key] for key in ("wall", "processor")]
    print(
        f"| {name} | {found['wall']:.1f} | {ratios[0]:.2f} | {found['processor']:.1f} "
        f"| {ratios[1]:.2f} | {found['memory']:.0f} |",
        flush=True,
    )
    return found


def main() -> None:
    """Write the store where it is missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=8000)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--rim", action="store_true", help="end horizons at oblique lines")
    parser.add_argument("--rotated", action="store_true", help="rotate by 30 degrees")
    parser.add_argument("--way", choices=WAYS, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.way:
        print(json.dumps(run(asked.way, asked.folder)))
        return
    kind = f"{'_rim' if asked.rim else ''}{'_rotated' if asked.rotated else ''}"
    path = asked.folder / f"horizons_{asked.nodes}{kind}.zarr"
    if not path.exists():
        write_store(path, asked.nodes, asked.rim, asked.rotated)
    for bounds in asked.folder.glob(f"{path.name}.*.geosurf-bounds"):
        bounds.unlink()
    print("| what | wall [s] | x reading | processor [s] | x reading | largest memory [MiB] |")
    print("|---|---|---|---|---|---|")
    once = row("reading the store once", "read", path, None)
    row("curves, first time", "curves", path, once)
    row("curves, again", "curves", path, once)
    for bounds in asked.folder.glob(f"{path.name}.*.geosurf-bounds"):
        bounds.unlink()
    row("curves and volumes, first time", "volumes", path, once)
    row("curves and volumes, again", "volumes", path, once)
    if not (asked.rim or asked.rotated):
        row(f"volumes, tolerance {TOLERANCE:g} m", "tolerance", path, once)
    for way, name in MEASURES.items():
        row(name, way, path, once)


if __name__ == "__main__":
    main()
