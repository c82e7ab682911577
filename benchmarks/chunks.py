"""Horizons larger than memory: time and memory next to reading their store once.

``python -m benchmarks.chunks --nodes 20000 --folder FOLDER`` writes a Zarr store of two horizons
there (5.4 GB for 20 000 x 20 000 nodes); it stays for the next run. Each row is a process of its
own: reading all chunks once, then curves and volumes without and with bounds next to the store.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs

CHUNK, STEP = 1000, 12.5
WAYS = ("read", "curves", "volumes")


def write_store(path: Path, n: int) -> None:
    """Write two waves with noise, n x n nodes each, in chunks."""
    import dask.array as da
    import xarray as xr

    axis = np.arange(n) * STEP

    def wave(block: np.ndarray, shift: float, block_info: Any = None) -> np.ndarray:
        (first, last), (left, right) = block_info[None]["array-location"]
        x, y = np.meshgrid(axis[left:right], axis[first:last])
        noise = np.random.default_rng(first * n + left).standard_normal(x.shape)
        return -2000.0 + shift + 80 * np.sin(x / 7000) * np.cos(y / 9000) + 0.2 * noise

    empty = da.zeros((n, n), chunks=CHUNK)
    attrs = {"units": "m", "positive": "up"}
    values = {
        name: (("northing", "easting"), empty.map_blocks(wave, shift, dtype=float), attrs)
        for name, shift in (("Top", 0.0), ("Base", -200.0))
    }
    grids = xr.Dataset(values, {"northing": axis, "easting": axis})
    grids.to_zarr(path, mode="w", consolidated=False)


def faults(n: int) -> dict[str, gs.TriSurface]:
    """Three dipping planes across the map."""
    size = n * STEP
    found = {}
    for k, (start, dip) in enumerate(((0.2, 1500.0), (0.5, -2000.0), (0.75, 1000.0))):
        a, b = start * size, (start + 0.1) * size
        deep = [[a, -1000, -4000], [b, size + 1000, -4000]]
        high = [[b + dip, size + 1000, 0], [a + dip, -1000, 0]]
        found[f"F{k + 1}"] = gs.TriSurface(
            f"F{k + 1}", "fault", [*deep, *high], [[0, 1, 2], [0, 2, 3]]
        )
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
        scene = gs.Scene(horizons, faults(n))
        _ = scene.curves if way == "curves" else (scene.curves, scene.volumes)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    took = time.perf_counter() - wall, time.process_time() - processor
    return {"wall": took[0], "processor": took[1], "memory": most}


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
    parser.add_argument("--way", choices=WAYS, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.way:
        print(json.dumps(run(asked.way, asked.folder)))
        return
    path = asked.folder / f"horizons_{asked.nodes}.zarr"
    if not path.exists():
        write_store(path, asked.nodes)
    for bounds in asked.folder.glob(f"{path.name}.*.geosurf-bounds"):
        bounds.unlink()
    print("| what | wall [s] | x reading | processor [s] | x reading | largest memory [MB] |")
    print("|---|---|---|---|---|---|")
    once = row("reading the store once", "read", path, None)
    row("curves, first time", "curves", path, once)
    row("curves, again", "curves", path, once)
    for bounds in asked.folder.glob(f"{path.name}.*.geosurf-bounds"):
        bounds.unlink()
    row("curves and volumes, first time", "volumes", path, once)
    row("curves and volumes, again", "volumes", path, once)


if __name__ == "__main__":
    main()
