"""Count wrong answers in worlds of planes: ``python -m tests.carve.plane_worlds [worlds]``.

Three to seven planes of a small lattice, moved by decimals, scaled or at UTM coordinates, in a box
whose walls go through points of the lattice, or a unit in the last place beside them. So many
planes meet in one point, or in one line, but for rounding. Some are horizons, some worlds have a
fluid contact, in some a plane is there twice, one unit in the last place apart.

Each plane is one triangle (or two, which rounding folds along the diagonal). What must come out is
known in rational arithmetic: a unit is the box cut by half-spaces of the planes as they are in
floating point. Units, their zones, sides of faults, contact intervals and volumes are compared;
volumes must be above 0 and add up to the box, and the certificate must pass. A `RoundingError` that
names a place is a refusal; any other error is wrong. Ends with 1 if anything is wrong, or if more
than one world in a thousand is refused.
"""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import dataclass, field

import numpy as np

from geosurf import TriSurface, build_contacts, build_walls, carve_units, rebuild_surfaces
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.carve.certificate import certify
from geosurf.errors import RoundingError
from tests.carve.half_spaces import Pieces
from tests.counting import count
from tests.strategies import UTM

REACH = 64
MOST_REFUSED = 1e-3
NORMALS = [
    normal
    for normal in itertools.product(range(-2, 3), repeat=3)
    if normal > (0, 0, 0) and 1 in map(abs, normal)
]
KINDS = ("faults", "folded", "horizons", "contact", "pencil", "twice", "beside")


@dataclass
class PlaneWorld:
    """Surfaces in a box.

    Attributes
    ----------
    surfaces : list of TriSurface
        Horizons, youngest first, then faults; no walls.
    box : tuple of float
    contact : float or None
        Elevation of a fluid contact.
    folded : bool
        Whether planes are two triangles each.
    """

    surfaces: list[TriSurface]
    box: tuple[float, ...]
    contact: float | None = None
    folded: bool = False
    kind: str = field(default="faults")


# ---------------------------------------------------------------------- worlds
def corners_of(normal, offset, folded: bool) -> np.ndarray:
    """Whole corners of a triangle or rectangle of the plane ``normal . p = offset``."""
    axis = [k for k in range(3) if abs(normal[k]) == 1][-1]
    one, two = (k for k in range(3) if k != axis)
    far = REACH if folded else 3 * REACH
    out = []
    for a, b in ((-REACH, -REACH), (far, -REACH), (far, far), (-REACH, far)):
        point = [0, 0, 0]
        point[one], point[two] = a, b
        point[axis] = (offset - normal[one] * a - normal[two] * b) * normal[axis]
        out.append(point)
    return np.array(out if folded else [out[0], out[1], out[3]], dtype=float)


def draw_planes(rng, count: int, pencil: bool) -> list[tuple[tuple[int, ...], int]]:
    """Different planes of the lattice; those of a pencil have a line in common."""
    out: list[tuple[tuple[int, ...], int]] = []
    while len(out) < count:
        normal, offset = NORMALS[rng.integers(len(NORMALS))], int(rng.integers(-2, 3))
        if pencil and len(out) >= 2 and rng.random() < 0.7:
            p, q = rng.integers(-2, 3, 2)
            (n1, d1), (n2, d2) = out[:2]
            normal = tuple(int(p * a + q * b) for a, b in zip(n1, n2, strict=True))
            offset = int(p * d1 + q * d2)
            if normal < (0, 0, 0):
                normal, offset = tuple(-a for a in normal), -offset
        if normal in NORMALS and abs(offset) <= 3 and (normal, offset) not in out:
            out.append((normal, offset))
    return out


def plane_world(seed: int) -> PlaneWorld:
    """One world; the same number makes the same bytes."""
    rng = np.random.default_rng([31, seed])
    kind = KINDS[seed % len(KINDS)]
    folded = kind == "folded"
    planes = draw_planes(rng, int(rng.integers(3, 8)), kind == "pencil")
    digits = int(rng.integers(1, 4))
    shift = np.round(rng.random(3), digits)
    scale = float(rng.choice([1.0, 1.0, 1.0, 0.1, 1 / 3, 700.0]))
    if rng.random() < 0.15:
        shift = shift + np.array(UTM)
    horizons = (
        [k for k, (n, _) in enumerate(planes) if abs(n[2]) >= 1] if kind == "horizons" else []
    )
    horizons = horizons[: int(rng.integers(1, 4))]
    order = [*horizons, *(k for k in range(len(planes)) if k not in horizons)]
    surfaces = []
    for number, k in enumerate(order):
        corners = corners_of(*planes[k], folded) * scale + shift
        if rng.random() < 0.3:
            corners = corners[::-1]
        role = "horizon" if k in horizons else "fault"
        name = f"{'H' if k in horizons else 'F'}{number}"
        faces = [[0, 1, 2], [0, 2, 3]] if folded else [[0, 1, 2]]
        surfaces.append(TriSurface(name, role, corners, faces))
    if kind == "twice":
        one = surfaces[int(rng.integers(len(surfaces)))]
        twin = TriSurface("Twin", "fault", _off_by_ulps(rng, one.vertices), one.triangles)
        surfaces.append(twin)
    extent = np.array([-4.0, 4, -4, 4, -4, 4])
    box = extent * scale + np.repeat(shift, 2)
    if kind == "beside":  # walls pass close to points of the lattice, within the planes' reach
        extent = np.array([-4.0, 4, -4, 4, -4, 4]) + rng.integers(-2, 3, 6)
        box = extent * scale + np.repeat(shift, 2)
        box = _off_by_ulps(rng, box)
    contact = None
    if kind == "contact":
        contact = float(rng.integers(-2, 3) * scale + shift[2])
    return PlaneWorld(surfaces, tuple(box.tolist()), contact, folded, kind)


