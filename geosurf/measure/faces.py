"""Select the triangles of one surface inside the model, with the units on both sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray

from geosurf.conventions import check_word, is_word
from geosurf.conventions.axes import COORDINATES, meaning
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.mesh import edge_keys, renumbered
from geosurf.model import Patches, Unit, Units
from geosurf.model.expected import expect

PLUS, MINUS = 0, 1
POINTS = 1 << 31  # more than a model has: keys of its edges fit into int64
SIDES = {"+": PLUS, "-": MINUS, "hanging wall": PLUS, "footwall": MINUS}


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles of one surface that lie inside the model.

    Attributes
    ----------
    name : str
    x : ndarray of float64, shape (n_vertex, 3)
        Vertices of these triangles, local [m].
    point : ndarray of int64, shape (n_vertex,)
        Number of each vertex, rising: surfaces that meet in one have the same number for it.
    origin : ndarray of float64, shape (3,)
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    sides : ndarray of int64, shape (n, 2)
        Unit in front and behind, counted as in `listed`.
    listed : list of Unit
    """

    name: str
    x: np.ndarray
    point: np.ndarray
    origin: np.ndarray
    triangles: np.ndarray
    sides: np.ndarray
    listed: list[Unit]

    @cached_property
    def vectors(self) -> np.ndarray:
        """Area times unit normal of each triangle, float64 (n, 3) [m2]."""
        # half the cross product is area times normal: one array gives areas, dips and means
        a, b, c = (self.x[self.triangles[:, k]] for k in range(3))
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> np.ndarray:
        """Area of each triangle, float64 (n,) [m2]."""
        return np.linalg.norm(self.vectors, axis=1)

    @cached_property
    def mean(self) -> np.ndarray:
        """Unit vector along the sum of `vectors`."""
        # rounded once (fsum): the mean is the same whatever the order of triangles
        total = np.array([math.fsum(column) for column in self.vectors.T.tolist()])
        size = np.linalg.norm(total)
        if size == 0:
            raise GeometryError(
                f"surface {self.name!r} has no mean normal inside the model: it is closed, or "
                "the normals of its triangles cancel. Measure its parts separately.",
                surfaces=(self.name,),
            )
        return total / size

    @cached_property
    def strike(self) -> np.ndarray:
        """Horizontal unit vectors along the mean strike and the mean dip, float64 (2, 2).

        Right-hand rule: the dip direction is to the right of the strike.
        """
        east, north = self.mean[:2].tolist()
        size = math.hypot(east, north)
        if size < 1e-9:  # decides no topology: below this, the direction is rounding
            raise GeometryError(
                f"fault {self.name!r} is horizontal on average, so it has no strike. Use a "
                "fault that dips.",
                surfaces=(self.name,),
            )

        # the horizontal part of the normal of the hanging wall points down dip
        down = np.array([east, north]) / size
        return np.array([[-down[1], down[0]], down])

    @cached_property
    def zone_pairs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles between two units, by the zones of these.

        Pairs of zone indices in front and behind, int64 (n_pair, 2); rows of triangles, pair by
        pair; and the first of each pair, int64 (n_pair + 1,).
        """
        between = np.flatnonzero((self.sides >= 0).all(axis=1))
        zones = self.zones[self.sides[between]]
        n = len(self.listed) + 1
        keys = zones[:, 0] * n + zones[:, 1]
        order = np.argsort(keys, kind="stable")
        found, first = np.unique(keys[order], return_index=True)
        return np.stack(np.divmod(found, n), axis=1), between[order], np.append(first, len(order))

    @cached_property
    def zones(self) -> np.ndarray:
        """Zone index of each unit, int64 (n_unit,)."""
        return np.array([unit.zone_index for unit in self.listed], dtype=np.int64)

    @cached_property
    def borders(self) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
        """For either side: edges between zones, the upper and the lower zone there.

        Edges are rows of `x`, int64 (n, 2), the lower row first; zone indices int64 (n,).
        """
        return tuple(self.edges_between(side, self.zones) for side in (PLUS, MINUS))

    def edges_between(
        self, side: int, number_of_unit: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Edges between units with different numbers on one side, and the lower and higher one."""
        n = len(self.x)
        rows = np.flatnonzero(self.sides[:, side] >= 0)
        beside = np.repeat(number_of_unit[self.sides[rows, side]], 3)
        key, edge = np.unique(edge_keys(self.triangles[rows], n), return_inverse=True)
        upper, lower = np.full(len(key), len(self.listed)), np.full(len(key), -1)
        np.minimum.at(upper, edge, beside)
        np.maximum.at(lower, edge, beside)
        cut = upper < lower
        return np.stack(np.divmod(key[cut], n), axis=1), upper[cut], lower[cut]

    def along(self, points: np.ndarray) -> np.ndarray:
        """Distance of local points (n, 3) along the mean strike, from the fault's end [m]."""
        # the first vertex along the strike is 0, so that lines of both walls share one axis
        start = (self.x[distinct(self.triangles), :2] @ self.strike[0]).min()
        return points[:, :2] @ self.strike[0] - start


