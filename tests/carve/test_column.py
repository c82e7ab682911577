"""The stratigraphic column: what each rule leaves, and what it says that it took away."""

from __future__ import annotations

import itertools
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from geosurf import Scene, build_walls, carve_units, rebuild_surfaces
from geosurf.carve import clipped
from geosurf.carve.certificate import certify
from geosurf.conventions import volume_text
from geosurf.errors import InputError
from geosurf.model import RULES, Unit, Units
from tests import laws
from tests.strategies import BOX, grid, sheet, shuffled


def plane(name, west, east, *, reach=1.0):
    """A horizon over `BOX` with one elevation along its west side and one along its east side."""
    slope = (east - west) / 4.0
    z = [west - slope * reach, east + slope * reach]
    return grid(name, [z, z], spacing=4.0 + 2 * reach, corner=(-reach, -reach))


def carve(surfaces, column=None, box=BOX):
    patches = rebuild_surfaces([*surfaces, *build_walls(box)])
    units = carve_units(patches, column)
    laws.assert_volumes_add_up(units, box)
    assert certify(patches, units).ok
    return units


# ---------------------------------------------------------------- planes that cross
# A is level at 2, B rises from 1 to 5 and crosses A at x = 1, C falls from 3 to 1 and crosses B
# at x = 4/3, A at x = 2
A, B, C = plane("A", 2, 2), plane("B", 1, 5), plane("C", 3, 1)


def clips(units):
    return {(c.horizon, c.by): c for c in units.report["clipped"]}


def test_what_is_clipped_is_told_with_place_and_amount():
    found = clips(carve([A, B, C], {"A": "erosional"}))
    assert {key: clip.rule for key, clip in found.items()} == {
        ("B", "A"): "erosional", ("C", "A"): "erosional", ("C", "B"): "conformable",
    }  # fmt: skip
    clip = found["B", "A"]
    # from x = 1 to 4, B is up to 3 m above A, and 45 degrees steep
    assert clip.area == pytest.approx(4 * 3 * math.sqrt(2), rel=1e-12)
    assert clip.volume == pytest.approx(4 * 4.5, rel=1e-12)
    assert clip.thickness == 3.0
    assert (clip.place[0], clip.place[2]) == (4.0, 3.5)
    (place,) = clip.places
    assert place == pytest.approx((2.5, 2.0, 3.5, 18.0))
    # C first ends on B, where that is lower, and what is left of it then on A: a wedge from
    # x = 4/3 to 2, below B and C and above A
    assert found["C", "B"].volume == pytest.approx(4 * (8 - 20 / 3), rel=1e-12)
    assert found["C", "A"].volume == pytest.approx(4 * (20 / 3 - 6.5), rel=1e-12)
    assert str(clip).startswith("B is clipped by A (erosional): 17 m² of it and 18 m³ in one")
    assert "up to 3 m thick at (E 4," in str(clip)


def test_what_is_clipped_is_measured_when_somebody_looks(monkeypatch):
    def refused(*_):
        raise AssertionError("nobody has looked yet")

    with monkeypatch.context() as patch:
        patch.setattr(clipped, "_measured", refused)
        scene = Scene({"A": A, "B": B, "C": C}, box=BOX, column={"B": "base"})
        assert scene.units.volume == pytest.approx(192.0)
        assert scene.warnings == ()
        lost = scene.units.report["clipped"]
        # areas of faces are those that triangles have
        areas = {rule: lost.areas(rule) for rule in RULES}
    assert any(areas.values())
    for rule, found in areas.items():
        listed = [clip.area for clip in lost if clip.rule == rule]
        assert [area for area in found if area > 0] == pytest.approx(listed, rel=1e-12)
    assert lost == tuple(lost)
    assert hash(lost) == hash(tuple(lost))
    assert pickle.loads(pickle.dumps(lost)) == lost


# ---------------------------------------------------------------------- eroded dome


# ------------------------------------------------------------------- partial horizons


