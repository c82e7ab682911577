"""How surfaces of stress cases are made: soups, grids, walls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.stress.rational import flat
from geosurf.model import Lattice, TriSurface


def soup(name: str, corners: Any) -> TriSurface:
    """A surface of separate triangles (n, 3, 3)."""
    corners = np.asarray(corners, dtype=float).reshape(-1, 3)

    # no vertex is shared, even where corners are equal: the engine has to find that
    return TriSurface(name, "surface", corners, np.arange(len(corners)).reshape(-1, 3))


def grid(
    name: str, x: Any, y: Any, z: Any, *, role: str = "horizon", rising: bool = True
) -> TriSurface:
    """A surface over nodes (n_row, n_col); NaN in z where there is none."""
    x, y, z = np.broadcast_arrays(*(np.asarray(values, dtype=float) for values in (x, y, z)))

    # axes in two dimensions: grids turned in the map take the same way
    lattice = Lattice(x.copy(), y.copy(), z.copy(), rising=rising, reverse=False)
    return TriSurface(name, role, lattice=lattice)


def square_nodes(n: int, start: float = 0.0, step: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Easting and northing (n, n) of a square grid."""
    return np.meshgrid(start + step * np.arange(n), start + step * np.arange(n))


def bumps(rng: np.random.Generator, height: float = 1.0) -> Callable[..., np.ndarray]:
    """A smooth random function of x and y."""
    k, phase = rng.uniform(-1.5, 1.5, (3, 2)), rng.uniform(0, 6.28, 3)

    # Sum of three waves with random directions and phases.
    return lambda x, y: (
        height * sum(np.sin(a * x + b * y + c) for (a, b), c in zip(k, phase, strict=True))
    )


def solid_triangles(draw: Callable[[], np.ndarray], count: int) -> np.ndarray:
    """Triangles (count, 3, 3) with an area."""
    out: list[np.ndarray] = []
    while len(out) < count:
        corners = np.asarray(draw(), dtype=float)
        if not flat(corners):
            out.append(corners)
    return np.array(out)


def make_wall(
    rng: np.random.Generator, name: str, ends: Any, low: float, high: float, lean: float
) -> TriSurface:
    """A fault over a straight trace (2, 2), perhaps leaning."""
    ends = np.asarray(ends, dtype=float)
    n = int(rng.integers(2, 4))

    # Rows of nodes from low to high; `lean` moves them eastwards with elevation.
    t, z = np.meshgrid(np.linspace(0, 1, n), np.linspace(low, high, int(rng.integers(2, 4))))
    x = ends[0, 0] + t * (ends[1, 0] - ends[0, 0]) + lean * z
    y = ends[0, 1] + t * (ends[1, 1] - ends[0, 1])
    return grid(name, x, y, z, role="fault", rising=bool(rng.integers(2)))


def scaled_and_moved(surfaces: list[TriSurface], scale: float, offset: Any) -> list[TriSurface]:
    """The surfaces with vertices times a scale, plus an offset (3,)."""
    return [
        TriSurface(s.name, s.role, s.vertices * scale + np.asarray(offset), s.triangles)
        for s in surfaces
    ]