def faces_of(patches: Patches, units: Units, name: str, role: str | None = None) -> Faces:
    """
    Triangles of one surface that lie inside the model.

    Parameters
    ----------
    patches : Patches
    units : Units
        Carved from these patches.
    name : str
    role : {"horizon", "fault"}, optional
        What the surface has to be; default: either.

    Returns
    -------
    Faces

    Raises
    ------
    InputError
        If no such surface has that name.
    GeometryError
        If it does not reach into the model.
    """
    i = row_inside(patches, units, name, role)
    if patches.sources[i].role != "fault":  # large, and seldom asked for twice
        return _listed(patches, units, i)
    kept: dict[int, Faces] = units.faces
    if i not in kept:
        kept[i] = _listed(patches, units, i)
    return kept[i]


def row_inside(patches: Patches, units: Units, name: str, role: str | None = None) -> int:
    """Row of a surface that reaches into the model; errors as for `faces_of`."""
    check_model(patches, units)
    if role is not None and not is_word(role, ("horizon", "fault")):
        raise InputError(f"role is {role!r}, expected 'horizon' or 'fault'.")
    roles = ("horizon", "fault") if role is None else (role,)
    known = [source.name for source in patches.sources if source.role in roles]
    check_word(name, known, f"no {' or '.join(roles)} has the name {name!r}. Names are {known}.")
    i = row_of(patches, name, *roles)
    if i not in units.rows_inside:
        raise GeometryError(
            f"surface {name!r} lies outside the model. Enlarge the box, or skip this surface.",
            surfaces=(name,),
        )
    return i


def _listed(patches: Patches, units: Units, i: int) -> Faces:
    """List the triangles of one surface; no other surface is listed."""
    part = units.piece_sides[0].listed(i)

    # a triangle with no unit on either side lies outside the walls, or was cut off with them
    beside = units.sides_seen[part.element]
    rows = (beside >= 0).any(axis=1)
    used, place = renumbered(part.triangles[rows])
    return Faces(
        patches.names[i], part.local(used), used, patches.origin, place, beside[rows],
        list(units.values()),
    )  # fmt: skip


def edges_of(units: Units, i: int) -> np.ndarray:
    """
    Keys of the edges that a surface may share with others, rising.

    Parameters
    ----------
    units : Units
    i : int
        Row of the surface.

    Returns
    -------
    ndarray of int64
        As `edge_keys` has them, for `POINTS` points, which are numbered as in `Faces.point`.
    """
    kept: dict[object, np.ndarray] = units.faces
    key = ("edges", i)
    if key not in kept:
        # a surface meets others along edges of triangles that curves touch: runs have none
        pieces = units.piece_sides[0]
        low, high = np.searchsorted(pieces.surface, [i, i + 1])
        kept[key] = distinct(edge_keys(pieces.triangles[low:high], POINTS))
    return kept[key]


def check_model(patches: object, units: object) -> None:
    """Refuse what is not a model: patches, and the units that were carved from them."""
    expect(patches, Patches, "measures take Patches", "pass the result of rebuild_surfaces")
    expect(units, Units, "measures take Units", "pass the result of carve_units")


def row_of(patches: Patches, name: str, *roles: str) -> int:
    """Row of the surface that has a name and one of some roles; a wall may be called Top, too."""
    return next(i for i, s in enumerate(patches.sources) if s.name == name and (s.role in roles))


