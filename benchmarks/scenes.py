"""The scenes that are measured, by name and size: grids or arrays in, as users have them.

====================  =====================================================================
S1                    hills and one listric fault, two grids; a fifth of the triangles is fault
S1 shuffled           the same as arbitrary triangulations: vertices, triangles and corners shuffled
S2                    hills and a fault of two triangles
20 faults             hills and twenty listric faults of 317 x 317 nodes at full size
block                 two horizons, one fault and a box
five horizons         five horizons and three faults that cross each other, and a box
waves                 a smooth horizon and fault whose true curve and volumes are known
parallel chords       one large face, met by a comb of small triangles
crossing chords       one large face, met by two combs that cross
drogon                four horizons and six faults of a field, from the shared data folder
torn                  a smeared grid over six faults that die inside it, see `geology`
drogon field          points and sticks of that field, from which sheets are torn
====================  =====================================================================
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.folders import drogon_folder
from benchmarks.geology import field_sources, torn_sources
from geosurf import synthetic
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError
from geosurf.model import TriSurface
from geosurf.synthetic.world import make_fault, make_horizon
from geosurf.triangulate import triangulate_fault, triangulate_horizon

UTM = (456_000.0, 6_780_000.0, 0.0)
Mesh = tuple[np.ndarray, np.ndarray]


@dataclass
class Setting:
    """What one measurement starts from.

    Attributes
    ----------
    name : str
    sources : list of (str, str, object)
        Role, name and what a user has: an `xarray.DataArray` (horizon), an `xarray.Dataset`
        (fault), or vertices and triangles.
    box : tuple of float or None
        Of the model [m].
    truth : dict
        What is known, as in `geosurf.synthetic.World`.
    """

    name: str
    sources: list[tuple[str, str, Any]]
    box: tuple[float, ...] | None = None
    truth: dict[str, Any] = field(default_factory=dict)

    def surfaces(self) -> list[TriSurface]:
        """Make surfaces of all sources, anew."""
        return [_surface(*source) for source in self.sources]

    def meshes(self) -> list[Mesh]:
        """Vertices (float64) and triangles (int64) of all sources, as other packages take them."""
        return [
            (np.array(s.vertices, dtype=np.float64), np.array(s.triangles, dtype=np.int64))
            for s in self.surfaces()
        ]

    def by_role(self, role: str) -> dict[str, Any]:
        """Sources of one role by name, as `Scene` takes them."""
        return {
            name: _surface(kind, name, value) if isinstance(value, tuple) else value
            for kind, name, value in self.sources
            if kind == role
        }

    @property
    def input_bytes(self) -> int:
        """Size of the arrays that the sources hold."""
        return sum(array.nbytes for _, _, value in self.sources for array in _arrays(value))


def _surface(role: str, name: str, value: Any) -> TriSurface:
    if isinstance(value, TriSurface):
        return TriSurface(name, role, value.vertices, value.triangles)
    if isinstance(value, tuple):
        return TriSurface(name, role, *value)
    make = triangulate_horizon if role == "horizon" else triangulate_fault
    return make(value, name=name)


def _arrays(value: Any) -> list[np.ndarray]:
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, TriSurface):
        return [value.vertices, value.triangles]
    variables = value.data_vars.values() if hasattr(value, "data_vars") else [value]
    return [part.values for part in [*variables, *value.coords.values()]]


def _of_world(name: str, world: synthetic.World) -> Setting:
    sources = [("horizon", key, value) for key, value in world.horizons.items()]
    sources += [("fault", key, value) for key, value in world.faults.items()]
    return Setting(name, sources, world.box, world.truth)


def _nodes(triangles: float) -> int:
    """Nodes per side of a grid of so many triangles."""
    return max(round(math.sqrt(triangles / 2.0)) + 1, 3)


def _s1(size: float) -> Setting:
    world = synthetic.hills(_nodes(0.8 * size), n_fault=_nodes(0.2 * size), offset=UTM)
    return _of_world("S1", world)


def _s2(size: float) -> Setting:
    world = synthetic.hills(_nodes(size), n_fault=2, shape="plane", offset=UTM)
    return _of_world("S2", world)


def _shuffled(size: float) -> Setting:
    """S1 as triangle soups with shared vertices in any order."""
    rng = np.random.default_rng(7)
    sources = []
    for surface in _s1(size).surfaces():
        order = rng.permutation(surface.n_vertex)
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        faces = place[surface.triangles][rng.permutation(surface.n_triangle)]
        turn = (rng.integers(0, 3, len(faces))[:, None] + np.arange(3)) % 3
        faces = np.take_along_axis(faces, turn, axis=1)
        sources.append((surface.role, surface.name, (surface.vertices[order], faces)))
    return Setting("S1 shuffled", sources)


def _many(size: float) -> Setting:
    """At 1.39936e7 triangles: 2237 x 2237 nodes and 20 x 317 x 317."""
    share = 1.0 / (1.0 + 20.0 * (316 / 2236) ** 2)
    world = synthetic.hills(
        _nodes(share * size), n_fault=_nodes((1.0 - share) * size / 20.0), faults=20, offset=UTM
    )
    return _of_world("20 faults", world)


def _block(size: float) -> Setting:
    """At 7.2e5 triangles: two horizons of 401 x 401 nodes."""
    n = _nodes(size * 4 / 9)
    return _of_world("block", synthetic.hills(n, horizons=2, offset=UTM))


def _five(size: float) -> Setting:
    """At 1.6e6 triangles: five horizons of 401 x 401 nodes; three faults through all of them."""
    box = (0.0, 8000.0, 0.0, 8000.0, -2600.0, -1600.0)
    k, no_shift = 2.0 * np.pi / 5000.0, (0.0, 0.0, 0.0)

    def level(i: int) -> Callable[[Any, Any], Any]:
        """Elevation of a horizon."""
        return lambda x, y: -1800.0 - 120.0 * i + 30.0 * np.sin(k * x + i) * np.cos(k * y)

    n = _nodes(size / 5.0)
    sources: list[tuple[str, str, Any]] = [
        ("horizon", f"H{i}", make_horizon(f"H{i}", box, n, level(i), no_shift)) for i in range(5)
    ]
    for j, (azimuth, dip) in enumerate(((80.0, 65.0), (150.0, 60.0), (205.0, 70.0))):
        a = math.radians(azimuth)
        z, s = np.linspace(-1500.0, -2700.0, 3)[:, None], np.linspace(-7000.0, 7000.0, 5)[None]
        r = (-2100.0 - z) / math.tan(math.radians(dip)) + 150.0 * (j - 1)
        x = 4000.0 - s * math.cos(a) + r * math.sin(a)
        y = 4000.0 + s * math.sin(a) + r * math.cos(a)
        name = f"F{j + 1}"
        sources.append(("fault", name, make_fault(name, x, y, z + 0.0 * s, no_shift)))
    return Setting("five horizons", sources, box)


def _waves(size: float) -> Setting:
    return _of_world("waves", synthetic.waves(_nodes(size / 2.0), offset=UTM))


def _comb(n: int, across: bool) -> Mesh:
    """N separate upright triangles, each through the level 0 along a chord of 500 m."""
    at = np.linspace(1.0, 999.0, n) + 0.3 * np.sin(np.arange(n)) / n
    one = np.array([[0.0, 0.0, 1.0], [1000.0, 0.0, 1.0], [500.0, 0.0, -1.0]])
    corners = np.repeat(one[None], n, axis=0)
    corners[:, :, 1] += at[:, None]
    if across:
        corners = corners[:, :, [1, 0, 2]]
    return corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3)


def _face() -> Mesh:
    corners = np.array([[-1500.0, -700.0, 0.01], [3100.0, -900.0, -0.02], [400.0, 3900.0, 0.03]])
    return corners, np.array([[0, 1, 2]])


def _parallel(size: float) -> Setting:
    n = round(size)
    return Setting(
        "parallel chords", [("horizon", "Face", _face()), ("fault", "Comb", _comb(n, False))]
    )


def _crossing(size: float) -> Setting:
    n = round(size / 2)
    combs = [("fault", name, _comb(n, across)) for name, across in (("A", False), ("B", True))]
    return Setting("crossing chords", [("horizon", "Face", _face()), *combs])


def _drogon(size: float) -> Setting:
    from geosurf.read import read_fault, read_horizon

    folder = drogon_folder()
    grids = sorted((folder / "drogon_xtgeo" / "horizons_gri").glob("*.gri"))
    sticks = sorted((folder / "drogon" / "fault_sticks_pol").glob("*.pol"))
    if len(grids) != 4 or len(sticks) != 6:
        raise InputError(
            f"{folder}: the four horizons and six faults of Drogon are not there. "
            "Set GEOSURF_SHARED to the folder that holds data/drogon and data/drogon_xtgeo."
        )
    words = {"positive": "down", "length_unit": "m"}
    sources: list[tuple[str, str, Any]] = [
        ("horizon", path.stem, read_horizon(path, **words)) for path in grids
    ]
    for path in sticks:
        fault = triangulate_fault(read_fault(path, **words), name=path.stem)
        sources.append(("fault", path.stem, (fault.vertices, fault.triangles)))
    return Setting("drogon", sources)


def _torn(size: float) -> Setting:
    """At 1e7 triangles: 2237 x 2237 nodes; at least as many as six faults need."""
    return Setting("torn", torn_sources(max(_nodes(size), 101)))


def _field(size: float) -> Setting:
    sources, points = field_sources()
    return Setting("drogon field", sources, truth={"points": points})


SCENES: dict[str, Callable[[float], Setting]] = {
    "S1": _s1,
    "S1 shuffled": _shuffled,
    "S2": _s2,
    "20 faults": _many,
    "block": _block,
    "five horizons": _five,
    "waves": _waves,
    "parallel chords": _parallel,
    "crossing chords": _crossing,
    "drogon": _drogon,
    "torn": _torn,
    "drogon field": _field,
}


def make_setting(name: str, size: float) -> Setting:
    """
    Return a scene of about so many triangles.

    Parameters
    ----------
    name : str
        One of `SCENES`.
    size : float
        Number of triangles of all surfaces; chords: number of chords; Drogon has its own size.

    Returns
    -------
    Setting

    Raises
    ------
    InputError
        For an unknown name.

    Examples
    --------
    >>> setting = make_setting("S1", 2000)
    >>> [surface.n_triangle for surface in setting.surfaces()]
    [1568, 392]
    """
    if name not in SCENES:
        raise InputError(
            f"no scene is called {name!r}; there are {list(SCENES)}.{did_you_mean(name, SCENES)}"
        )
    return SCENES[name](float(size))