# --------------------------------------------------------------------- remnants
def test_remnants_are_named_by_size_then_place_however_surfaces_are_shuffled():
    rng = np.random.default_rng(4)
    n = 9
    z = rng.integers(0, 3, (n, n)).astype(float)
    z[:, n // 2 + 1 :] = z[:, n // 2 - 1 :: -1]  # mirrored: pockets of one size
    top = grid("Top", np.full((n, n), 1.0), spacing=0.75, corner=(-1.0, -1.0))
    base = grid("Base", z, spacing=0.75, corner=(-1.0, -1.0))
    faults = [
        sheet("F2", [(1, -1, -5), (1, 5, -5), (1, 5, 9), (1, -1, 9)]),
        sheet("F10", [(-1, 2, -5), (5, 2, -5), (5, 2, 9), (-1, 2, 9)]),
    ]
    told = None
    for _ in range(3):
        mixed = [faults[i] for i in rng.permutation(2)]
        mixed = [shuffled(s, rng, reflect=False) for s in (top, base, *mixed)]
        units = carve_units(rebuild_surfaces([*mixed, *build_walls(BOX)]))
        remnants = units.remnants()
        found = [(name, unit.volume, unit.bounded_by) for name, unit in units.items()]
        told = told or (found, remnants)
        assert (found, remnants) == told
    assert len(remnants) > 5
    assert [r.volume for r in remnants] == sorted((r.volume for r in remnants), reverse=True)
    blocks = {unit.block.partition(" #")[0] for unit in units.values()}
    assert blocks >= {"F2+ F10+", "F2+ F10-", "F2- F10+", "F2- F10-"}  # 2 before 10
    for name, unit in units.items():  # ranks fall with size
        base, _, rank = name.partition(" #")
        if rank:
            first = base.removesuffix(" whole")
            before = units[first if rank == "2" else f"{base} #{int(rank) - 1}"]
            assert before.volume >= unit.volume * (1 - 1e-9)
    assert len([r.volume for r in units.remnants(min_volume=1.0)]) >= len(remnants)
    assert len(units) == len(found)  # the threshold is for the list only
    assert str(remnants[0]).startswith(
        f"{remnants[0].name}: {volume_text(remnants[0].volume)} at (E "
    )


# ---------------------------------------------------------- whole numbers, by columns
@st.composite
def columns_of_grids(draw):
    """Up to four horizons of 2 x 2 cells over `BOX`, with whole heights and random rules."""
    n = draw(st.integers(2, 4))
    heights = st.lists(st.integers(0, 3), min_size=9, max_size=9)
    z = [np.array(draw(heights), dtype=float).reshape(3, 3) for _ in range(n)]
    rising = draw(st.lists(st.booleans(), min_size=n, max_size=n))
    rules = draw(st.lists(st.sampled_from(RULES), min_size=n, max_size=n))
    return z, rising, rules


FLAT = np.ones((3, 3))
TENT = np.array([[0.0, 0, 0], [0, 3, 0], [0, 0, 0]])


@settings(max_examples=8)
@example(([FLAT, TENT, FLAT], [True, False, True], ["base", "discontinuous", "base"]))
@example(([TENT, FLAT, TENT], [True, True, False], ["erosional", "base", "conformable"]))
@given(columns_of_grids())
def test_zones_have_the_volumes_of_their_columns(model):
    z, rising, rules = model
    names = [f"H{k + 1}" for k in range(len(z))]
    surfaces = [
        grid(name, heights, spacing=2.0, rising=diagonal)
        for name, heights, diagonal in zip(names, z, rising, strict=True)
    ]
    units = carve(surfaces, dict(zip(names, rules, strict=True)))
    found = laws.volume_by_zone(units)
    zones = [f"above {names[0]}", *map("/".join, itertools.pairwise(names)), f"below {names[-1]}"]
    tops = [Fraction(16 * 8), *exact_integrals(z, rising, rules), Fraction(16 * -4)]
    for zone, upper, lower in zip(zones, tops[:-1], tops[1:], strict=True):
        assert found.get(zone, 0.0) == pytest.approx(float(upper - lower), rel=1e-12, abs=1e-10)
        assert (zone in found) == (upper > lower)
    told = {(c.horizon, c.by): c.volume for c in units.report["clipped"]}
    assert all(volume > 0 for volume in told.values())
    for k, name in enumerate(names):  # what is told of a horizon is what it lost
        lost = exact_integrals(z[k:], rising[k:], ["conformable"] * (len(z) - k))[0]
        lost -= tops[k + 1]
        net = sum(v * (-1 if c.rule == "base" else 1) for c in units.report["clipped"]
                  for v in [c.volume] if c.horizon == name)  # fmt: skip
        assert net == pytest.approx(float(lost), abs=1e-9)


def exact_integrals(z, rising, rules):
    """Integrals over the map of what the horizons become [m3], in rational numbers.

    Each cell is cut by both diagonals, each quarter by the lines where two horizons meet: in
    the pieces, horizons have one order, so that what they become is linear.
    """
    total = [Fraction(0)] * len(z)
    for i, j in itertools.product(range(2), repeat=2):
        corners = [(j, i), (j + 1, i), (j + 1, i + 1), (j, i + 1)]
        heights = [[Fraction(float(h[y, x])) for x, y in corners] for h in z]
        ring = [
            (Fraction(2 * x), Fraction(2 * y), *(h[k] for h in heights))
            for k, (x, y) in enumerate(corners)
        ]
        middle = tuple(
            (a + b) / 2
            for a, b in zip(ring[0], ring[2], strict=True)
        )[:2] + tuple(
            (h[0] + h[2]) / 2 if up else (h[1] + h[3]) / 2
            for h, up in zip(heights, rising, strict=True)
        )  # fmt: skip
        for k in range(4):
            pieces = [[middle, ring[k], ring[(k + 1) % 4]]]
            for a, b in itertools.combinations(range(2, 2 + len(z)), 2):
                pieces = [part for piece in pieces for part in halves(piece, a, b)]
            for piece in pieces:
                for q, r in itertools.pairwise(piece[1:]):
                    for k_, part in enumerate(prism(rules, piece[0], q, r)):
                        total[k_] += part
    return total


def halves(piece, a, b):
    """The parts of a convex polygon where value `a` is not above `b`, and not below."""
    parts = []
    for sign in (1, -1):
        kept = []
        for p, q in zip(piece, piece[1:] + piece[:1], strict=True):
            one, two = sign * (p[a] - p[b]), sign * (q[a] - q[b])
            if one <= 0:
                kept.append(p)
            if one * two < 0:
                t = one / (one - two)
                kept.append(tuple(u + t * (v - u) for u, v in zip(p, q, strict=True)))
        if len(kept) >= 3:
            parts.append(kept)
        if all(p[a] == p[b] for p in piece):
            break
    return parts


def prism(rules, *triangle):
    """Integrals over a triangle in which the horizons do not cross."""
    (ax, ay, *_), (bx, by, *_), (cx, cy, *_) = triangle
    area = abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2
    tops = [clipped_heights(corner[2:], rules) for corner in triangle]
    return [area * sum(column) / 3 for column in zip(*tops, strict=True)]


def clipped_heights(z, rules):
    """Elevations of horizons, youngest first, in one place, as the column leaves them.

    The definition, told in time: each horizon is laid on top of what is there.
    """
    z = list(z)
    for k in range(len(z) - 1, -1, -1):
        erodes = rules[k] in ("erosional", "discontinuous")
        if not erodes:
            for j in range(k + 1, len(z)):
                yields = rules[k] == "yielding" != rules[j]
                if yields or rules[j] in ("base", "discontinuous"):
                    z[k] = max(z[k], z[j])
        for j in range(k + 1, len(z)):
            z[j] = min(z[j], z[k])
    return z


# ------------------------------------------------------------------------ the words


def test_units_are_found_by_zone_block_and_contact():
    shell = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    words = ("Top/Base F1+", "Top/Base", 1, "F1+", shell, np.zeros(3), faces, np.zeros(4, int))
    plain = Unit(*words, ("Top",), 1 / 6, 2.0)
    split = Unit("Top/Base F1+ above OWC", *words[1:], ("Top",), 1 / 6, 2.0, "above OWC")
    assert Units([plain], (0, 1, 0, 1, 0, 1))["Top/Base", "F1+"] is plain
    units = Units([split], (0, 1, 0, 1, 0, 1))
    assert units["Top/Base", "F1+", "above OWC"] is split
    with pytest.raises(KeyError, match="no unit"):
        units["Top/Base", "F1+"]
    again = Unit(*words, ("Top",), 1 / 6, 2.0)
    with pytest.raises(InputError, match=r"two units .* 'Top/Base F1\+'\. Give"):
        Units([plain, again], (0, 1, 0, 1, 0, 1))