def side_of_words(side: str) -> int:
    """0 for the side into which the fault's normal points, 1 for the other.

    Examples
    --------
    >>> side_of_words("+"), side_of_words("footwall")
    (0, 1)
    """
    check_word(side, SIDES, f"side is {side!r}, expected one of {tuple(SIDES)}.")
    return SIDES[side]


# ---- dips ----------------------------------------
# Compute area, dip and azimuth of horizons and faults.


_DEGREE = "degree"


def orientation(patches: Patches, units: Units, name: str) -> xarray.Dataset:
    """
    Area, dip and azimuth of a horizon or fault inside the model, as a whole and by triangle.

    Parameters
    ----------
    patches, units : Patches, Units
    name : str
        Of a horizon or a fault. What the column has clipped away of a horizon is left out.

    Returns
    -------
    xarray.Dataset
        Over ``triangle``: ``area``, ``dip`` (0 to 90 from horizontal), ``azimuth`` (dip direction,
        clockwise from north, NaN where the dip is 0), ``overturned`` (its front looks down), and
        the middle. As a whole: ``total_area``, ``mean_dip``, ``mean_azimuth``, ``mean_strike``
        (azimuth less 90, right-hand rule), of the sum of all areas times their normals.

    Raises
    ------
    InputError
        If no horizon or fault has that name.
    GeometryError
        If it does not reach into the model, or has no mean normal.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9, dip=60.0, dip_direction=75.0)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> found = orientation(scene.patches, scene.units, "F1")
    >>> round(float(found.mean_dip), 9), round(float(found.mean_azimuth), 9)
    (60.0, 75.0)
    """
    faces = faces_of(patches, units, name)
    role = patches.sources[row_of(patches, name, "horizon", "fault")].role

    # a horizon that ends inside one unit, or that the column clipped, bounds nothing there; a fault
    # counts where it dies, too
    kept = np.ones(len(faces.areas), dtype=bool)
    if role == "horizon":
        kept = faces.sides[:, 0] != faces.sides[:, 1]
    vectors, areas = faces.vectors[kept], faces.areas[kept]

    # dip is that of the plane: the normal is turned up, and `overturned` keeps what was lost
    up = vectors[:, 2] < 0
    dip, azimuth = _lie(np.where(up[:, None], -vectors, vectors))

    # area-weighted mean: the sum of vectors does not depend on how the surface is meshed. fsum is
    # exact, so the order of triangles does not matter either
    total = np.array([math.fsum(column) for column in vectors.T.tolist()])
    mean_dip, mean_azimuth = _lie((-total if total[2] < 0 else total)[None])
    middle = faces.x[faces.triangles[kept]].mean(axis=1) + faces.origin
    azimuth_words = "dip direction, clockwise from north"
    mean_words = f"{azimuth_words}, of the mean normal"
    mean_strike = (mean_azimuth[0] - 90.0) % 360.0
    data = {
        "area": ("triangle", areas, meaning("area", "m2")),
        "dip": ("triangle", dip, meaning("dip from horizontal", _DEGREE)),
        "azimuth": ("triangle", azimuth, meaning(azimuth_words, _DEGREE)),
        "overturned": ("triangle", up, meaning("whether its front looks down", "1")),
        "total_area": ((), math.fsum(areas.tolist()), meaning("area", "m2")),
        "mean_dip": ((), mean_dip[0], meaning("dip of the mean normal", _DEGREE)),
        "mean_azimuth": ((), mean_azimuth[0], meaning(mean_words, _DEGREE)),
        "mean_strike": ((), mean_strike, meaning("strike by the right-hand rule", _DEGREE)),
    }
    for k, axis in enumerate(COORDINATES):
        words = meaning(f"{axis} of the middle of each triangle", "m")
        data[axis] = ("triangle", middle[:, k], words)
    return xarray.Dataset(data, attrs={"surface": name, "role": role})


def _lie(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Dip and azimuth of planes from their upward normals (n, 3) [degrees]."""
    # a horizontal plane has no dip direction: NaN, not north
    flat = np.hypot(normals[:, 0], normals[:, 1])
    dip = np.degrees(np.arctan2(flat, normals[:, 2]))
    azimuth = np.degrees(np.arctan2(normals[:, 0], normals[:, 1])) % 360.0
    return dip, np.where(flat > 0, azimuth, np.nan)
