"""Faults that end at faults: the right part stays, shares vertices, and parts add up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geosurf import TriSurface, rebuild_surfaces, truncate_faults
from geosurf.errors import GeometryError, InputError, SurfaceError
from geosurf.faults.distance import closest_approach
from geosurf.faults.rules import read_extend, read_truncations
from tests.faults.worlds import across, antithetic, bytes_of, dipping, turned, upright, vector_area
from tests.messages import refused
from tests.strategies import sheet, shuffled


def cut(faults, truncations):
    return truncate_faults(rebuild_surfaces(faults), truncations)


def above_main(surface):
    """Sign of x + z - 8 at all vertices: on which side of `dipping` they lie."""
    return surface.vertices[:, 0] + surface.vertices[:, 2] - 8.0


@pytest.mark.parametrize(
    ("other", "keep", "sign"),
    [
        (antithetic(), "hanging wall", 1),  # Y
        (antithetic(), "footwall", -1),  # Y, upside down
        (upright(6), "footwall", -1),  # lambda
        (upright(6), "hanging wall", 1),
        (across(4, "F2"), "hanging wall", 1),
        (antithetic(n=(3, 4)), "+", 1),
        (antithetic(n=(5, 2)), "-", -1),
    ],
)
@pytest.mark.parametrize("n", [(1, 1), (4, 3)])
def test_y_and_lambda_keep_the_part_that_was_asked_for(other, keep, sign, n):
    made = cut([dipping(n=n), other], {"F2": ("F1", keep)})
    kept = made.surfaces["F2"]
    assert (sign * above_main(kept)).min() == 0.0
    assert (sign * above_main(kept)).max() > 0.0
    # the contact: vertices of both, the ends of edges of both
    line = {tuple(p) for p in kept.vertices[above_main(kept) == 0.0].tolist()}
    assert line <= {tuple(p) for p in made.surfaces["F1"].vertices.tolist()}
    (told,) = made.truncations
    both = [np.array(list(line))]
    longest = np.linalg.norm(np.ptp(both[0], axis=0))
    assert told.length == pytest.approx(longest, rel=1e-12)
    assert told.side == ("+" if sign > 0 else "-")


def test_parts_add_up_exactly_on_a_lattice():
    whole = antithetic(n=(5, 1))
    up, down = (cut([dipping(), whole], {"F2": ("F1", side)}) for side in ("+", "-"))
    parts = [vector_area(made.surfaces["F2"]) for made in (up, down)]
    assert [a + b for a, b in zip(*parts, strict=True)] == vector_area(whole)
    kept, dropped = up.truncations[0].kept_area, up.truncations[0].dropped_area
    assert kept == pytest.approx(50 * math.sqrt(2), rel=1e-15)
    assert dropped == pytest.approx(50 * math.sqrt(2), rel=1e-15)
    assert down.truncations[0].kept_area == dropped
    assert vector_area(up.surfaces["F1"]) == vector_area(dipping())


@pytest.mark.parametrize("keep", ["hanging wall", "footwall"])
def test_words_do_not_depend_on_how_triangles_are_turned(keep):
    expected = cut([dipping(), antithetic()], {"F2": ("F1", keep)})
    for main, other in ((turned(dipping()), antithetic()), (dipping(), turned(antithetic()))):
        made = cut([main, other], {"F2": ("F1", keep)})
        assert made.surfaces["F2"].vertices.tobytes() == expected.surfaces["F2"].vertices.tobytes()
        assert made.truncations[0].kept_area == expected.truncations[0].kept_area
    side = cut([turned(dipping()), antithetic()], {"F2": ("F1", keep)}).truncations[0].side
    assert side != expected.truncations[0].side


def test_the_order_of_faults_and_triangles_does_not_matter(rng):
    faults = [dipping(n=(3, 2)), antithetic(n=(4, 3)), across(4)]
    rules = {"F3": (("F1", "hanging wall"), ("F2", "hanging wall")), "F2": ("F1", "hanging wall")}
    first = cut(faults, rules)
    for _ in range(3):
        mixed = [shuffled(faults[i], rng, reflect=False) for i in rng.permutation(3)]
        again = cut(mixed, dict(reversed(rules.items())))
        assert again.truncations == first.truncations
        for name, surface in first.surfaces.items():
            assert bytes_of(again.surfaces[name]) == bytes_of(surface)


def test_a_fault_ends_at_what_is_left_of_its_main_fault():
    # F3 ends at F2, which itself ends at F1: below F1 nothing of F2 is left to end at
    faults = [dipping(), antithetic(), sheet("F3", [(4, 1, 5), (8, 1, 5), (8, 7, 5), (4, 7, 5)])]
    made = cut(faults, {"F2": ("F1", "+"), "F3": ("F2", "hanging wall")})
    kept = made.surfaces["F3"].vertices
    assert (kept[:, 0] <= kept[:, 2]).all()  # west of x = z
    assert made.truncations[1].kept_area == pytest.approx(6.0)
    with pytest.raises(GeometryError, match=r"'F3' ends .* m short of 'F2'"):
        cut([*faults[:2], across(4, west=1, east=2)], {"F2": ("F1", "+"), "F3": ("F2", "+")})


def test_a_bent_main_fault_is_told_by_the_angle_between_its_flanks():
    """F2 leaves the ridge of a roof between its flanks, along its edge: no plane tells the side."""
    roof = TriSurface(
        "F1", "fault",
        [[0, -4, 0], [0, 4, 0], [4, -4, -4], [4, 4, -4], [-4, -4, -4], [-4, 4, -4]],
        [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4]],
    )  # fmt: skip
    inner = sheet("F2", [(0, -4, 4), (0, 4, 4), (0, 4, -4), (0, -4, -4)], (1, 2))
    for keep, low, high in (("hanging wall", 0, 4), ("footwall", -4, 0)):
        made = cut([roof, inner], {"F2": ("F1", keep)})
        assert made.surfaces["F2"].bounds[4:] == (low, high)


def test_pieces_that_do_not_meet_the_main_fault_stay_and_are_told():
    far = sheet("F2", [(1, 1, 0), (2, 1, 0), (2, 2, 0), (1, 2, 0)])
    two = TriSurface(
        "F2", "fault",
        np.concatenate([antithetic().vertices, far.vertices]),
        np.concatenate([antithetic().triangles, far.triangles + 4]),
    )  # fmt: skip
    (told,) = cut([dipping(), two], {"F2": ("F1", "hanging wall")}).truncations
    assert told.apart_area == 1.0


def test_a_vertical_fault_has_no_hanging_wall_but_a_right_and_a_left():
    faults = [upright(4, "F1"), across(4, "F2")]
    with pytest.raises(InputError, match=r"'F1' is vertical, so that it has no hanging wall"):
        cut(faults, {"F2": ("F1", "hanging wall")})
    for main in (faults[0], turned(faults[0])):
        right = cut([main, faults[1]], {"F2": ("F1", "right")}).surfaces["F2"]
        assert right.bounds[:2] == (4.0, 9.0)
    north = cut(faults, {"F1": ("F2", "right")}).surfaces["F1"]
    assert north.bounds[2:4] == (4.0, 9.0)


def test_main_faults_without_two_sides_are_refused():
    mixed = dipping()
    t = mixed.triangles.copy()
    t[0] = t[0, [0, 2, 1]]
    mixed = TriSurface("F1", "fault", mixed.vertices, t)
    diagonal = sheet("F2", [(-1, -1, -1), (9, 9, -1), (9, 9, 9), (-1, -1, 9)])
    with pytest.raises(SurfaceError, match=r"'F1': its triangles do not agree about their front"):
        cut([mixed, diagonal], {"F2": ("F1", "+")})
    fin = TriSurface(
        "F1", "fault",
        np.concatenate([dipping().vertices, [[9, 9, 9]]]),
        np.concatenate([dipping().triangles, [[0, 3, 4]]]),
    )  # fmt: skip
    ridge = TriSurface("F2", "fault", [[-1, -1, 9], [9, 9, -1], [-1, 9, -1]], [[0, 1, 2]])
    refused(GeometryError, r"'F1' has 3 sheets at", cut, [fin, ridge], {"F2": ("F1", "+")})


def test_rules_that_cannot_be_are_refused():
    circle = {"F1": ("F2", "+"), "F2": ("F3", "+"), "F3": ("F1", "-"), "F4": ("F1", "-")}
    with pytest.raises(
        InputError,
        match=r"form a circle: F1 ends at F2, F2 ends at F3, F3 ends at F1. Leave out one",
    ):
        read_truncations(circle)
    refused(InputError, r"form a circle: F1 ends at F1", read_truncations, {"F1": ("F1", "+")})
    with pytest.raises(
        InputError, match=r"'F9', which is not a fault. The faults are \['F1', 'F2'\]"
    ):
        read_truncations({"F2": ("F9", "+")}, ["F1", "F2"])
    with pytest.raises(InputError, match=r"keep 'hangingwall' of F1.*Did you mean 'hanging wall'"):
        read_truncations({"F2": ("F1", "hangingwall")})
    with pytest.raises(InputError, match=r"'F1' is not a rule for 'F2'\. Give truncations="):
        read_truncations({"F2": "F1"})
    with pytest.raises(InputError, match=r"third word for F2 is 'yes'; it is True"):
        read_truncations({"F2": ("F1", "+", "yes")})
    with pytest.raises(InputError, match=r"F2 ends at F1 twice. Keep one"):
        read_truncations({"F2": (("F1", "+"), ("F1", "-"))})
    refused(InputError, r"truncations is a list, not a mapping", read_truncations, ["F1"])
    refused(InputError, r"extend names 'F9', which is not a fault", read_extend, ["F9"], ["F1"])
    for wrong, words in (
        (5, r"extend is 5; give True"),
        ({"F1": None}, r"of 'F1' is None; give any"),
    ):
        refused(InputError, words, read_extend, wrong, ["F1"])
    assert read_extend(None, ["F1"]) == {}
    refused(InputError, r"has side 'top'; sides are", read_extend, {"F1": "top"}, ["F1"])
    assert read_extend(True, ["F1", "F2"]) == dict.fromkeys(
        ("F1", "F2"), ("start", "end", "up", "down")
    )
    assert read_extend({"F1": "up"}, ["F1"]) == {"F1": ("up",)}


corner = st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(0, 4))


@given(st.lists(corner, min_size=4, max_size=4, unique=True), st.integers(1, 3), st.booleans())
def test_law_every_kept_triangle_is_on_its_side_of_a_plane_main_fault(points, at, east):
    """Whole numbers, any two triangles across a plane that is beyond them all."""
    p = np.array(points, dtype=float)
    t = np.array([[0, 1, 2], [0, 2, 3]])
    normals = np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]])
    if (normals == 0).all(axis=1).any() or np.dot(*normals) <= 0:
        return
    other = TriSurface("F2", "fault", p, t)
    main = sheet("F1", [(at, -9, -9), (at, 9, -9), (at, 9, 9), (at, -9, 9)], (2, 2))
    beyond = p[:, 0] - at
    keep = 1 if east else -1
    try:
        made = cut([main, other], {"F2": ("F1", "right" if east else "left")})
    except GeometryError:
        assert not ((beyond < 0).any() and (beyond > 0).any() and keep * beyond.max() > 0)
        return
    kept = made.surfaces["F2"].vertices[made.surfaces["F2"].triangles]
    assert (keep * (kept[:, :, 0] - at) >= 0).all()
    (told,) = made.truncations
    area = 0.5 * np.linalg.norm(normals, axis=1).sum()
    assert told.kept_area + told.dropped_area == pytest.approx(area, rel=1e-12)


@given(st.lists(corner, min_size=6, max_size=6, unique=True))
def test_law_closest_approach_is_the_least_of_many_samples(points):
    p = np.array(points, dtype=float)
    p[3:] += (0, 0, 3)
    one, two = np.array([[0, 1, 2]]), np.array([[3, 4, 5]])
    for t in (one, two):
        if not np.cross(p[t[0, 1]] - p[t[0, 0]], p[t[0, 2]] - p[t[0, 0]]).any():
            return
    found = closest_approach(p, one, two)
    n = 12
    u, v = (k.ravel() / n for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1)))
    u, v = u[u + v <= 1], v[u + v <= 1]
    a, b = (p[t[0, 0]] + u[:, None] * (p[t[0, 1]] - p[t[0, 0]])
            + v[:, None] * (p[t[0, 2]] - p[t[0, 0]]) for t in (one, two))  # fmt: skip
    sampled = np.linalg.norm(a[:, None] - b[None], axis=2).min()
    # samples are at most one step of either triangle away from the closest places
    assert found.distance <= sampled + 1e-9
    assert np.linalg.norm(found.at - found.there) == pytest.approx(found.distance, abs=1e-12)
    if sampled > 2.0:
        assert found.distance >= sampled - 2 * 4 * math.sqrt(3) / n
