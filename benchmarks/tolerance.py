"""Run time against error of models with a tolerance: ``python -m benchmarks.tolerance``.

Scenes of three horizons of 1001 x 1001 nodes and a fault of two triangles, from ``xarray`` grids to
the volumes of all units: smooth, with more relief, and with noise of 0.5 m. A row has the least
processor time of all rounds and its ratio to that of all nodes; every how many nodes the model has,
and how far it is from the others; the largest difference of the volume of a unit, and its bound.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator

import numpy as np
import xarray

import geosurf as gs

TOLERANCES = (0.03, 0.3, 3.0)
SIDE = 1001  # nodes along a side of the horizons


def layers(relief: float, noise: float) -> dict[str, xarray.DataArray]:
    """Three horizons of 10 km by 10 km."""
    axis = np.linspace(0.0, 10_000.0, SIDE)
    east, north = np.meshgrid(axis, axis)
    draw = np.random.default_rng(0)
    found = {}
    for k, level in enumerate((-1500.0, -1600.0, -1750.0)):
        z = level + relief * (1 + 0.1 * k) * np.sin(east / 1700) * np.cos(north / 2100)
        z += 10 * np.sin(east / 900 + k) + noise * draw.normal(size=z.shape)
        found[f"H{k + 1}"] = xarray.DataArray(
            z, {"northing": axis, "easting": axis}, ("northing", "easting"),
            attrs={"units": "m", "positive": "up"},
        )  # fmt: skip
    return found


def fault() -> gs.TriSurface:
    """A fault through all of them."""
    corners = [(4000, -1000, -3000), (6000, 11000, -3000), (5000, 11000, 0), (3000, -1000, 0)]
    return gs.TriSurface("F1", "fault", corners, [(0, 1, 2), (0, 2, 3)])


def rows(rounds: int) -> Iterator[str]:
    """Rows of the table."""
    for name, relief, noise in (
        ("smooth, relief 60 m", 60.0, 0.0),
        ("smooth, relief 400 m", 400.0, 0.0),
        ("noisy, relief 60 m", 60.0, 0.5),
    ):
        horizons, faults = layers(relief, noise), {"F1": fault()}
        times = dict.fromkeys((None, *TOLERANCES), float("inf"))
        scenes: dict[float | None, gs.Scene] = {}
        for _ in range(rounds):
            for tolerance in times:
                start = time.process_time()
                scenes[tolerance] = gs.Scene(horizons, faults, tolerance=tolerance)
                _ = scenes[tolerance].units.volumes
                times[tolerance] = min(times[tolerance], 1000 * (time.process_time() - start))
        exact = scenes[None].units.volumes
        yield f"| {name} | all nodes | {times[None]:.1f} | 1 | 0 m | 0 m³ | 0 m³ |"
        for tolerance in TOLERANCES:
            scene = scenes[tolerance]
            top = scene.surface("H1")
            stride = (SIDE - 1) // (top.lattice.shape[0] - 1)
            off = max(float(scene.surface(one).vertex_data.get("vertical_error", np.zeros(1)).max())
                      for one in horizons)  # fmt: skip
            change = float(abs(scene.units.volumes - exact).max())
            took = f"{times[tolerance]:.1f} ({times[tolerance] / times[None]:.2f})"
            sizes = f"{off:.2g} m | {change:.2g} m³ | {scene.volume_error_bound:.2g} m³"
            yield f"| {name} | {tolerance:g} m | {took} | {stride} | {sizes} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    sys.stdout.write("| scene | tolerance | time [ms] | every k-th node | largest distance "
                     "| largest change of a unit | bound |\n")  # fmt: skip
    sys.stdout.write("|---" * 7 + "|\n")
    for text in rows(asked.rounds):
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
