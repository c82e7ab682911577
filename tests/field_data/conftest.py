"""Fields that nobody here made, and the exact checker that knows nothing of geosurf."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import geosurf as gs
from tests.field_data.checked import kit


@pytest.fixture(scope="session")
def data(shared: Path) -> Path:
    """Folder of the data sets."""
    return shared / "data"


@pytest.fixture(scope="session")
def verify(shared: Path) -> ModuleType:
    """The independent exact checker beside the checkout."""
    return kit()[0]


@pytest.fixture(scope="session")
def drogon_faults(drogon_sticks: dict[str, gs.FaultSticks]) -> list[gs.TriSurface]:
    """The six faults of the Drogon field, from sticks."""
    return [gs.triangulate_fault(sticks, name=name) for name, sticks in drogon_sticks.items()]


@pytest.fixture(scope="session")
def drogon_horizons(data: Path) -> list[gs.TriSurface]:
    """The four Drogon grids, youngest first; they coincide at up to 4.5 % of their nodes."""
    return read_grids(data / "drogon_xtgeo" / "horizons_gri")


@pytest.fixture(scope="session")
def reek_horizons(data: Path) -> list[gs.TriSurface]:
    """The four Reek grids, youngest first: holes, and two that cross."""
    return read_grids(data / "reek" / "horizons_gri")


def read_grids(folder: Path) -> list[gs.TriSurface]:
    """The numbered IRAP grids of a folder, triangulated."""
    found = []
    for path in sorted(folder.glob("0*.gri")):
        grid = gs.read_horizon(path, positive="down", length_unit="m")
        found.append(gs.triangulate_horizon(grid, name=path.stem[3:]))
    return found


def near(surface: gs.TriSurface, other: gs.TriSurface) -> tuple[np.ndarray, np.ndarray]:
    """The mesh of a surface, only where another's box is."""
    low, high = np.reshape(other.bounds, (3, 2)).T
    corners = surface.vertices[surface.triangles]
    reach = (corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)
    used, faces = np.unique(surface.triangles[reach.all(axis=1)], return_inverse=True)
    return surface.vertices[used], faces.reshape(-1, 3)


def pieces(segments: np.ndarray) -> tuple[int, int, int]:
    """Number of connected pieces of segments (n, 2), of free ends and of branches."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    nodes, ends = np.unique(segments, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), ends.T), shape=(len(nodes), len(nodes)))
    degree = np.bincount(ends.ravel())
    n_piece = connected_components(graph, directed=False)[0] if len(ends) else 0
    return int(n_piece), int((degree == 1).sum()), int((degree > 2).sum())
