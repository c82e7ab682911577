"""What a tolerance costs next to the plain curve of the same grids: ``python -m benchmarks.dial``.

Waves and a listric fault (`gs.synthetic.waves`), n x n nodes each, and noisy hills with a listric
fault and with one of two triangles, from two ``xarray`` grids to the curve. Each round runs all
routes in turn; a cell has the least processor time of all rounds [ms], and its ratio to that of the
plain route.

``--others``: grids with holes, meshes, and tolerances that triangles miss.

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
OTHER_TOLERANCES = (3.0, 0.03, 0.003)
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


def row(
    name: str,
    surfaces: Callable[[], list[gs.TriSurface]],
    rounds: int,
    tolerances: tuple[float, ...] = TOLERANCES,
) -> str:
    """One row of the table."""
    n_triangle = sum(surface.n_triangle for surface in surfaces())

    def curve(tolerance: float) -> object:
        return gs.intersect_surfaces(surfaces(), tolerance=tolerance)

    times = least([lambda t=t: curve(t) for t in (0.0, *tolerances)], rounds)
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


Maker = Callable[[], gs.TriSurface]


def grid(n: int, noise: float = 0.0, hole: bool = False) -> Maker:
    """Waves of 60 m on n x n nodes, 4 km by 3 km; the hole has a radius of 200 m."""
    x, y = np.linspace(0.0, 4000.0, n), np.linspace(0.0, 3000.0, n)
    east, north = np.meshgrid(x, y)
    z = -1500 + 60 * np.sin(east / 600) * np.cos(north / 500)
    z += noise * np.random.default_rng(0).normal(size=z.shape)
    if hole:
        z[np.hypot(east - 2000, north - 1500) < 200] = np.nan
    return lambda: gs.TriSurface("Top", "horizon", lattice=gs.Lattice(x, y, z))


def plane(rise: float = 0.25) -> Maker:
    """Two triangles that rise to the north, through the middle of the grids."""
    corners = [
        (x, y, -1500 + rise * (y - 1500) - (0.0 if rise else 600.0))
        for x, y in ((1500, -500), (1500, 3500), (2500, 3500), (2500, -500))
    ]
    return lambda: gs.TriSurface("F1", "fault", corners, [(0, 1, 2), (0, 2, 3)])


def bent_mesh(n: int = 61) -> Maker:
    """A bent fault of 2 (n - 1)² triangles."""
    north, z = np.meshgrid(np.linspace(-500, 3500, n), np.linspace(-2200, -800, n))
    east = 2000 + 200 * np.sin(north / 900) + 0.5 * (z + 1500) + 30 * np.sin(z / 300)
    k = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([
        np.stack([k, k + 1, k + n + 1], axis=1), np.stack([k, k + n + 1, k + n], axis=1)
    ])  # fmt: skip
    places = np.stack([east, north, z], axis=-1).reshape(-1, 3)
    return lambda: gs.TriSurface("F1", "fault", places, faces)


def gentle(n: int) -> Maker:
    """A second grid, nearly level."""
    x, y = np.linspace(0.0, 4000.0, n), np.linspace(0.0, 3000.0, n)
    east, north = np.meshgrid(x, y)
    z = -1500 + 0.03 * (east - 2000) + 0.01 * (north - 1500) + 5 * np.sin(east / 900)
    return lambda: gs.TriSurface("Base", "horizon", lattice=gs.Lattice(x, y, z))


def other_pairs() -> Iterator[tuple[str, Callable[[], list[gs.TriSurface]]]]:
    """Name and surfaces of each row of ``--others``."""
    for n in (71, 141, 401, 1001):
        for name, one, two in (
            ("smooth, two triangles", grid(n), plane()),
            ("smooth, mesh", grid(n), bent_mesh()),
            ("apart, two triangles", grid(n), plane(0.0)),
            ("noisy, two triangles", grid(n, 0.5), plane()),
            ("hole, two triangles", grid(n, hole=True), plane()),
            ("noisy with hole, two triangles", grid(n, 0.5, hole=True), plane()),
            ("hole, two grids", grid(n, hole=True), gentle(n)),
        ):
            yield f"{n} nodes per side: {name}", lambda one=one, two=two: [one(), two()]


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
    parser.add_argument("--others", action="store_true")
    asked = parser.parse_args()
    tolerances = OTHER_TOLERANCES if asked.others else TOLERANCES
    head = " | ".join(f"{t:g} m" for t in tolerances)
    sys.stdout.write(f"| grids | triangles | plain | {head} |\n")
    sys.stdout.write("|---|---|---|" + "---|" * len(tolerances) + "\n")
    rows = other_pairs() if asked.others else scenes()
    for name, surfaces in rows if not asked.scenes_only else ():
        sys.stdout.write(row(name, surfaces, asked.rounds, tolerances) + "\n")
        sys.stdout.flush()
    if asked.others:
        return
    sys.stdout.write("\n| scene of three horizons | exact | 1 m | bound |\n|---|---|---|---|\n")
    for text in scene_rows(asked.rounds):
        sys.stdout.write(text + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
