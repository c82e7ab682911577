"""What a tolerance costs next to the plain curve of the same grids: ``python -m benchmarks.dial``.

Waves and a listric fault (`gs.synthetic.waves`), n x n nodes each, and noisy hills with a listric
fault and with one of two triangles, from two ``xarray`` grids to the curve. Each round runs all
routes in turn; a cell has the least processor time of all rounds [ms], and its ratio to that of the
plain route.

Then scenes of three horizons of 1001 x 1001 nodes and a fault of two triangles, from ``xarray`` to
volumes and to curves, smooth and with noise of 0.5 m, with the bound that was met.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import xarray

import geosurf as gs
from benchmarks.scenes import make_setting

TOLERANCES = (1.0, 0.1, 0.01)
NODES = (141, 283, 566, 1131, 2237)
SIZES = (2e4, 1.28e6, 5e6)  # triangles of noisy hills
SIDE = 1001  # nodes along a side of the horizons of a scene


def least(routes: list[Callable[[], object]], rounds: int) -> list[float]:
    """Least processor time of each route over some rounds [ms]."""
    found = [float("inf")] * len(routes)
    for _ in range(rounds):
        for k, route in enumerate(routes):
            start = time.process_time()
            route()
            found[k] = min(found[k], 1000.0 * (time.process_time() - start))
    return found


def row(name: str, surfaces: Callable[[], list[gs.TriSurface]], rounds: int) -> str:
    """One row of the table."""
    n_triangle = sum(surface.n_triangle for surface in surfaces())

    def curve(tolerance: float) -> object:
        return gs.intersect_surfaces(surfaces(), tolerance=tolerance)

    times = least([lambda t=t: curve(t) for t in (0.0, *TOLERANCES)], rounds)
    cells = " | ".join(f"{t:.1f} ({t / times[0]:.2f})" for t in times[1:])
    return f"| {name} | {n_triangle:.3g} | {times[0]:.1f} | {cells} |"


def scenes() -> Iterator[tuple[str, Callable[[], list[gs.TriSurface]]]]:
    """Name and surfaces of each row; surfaces are made anew in each call."""
    for n in NODES:
        world = gs.synthetic.waves(n)
        (top,), (wall,) = world.horizons.values(), world.faults.values()
        yield (
            f"waves, {n} nodes per side",
            lambda top=top, wall=wall: [
                gs.triangulate_horizon(top, name="Top"),
                gs.triangulate_fault(wall, name="F1"),
            ],
        )
    for name, what in (("S1", "noisy hills, listric fault"), ("S2", "noisy hills, two triangles")):
        for size in SIZES:
            yield what, make_setting(name, size).surfaces


def layers(relief: float, noise: float) -> tuple[dict[str, xarray.DataArray], gs.TriSurface]:
    """Three horizons of 10 km by 10 km, and a fault through all of them."""
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
    corners = [(4000, -1000, -3000), (6000, 11000, -3000), (5000, 11000, 0), (3000, -1000, 0)]
    return found, gs.TriSurface("F1", "fault", corners, [(0, 1, 2), (0, 2, 3)])


def scene_rows(rounds: int) -> Iterator[str]:
    """Rows of the second table: scenes."""
    for name, relief, noise in (
        ("smooth, relief 60 m", 60.0, 0.0),
        ("smooth, relief 400 m", 400.0, 0.0),
        ("noisy, relief 60 m", 60.0, 0.5),
    ):
        horizons, fault = layers(relief, noise)

        def made(tolerance: float | None, horizons=horizons, fault=fault) -> gs.Scene:
            return gs.Scene(horizons, {"F1": fault}, tolerance=tolerance)

        for what in ("volumes", "curves"):
            routes = [lambda t=t, what=what: getattr(made(t), what) for t in (None, 1.0)]
            exact, quick = least(routes, rounds)
            scene = made(1.0)
            off = scene.surface("H1").vertex_data.get("vertical_error", np.zeros(1)).max()
            bound = off if what == "volumes" else scene.curves.error_bound.max()
            times = f"{exact:.1f} | {quick:.1f} ({quick / exact:.2f})"
            yield f"| {name}: {what} | {times} | {bound:.2g} m |"


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--scenes-only", action="store_true")
    asked = parser.parse_args()
    head = " | ".join(f"{t:g} m" for t in TOLERANCES)
    sys.stdout.write(f"| grids | triangles | plain | {head} |\n")
    sys.stdout.write("|---|---|---|" + "---|" * len(TOLERANCES) + "\n")
    for name, surfaces in scenes() if not asked.scenes_only else ():
        sys.stdout.write(row(name, surfaces, asked.rounds) + "\n")
        sys.stdout.flush()
    sys.stdout.write("\n| scene of three horizons | exact | 1 m | bound |\n|---|---|---|---|\n")
    for text in scene_rows(asked.rounds):
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
