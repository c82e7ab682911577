"""A small world made by hand: two bumpy horizons, a dipping fault, and the units between."""

from types import SimpleNamespace

import numpy as np
import pytest

from geosurf.model import Curves, Lattice, Patches, TriSurface, Unit, Units, VoxelSearch

ORIGIN = np.array([455680.0, 6779904.0, 0.0])
BOX = (456000.0, 460000.0, 6780000.0, 6783000.0, -2500.0, -1700.0)
THROW, FAULT_EAST, FAULT_SLOPE = 90.0, 457600.0, 0.4


def elevation(x, y, base):
    bumps = 55 * np.sin((x - 456000) / 700) * np.cos((y - 6780000) / 600)
    return base + bumps - 20 * ((y - 6781500) / 1500) ** 2


def horizon(name, base, n=20):
    x, y = np.linspace(456000, 460000, n), np.linspace(6780000, 6783000, n)
    z = elevation(*np.meshgrid(x, y), base)
    return TriSurface(name, "horizon", lattice=Lattice(x, y, z))


@pytest.fixture(scope="session")
def top():
    return horizon("Top", -2000.0)


@pytest.fixture(scope="session")
def base():
    return horizon("Base", -2220.0)


def fault_east(z):
    """Easting of the fault plane at some elevation: it dips to the east."""
    return FAULT_EAST + FAULT_SLOPE * (-2100.0 - np.asarray(z))


@pytest.fixture(scope="session")
def fault():
    z = (-1700.0, -2500.0)
    corners = [(fault_east(h), y, h) for y in (6779900, 6783100) for h in z]
    return TriSurface("F1", "fault", corners, [[0, 1, 3], [0, 3, 2]])


@pytest.fixture(scope="session")
def curves():
    lines, y = [], np.linspace(6780000, 6783000, 61)
    for level in (-2000.0, -2220.0):
        x = np.full_like(y, FAULT_EAST)
        for _ in range(60):
            x = fault_east(elevation(x, y, level))
        lines.append(np.stack([x, y, elevation(x, y, level)], axis=1) - ORIGIN)
    rows = (np.arange(61), np.arange(61, 122))
    pairs = np.array([[0, 2], [1, 2]])
    segments = np.concatenate([np.stack([r[:-1], r[1:]], axis=1) for r in rows])
    return Curves(
        names=("Top", "Base", "F1"),
        local=np.concatenate(lines),
        origin=ORIGIN,
        segments=segments,
        surfaces_of_segment=np.repeat(pairs, 60, axis=0),
        curves=rows,
        surfaces_of_curve=pairs,
        closed=np.array([False, False]),
        cost={"n_voxel": 1024, "n_candidate_pair": 913, "n_pair_meeting": 120},
    )


def block(name, zone, zone_index, side, west, east, levels, n=12):
    """A closed prism between two bumpy sheets; `levels` are None at the flat box ends."""
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    sheets = []
    for level, flat in zip(levels, BOX[4:], strict=True):
        drop = 0.0 if side == "F1-" else THROW
        y = BOX[2] + v * (BOX[3] - BOX[2])
        x = west + u * (east - west)
        z = np.full_like(x, flat) if level is None else elevation(x, y, level) - drop
        sheets.append(np.stack([x, y, z], axis=-1).reshape(-1, 3))
    number = np.arange(n * n).reshape(n, n)
    quads = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    a, b, c, d = (q.ravel() for q in quads)
    up = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    faces, labels = [up[:, ::-1], up + n * n], [np.full(len(up), 0), np.full(len(up), 1)]
    rims = (number[0], number[:, -1], number[-1][::-1], number[::-1, 0])
    for row, rim in enumerate(rims):
        p, q = rim[:-1], rim[1:]
        faces.append(np.stack([p, q, q + n * n], 1))
        faces.append(np.stack([p, q + n * n, p + n * n], 1))
        labels.append(np.full(2 * len(p), 2 + row))
    triangles, local = np.concatenate(faces), np.concatenate(sheets) - ORIGIN
    corners = local[triangles]
    cross = np.cross(corners[:, 1], corners[:, 2])
    return Unit(
        name=name,
        zone=zone,
        zone_index=zone_index,
        block=side,
        local=local,
        origin=ORIGIN,
        triangles=triangles,
        surface_of_triangle=np.concatenate(labels),
        surface_names=("lower", "upper", "south", "east", "north", "west"),
        volume=float((corners[:, 0] * cross).sum() / 6.0),
        area=1.0,
    )


@pytest.fixture(scope="session")
def units():
    zones = (
        ("above Top", (-2000.0, None)),
        ("Top/Base", (-2220.0, -2000.0)),
        ("below Base", (None, -2220.0)),
    )
    made = []
    for index, (zone, levels) in enumerate(zones):
        for side, west, east in (("F1-", BOX[0], FAULT_EAST), ("F1+", FAULT_EAST, BOX[1])):
            made.append(block(f"{zone}, {side}", zone, index, side, west, east, levels))
    return Units(made, BOX)


@pytest.fixture(scope="session")
def patches(top, fault):
    n = top.n_vertex
    triangles = np.concatenate([top.triangles, fault.triangles + n])
    west = top.vertices[top.triangles].mean(axis=1)[:, 0] < FAULT_EAST
    return Patches(
        sources=(top, fault),
        local=np.concatenate([top.vertices, fault.vertices]) - ORIGIN,
        origin=ORIGIN,
        triangles=triangles,
        surface_of_triangle=np.repeat([0, 1], [top.n_triangle, 2]),
        parent_of_triangle=np.concatenate([np.arange(top.n_triangle), [0, 1]]),
        patch_of_triangle=np.concatenate([np.where(west, 0, 1), [2, 2]]),
        curve_edges=np.array([[0, 1], [1, 2]]),
    )


@pytest.fixture(scope="session")
def search(top, fault, curves):
    size = 200.0
    lower = np.array([456800.0, 6780000.0, -2120.0])
    n_cell = np.array([7, 15, 1])
    occupied = np.unique(((curves.points[:61] - lower) // size).astype(int), axis=0)
    middle = top.vertices[top.triangles].mean(axis=1)
    near = np.abs(middle[:, 0] - fault_east(middle[:, 2])) < 170.0
    return VoxelSearch(
        lower=lower,
        upper=lower + size * n_cell,
        n_cell=n_cell,
        size=size,
        occupied=occupied[(occupied >= 0).all(axis=1) & (occupied < n_cell).all(axis=1)],
        faces_a=np.flatnonzero(near),
        faces_b=np.array([0, 1]),
    )


@pytest.fixture
def scene(top, base, fault, curves, units, patches):
    return SimpleNamespace(
        surfaces=(top, base, fault), curves=curves, units=units, patches=patches, box=BOX, aoi=None
    )
