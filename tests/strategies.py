"""Small inputs on integer lattices, where every degenerate contact is common."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from geosurf import TriSurface, build_walls
from tests import oracles

UTM = (456_000.0, 6_780_000.0, -2_048.0)


def lattice_points(extent: int = 3, dimension: int = 3):
    """Points with coordinates 0..extent."""
    return st.tuples(*[st.integers(0, extent)] * dimension)


def triangles(extent: int = 3):
    """Triangles with an area, float64 (3, 3)."""
    corners = st.lists(lattice_points(extent), min_size=3, max_size=3, unique=True)
    return corners.filter(lambda t: not oracles.flat(t)).map(lambda t: np.array(t, dtype=float))


@st.composite
def soups(draw, most: int = 4, extent: int = 3, names=("A", "B")):
    """Surfaces of separate triangles, one for each name."""
    out = []
    for name in names:
        corners = np.array(draw(st.lists(triangles(extent), min_size=1, max_size=most)))
        out.append(soup(name, corners))
    return out


def soup(name: str, corners) -> TriSurface:
    """A surface of separate triangles (n, 3, 3)."""
    corners = np.asarray(corners, dtype=float).reshape(-1, 3)
    return TriSurface(name, "surface", corners, np.arange(len(corners)).reshape(-1, 3))


@st.composite
def relief(draw, name: str = "Top", size: int = 3, height: int = 2, holes: bool = True):
    """A horizon of size x size cells with whole heights, perhaps with holes."""
    n = size + 1
    z = draw(st.lists(st.integers(0, height), min_size=n * n, max_size=n * n))
    present = np.ones(2 * size * size, dtype=bool)
    if holes:
        present[draw(st.lists(st.integers(0, 2 * size * size - 1), max_size=3))] = False
    return grid(name, np.array(z, dtype=float).reshape(n, n), present=present)


def grid(name, z, *, role="horizon", spacing=1.0, corner=(0.0, 0.0), rising=True, present=None):
    """A surface over a square grid from elevations (n_row, n_col)."""
    z = np.asarray(z, dtype=float)
    n_row, n_col = z.shape
    x, y = np.meshgrid(
        corner[0] + spacing * np.arange(n_col), corner[1] + spacing * np.arange(n_row)
    )
    number = np.arange(n_row * n_col).reshape(n_row, n_col)
    a, b, d, c = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    pair = ((a, b, c), (a, c, d)) if rising else ((a, b, d), (b, c, d))
    faces = np.stack([np.stack(t, axis=-1) for t in pair], axis=2).reshape(-1, 3)
    if present is not None:
        faces = faces[present]
    return TriSurface(name, role, np.stack([x, y, z], axis=-1).reshape(-1, 3), faces)


def sheet(name, corners, n=(1, 1), *, role="fault"):
    """A plane sheet between four corners (in order around), n[0] x n[1] cells of two triangles."""
    p, q, r, s = (np.asarray(c, dtype=float) for c in corners)
    u, v = np.meshgrid(np.linspace(0, 1, n[0] + 1), np.linspace(0, 1, n[1] + 1))
    u, v = u[..., None], v[..., None]
    nodes = (1 - v) * ((1 - u) * p + u * q) + v * ((1 - u) * s + u * r)
    number = np.arange(u.size).reshape(n[1] + 1, n[0] + 1)
    a, b, d, c = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
    return TriSurface(name, role, nodes.reshape(-1, 3), faces)


BOX = (0.0, 4.0, 0.0, 4.0, -4.0, 8.0)


def level(name, z, *, role="horizon", n=2, reach=1.0):
    """A level surface that reaches beyond `BOX`."""
    size = (4.0 + 2 * reach) / (n - 1)
    return grid(name, np.full((n, n), float(z)), role=role, spacing=size, corner=(-reach, -reach))


def upright(name, x, y=(-1, 5), z=(-5, 9)):
    """A plane fault across `BOX`, its normal to the east."""
    return sheet(name, [(x, y[0], z[0]), (x, y[1], z[0]), (x, y[1], z[1]), (x, y[0], z[1])])


def as_list(surface: TriSurface) -> TriSurface:
    """The same triangles, of which no lattice is known."""
    return TriSurface(surface.name, surface.role, surface.vertices, surface.triangles)


@st.composite
def faulted_worlds(draw):
    """One or two horizons of whole heights that reach beyond `BOX`, and up to two plane faults."""
    surfaces = []
    for k in range(draw(st.integers(1, 2))):
        z = draw(st.lists(st.integers(0, 2), min_size=9, max_size=9))
        z = np.array(z, dtype=float).reshape(3, 3) - 2.0 * k
        surfaces.append(
            grid(f"H{k + 1}", z, spacing=3.0, corner=(-1.0, -1.0), rising=draw(st.booleans()))
        )
    for k in range(draw(st.integers(0, 2))):
        surfaces.append(draw(_fault(f"F{k + 1}")))
    return [*surfaces, *build_walls(BOX)]


@st.composite
def _fault(draw, name):
    """A plane fault right across the box or ending in it, along a lattice line or diagonal."""
    at, lean = draw(st.integers(1, 3)), draw(st.integers(-1, 1))
    first = draw(st.sampled_from([-1, 0, 1]))
    last = draw(st.sampled_from([3, 4, 5]))
    bottom, top = draw(st.sampled_from([(-5, 9), (-4, 8), (-1, 3), (0, 9)]))
    corners = [
        (at - lean, first, bottom), (at - lean, last, bottom),
        (at + lean, last, top), (at + lean, first, top),
    ]  # fmt: skip
    if draw(st.booleans()):
        corners = [(y, x, z) for x, y, z in corners]
    return sheet(name, corners)


def moved(surface: TriSurface, offset=(0.0, 0.0, 0.0), scale=1.0) -> TriSurface:
    """A surface scaled, then shifted."""
    vertices = surface.vertices * scale + np.asarray(offset)
    return TriSurface(surface.name, surface.role, vertices, surface.triangles)


def shuffled(surface: TriSurface, rng: np.random.Generator, reflect=True) -> TriSurface:
    """The same surface with vertices, triangles and corners in another order."""
    new = rng.permutation(surface.n_vertex)
    vertices = np.empty_like(surface.vertices)
    vertices[new] = surface.vertices
    faces = new[surface.triangles][rng.permutation(surface.n_triangle)]
    turns = rng.integers(0, 3, len(faces))
    faces = np.stack([np.roll(face, k) for face, k in zip(faces, turns, strict=True)])
    if reflect:
        turned = rng.random(len(faces)) < 0.5
        faces[turned] = faces[turned][:, [0, 2, 1]]
    return TriSurface(surface.name, surface.role, vertices, faces)