def _off_by_ulps(rng, values: np.ndarray) -> np.ndarray:
    """Numbers up to one unit in the last place off; 0 stays, it has no last place."""
    moved = np.nextafter(values, values + rng.choice([-1.0, 0.0, 1.0], values.shape))
    return np.where(values == 0, values, moved)


# ---------------------------------------------------------------------- what must come out
def expected(world: PlaneWorld, sources) -> dict[tuple, float]:
    """Volume of each unit by zone, sides of faults and contact interval; none is empty.

    The plane of a source is that of its first triangle; its front is the ``+`` side of a fault.
    """
    first = {s.name: s.vertices[s.triangles[0]] for s in sources if s.role != "wall"}
    of = Pieces(world.box, [point for triangle in first.values() for point in triangle])
    planes = {name: of.plane(triangle) for name, triangle in first.items()}
    horizons, faults, levels = (
        [s.name for s in sources if s.role == role] for role in ("horizon", "fault", "contact")
    )
    pieces = [(("box",), of.box)]
    if horizons:
        names = [f"above {horizons[0]}", *map("/".join, itertools.pairwise(horizons))]
        rest, pieces = of.box, []
        for name, horizon in zip(names, horizons, strict=True):
            front, back = of.split(rest, planes[horizon])
            above, rest = (front, back) if planes[horizon][0][2] > 0 else (back, front)
            pieces.append(((name,), above))
        pieces.append(((f"below {horizons[-1]}",), rest))
    cuts = [(planes[name], (name + "+", name + "-")) for name in faults]
    for plane, words in [*cuts, *((planes[name], ("above OWC", "below OWC")) for name in levels)]:
        pieces = [
            ((*key, word), part)
            for key, piece in pieces
            if piece
            for word, part in zip(words, of.split(piece, plane), strict=True)
        ]
    return {key: of.volume(piece) for key, piece in pieces if piece}


def beside_the_box(true: dict[tuple, float], faults: list[str]) -> set[str]:
    """Sides of faults that do not part the box: on a wall all units lie on one, else none does."""
    sides = {word for key in true for word in key}
    pairs = [(name + "+", name + "-") for name in faults]
    return {word for pair in pairs if not set(pair) <= sides for word in pair}


def key_of(unit) -> tuple:
    """Zone, sides of faults and contact interval."""
    return (unit.zone, *unit.fault_sides, *([unit.contact] if unit.contact else []))


# ---------------------------------------------------------------------- one world
def check(seed: int) -> str:
    """Carve a world and compare: "carved", "thin" (a unit is as thin as rounding), "refused"."""
    world = plane_world(seed)
    contacts, levels = (), []
    if world.contact is not None:
        west, east, south, north = world.box[:4]
        far = REACH * (east - west)
        corners = [[west - far, south - far], [east + 3 * far, south - far]]
        corners.append([west - far, north + 3 * far])
        level = np.column_stack([corners, np.full(3, world.contact)])
        surface = TriSurface("OWC", "contact", level, [[0, 1, 2]])
        levels, contacts = build_contacts({"OWC": surface}, world.box)
    given = [*world.surfaces, *levels, *build_walls(world.box)]
    try:
        patches = rebuild_surfaces(given)
        units = carve_units(patches, contacts=contacts)
    except RoundingError as error:
        if error.place is None or not error.surfaces:
            raise AssertionError(f"a refusal that names no place: {error}") from error
        return "refused"
    rows = np.unique(np.sort(patches.triangles, axis=1), axis=0)
    assert len(crossing_pairs(patches.local, rows)) == 0, "triangles cross"
    compare(world, patches, units)
    certificate = certify(patches, units)
    assert certificate.ok, str(certificate)
    if patches.report["moved_vertices"]:
        return "moved, thin" if units.report["thin"] else "moved"
    return "thin" if units.report["thin"] else "carved"


def compare(world: PlaneWorld, patches, units) -> None:
    """Units are those that rational arithmetic knows."""
    faults = [source.name for source in patches.sources if source.role == "fault"]
    true = expected(world, patches.sources)
    found = {key_of(unit): unit.volume for unit in units.values()}
    beside = beside_the_box(true, faults)
    true, found = (
        {tuple(word for word in key if word not in beside): v for key, v in values.items()}
        for values in (true, found)
    )
    assert len(found) == len(units), "two units have the same sides"
    w, e, s, n, b, t = world.box
    box = (e - w) * (n - s) * (t - b)
    slack = 1e-12 * box
    if world.folded:  # the plane of the first triangle is not quite that of both
        far = max(np.spacing(np.abs(source.vertices).max()) for source in patches.sources)
        move = float(far) + patches.report["largest_move"]
        slack += 9 * move * max(e - w, n - s, t - b) ** 2
        true = {k: v for k, v in true.items() if v > slack or k in found}
        found = {k: v for k, v in found.items() if v > slack or k in true}
    missing, extra = set(true) - set(found), set(found) - set(true)
    assert not missing, f"no unit {min(missing)} of {true[min(missing)]:.3g} m3"
    assert not extra, f"a unit {min(extra)} that is not there"
    for key, value in found.items():
        assert value > 0, f"{key} has {value} m3"
        off = abs(value - true[key])
        assert off <= slack, f"{key} has {value:.17g} m3, not {true[key]:.17g}"
    total = math.fsum(unit.volume for unit in units.values())
    assert abs(total - box) <= slack, f"volumes add up to {total:.17g} m3, not to {box:.17g}"


if __name__ == "__main__":
    sys.exit(count(check, most_refused=MOST_REFUSED))
