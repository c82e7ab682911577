"""Faults that end at horizons: nothing of them lies beyond, and the rest is as without a rule."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import GeometryError, InputError
from geosurf.synthetic import torn
from tests.faults.worlds import BOX, across, dipping, upright
from tests.messages import refused

FAR = (-4, 12)  # corners beyond the box: planes through whole numbers meet its walls exactly


def level(name, z, role="horizon"):
    """A surface over the whole box, from the elevation of its four corners, or one for all."""
    z = np.broadcast_to(z, 4)
    west, east = FAR
    corners = [(west, west), (east, west), (east, east), (west, east)]
    vertices = [(*xy, up) for xy, up in zip(corners, z.tolist(), strict=True)]
    return gs.TriSurface(name, role, vertices, [[0, 1, 2], [0, 2, 3]])


HORIZONS = {"Top": level("Top", 7), "U": level("U", 4), "Base": level("Base", 1)}
HALF = gs.TriSurface("U", "horizon", level("U", 4).vertices, [[0, 1, 2]])


def scene(truncations=None, horizons=HORIZONS, faults=None, box=BOX, **more):
    faults = {"F2": upright(3)} if faults is None else faults
    return gs.Scene(horizons, faults, box, truncations=truncations, **more)


def flipped(surface):
    """The same surface upside down, in the box of `BOX`."""
    vertices = surface.vertices * (1, 1, -1) + (0, 0, 8)
    return gs.TriSurface(surface.name, surface.role, vertices, surface.triangles[:, ::-1])


def sizes(some):
    """Volumes by zone, from the smallest."""
    found = {}
    for unit in some.units.values():
        found.setdefault(unit.zone, []).append(unit.volume)
    return {zone: sorted(volumes) for zone, volumes in found.items()}


def sizes_or_error(some):
    try:
        return sizes(some)
    except GeometryError as error:
        return str(error)


def area(surface):
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


QUADS = st.lists(
    st.tuples(st.integers(-2, 10), st.integers(-2, 10), st.integers(-1, 9)),
    min_size=4, max_size=4, unique=True,
).map(np.array)  # fmt: skip


def is_fault(corners):
    """Whether four corners are two triangles with an area that do not fold onto each other."""
    normals = [
        np.cross(corners[i] - corners[0], corners[j] - corners[0]) for i, j in [(1, 2), (2, 3)]
    ]
    return all(n.any() for n in normals) and normals[0] @ normals[1] > 0


@settings(max_examples=20)
@given(st.lists(st.integers(2, 6), min_size=4, max_size=4), QUADS.filter(is_fault))
@example([4, 4, 4, 4], np.array([(-2, 4, 4), (6, 4, 4), (6, 9, 4), (3, 9, 9)]))  # partly in U
@example([4, 4, 4, 4], np.array([(3, -2, -1), (3, 9, -1), (3, 9, 4), (3, -2, 4)]))  # ends on it
def test_each_side_is_as_with_a_whole_fault_or_without(heights, corners):
    fault = gs.TriSurface("F2", "fault", corners.astype(float), [[0, 1, 2], [0, 2, 3]])
    horizons = {**HORIZONS, "U": level("U", heights)}
    whole = scene(horizons=horizons, faults={"F2": fault})
    without = scene(horizons=horizons, faults={})
    for keep, beyond in (("below", ("above Top", "Top/U")), ("above", ("U/Base", "below Base"))):
        made = scene({"F2": ("U", keep)}, horizons, {"F2": fault})
        found = sizes_or_error(made)
        if isinstance(found, str):
            assert re.search("has no part|short of horizon|nothing of fault 'F2'", found), found
            continue
        for zone, volumes in found.items():
            model = without if zone in beyond else whole
            assert volumes == pytest.approx(sizes(model)[zone], rel=1e-12)
        assert made.check().ok

        # parts add up; nothing of the fault bounds a unit beyond the horizon
        (end,) = made.fault_actions
        assert end.kept_area + end.dropped_area == pytest.approx(area(fault), rel=1e-12)
        assert end.kept_area == pytest.approx(area(made.surface("F2")), rel=1e-12)
        row = made.patches.names.index("F2")
        for unit in made.units.values():
            if unit.zone in beyond:
                assert not (unit.surface_of_triangle == row).any()
                assert "F2" not in unit.block


@pytest.mark.parametrize("heights", [4, (2, 6, 5, 3)])
def test_a_detachment_is_an_unconformity_upside_down(heights):
    horizons = {**HORIZONS, "U": level("U", heights)}
    faults = {"F2": dipping("F2"), "F3": across(4)}
    upper = scene({"F2": ("U", "below")}, horizons, faults)
    other = {name: flipped(one) for name, one in reversed(horizons.items())}
    lower = scene({"F2": ("U", "above")}, other, {k: flipped(v) for k, v in faults.items()})
    volumes = [sorted(unit.volume for unit in one.units.values()) for one in (upper, lower)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-13)
    assert flipped(lower.surface("F2")).bounds == pytest.approx(upper.surface("F2").bounds)


def test_a_short_fault_is_extended_to_the_horizon():
    short = {"F2": upright(3, "F2")}
    short["F2"] = gs.TriSurface(
        "F2", "fault", short["F2"].vertices * (1, 1, 0.3), short["F2"].triangles
    )
    with pytest.raises(GeometryError, match=r"'F2' ends 1.3 m short of horizon 'U'.* True\)"):
        _ = scene({"F2": ("U", "below")}, faults=short).units
    made = scene({"F2": ("U", "below", True)}, faults=short)
    assert made.surface("F2").bounds[5] == 4
    assert [type(a).__name__ for a in made.fault_actions] == ["Extension", "Truncation"]
    longer, cut = map(str, made.fault_actions)
    assert longer.startswith("F2 (up) was extended by ")
    assert " m until the model box: " in longer
    assert "of it removed" not in cut
    assert cut.endswith("below it kept")


@pytest.mark.parametrize(
    ("truncations", "more", "words"),
    [
        ({"F2": ("U", "below")}, {"horizons": {**HORIZONS, "U": HALF}},
         r"'F2' cannot end at horizon 'U', which does not cover all of it: .*at \(E.*extend"),
        ({"F2": ("U", "below")}, {"faults": {"F2": level("F2", 6, "fault")}},
         r"'F2' has no part below 'U': nothing would be left of it"),
        ({"F2": ("U", "below")}, {"faults": {"F2": upright(30)}},
         r"nothing of fault 'F2' lies in the model"),
        ({"F2": ("U", "footwall")}, {}, r"horizon 'U' and keeps 'footwall'.*'below' or 'above'"),
        ({"F2": ("U", "bellow")}, {}, r"keep 'bellow' of U.*Did you mean 'below'"),
        ({"U": ("F2", "below")}, {}, r"'U', which is a horizon and cannot end at 'F2'"),
        ({"F2": ("Uu", "below")}, {}, r"'Uu', which is not a fault or horizon.*mean 'U'"),
        ({"F2": (("U", "below"), ("U", "above"))}, {}, r"F2 ends at U twice"),
        ({"F2": ("F3", "above")}, {"faults": {"F2": upright(3), "F3": across(4)}},
         r"'F3' is vertical, so that nothing lies above it"),
        ({"F2": ("U", "below")}, {"tolerance": 1.0}, r"tolerance=1 cannot be combined.*'F2'"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_plain_sentence(truncations, more, words):
    with warnings.catch_warnings(action="ignore"):  # a fault outside is also warned of
        refused((GeometryError, InputError), words, lambda: scene(truncations, **more).patches)


# ---- torn horizons ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def field():
    """A fault that dies inside, a horizon with throw, and flat ones above and below it."""
    world = torn("normal", n=31)
    top = world.horizons["Top"]
    flat = {
        "Sea": float(top.max()) + 80, "U": float(top.max()) + 40, "D": float(top.min()) - 150,
    }  # fmt: skip
    flat = {name: (0 * top + z).assign_attrs(top.attrs) for name, z in flat.items()}
    box = (*world.box[:4], float(top.min()) - 250, float(top.max()) + 200)
    return {"Sea": flat["Sea"], "U": flat["U"], "Top": top, "D": flat["D"]}, world.faults, box


def test_only_horizons_that_the_fault_reaches_are_torn(field):
    horizons, faults, box = field
    rules = {"F1": (("U", "below", True), ("D", "above", True))}
    made = gs.Scene(horizons, faults, box, truncations=rules, tear=True)
    assert {name: list(one.cuts) for name, one in made.sheets.items()} == {
        "Sea": [], "U": [], "Top": ["F1"], "D": [],
    }  # fmt: skip
    assert made.check().ok
    base = [float(horizons[name].mean()) for name in ("U", "D")]
    low, high = made.surface("F1").bounds[4:]
    assert (low, high) == (pytest.approx(base[1], abs=1e-9), pytest.approx(base[0], abs=1e-9))
    size = (box[1] - box[0]) * (box[3] - box[2])
    assert made.units["Sea/U"].volume == pytest.approx(40 * size, rel=1e-12)
    assert made.throw("Top", "F1").throw.max() > 10

    # a torn horizon cannot be given where the fault does not reach it
    sheets = {"Top": made.sheets["Top"], "D": horizons["D"]}
    with pytest.raises(InputError, match=r"'Top' is torn at 'F1', and truncations keep only what"):
        gs.Scene(sheets, faults, box, truncations={"F1": ("D", "below")})
