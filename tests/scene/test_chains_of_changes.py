"""Scenes made from scenes, change by change: each is the scene made afresh, whatever was asked."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, GeosurfError, InputError, InvariantError
from geosurf.model import Sheet
from tests import laws
from tests.strategies import BOX, grid, sheet, soup

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

AOI = [(0.5, 0.5), (3.5, 0.5), (3.5, 3.0), (2.0, 3.5), (0.5, 3.0)]


def level(z, slope=0.0):
    heights = z + slope * np.add.outer(np.arange(4.0), np.zeros(4))
    return grid("H", heights, spacing=2.0, corner=(-1.0, -1.0))


def upright(x, low=-5):
    return sheet("F", [(x, -1, low), (x, 5, low), (x, 5, 9), (x, -1, 9)])


HORIZONS = (level(3), level(1), level(1, 0.5), level(2, -0.25), None)
FAULTS = (upright(1), upright(2), upright(2, low=2), None)
CHOICES = {
    "horizons": [{n: one} for n in ("Top", "Base", "Deep") for one in HORIZONS],
    "faults": [{n: one} for n in ("F1", "F2") for one in FAULTS],
    "box": [BOX, (0, 3.5, 0, 4, -4, 8), (0, 4, 0, 4, -3, 5)],
    "column": [{}, {"Top": "erosional"}, {"Base": "base"}, {"Top": "discontinuous"}],
    "contacts": [{}, {"OWC": 0.5}, {"OWC": {"F1+": 0.5}}, {"OWC": 2.25}],
    "aoi": [None, AOI],
    "extend": [(), ["F2"], {"F1": "down"}],
    "self_intersections": [True, False],
}


def start():
    return {
        "horizons": {"Top": level(2, -0.25), "Base": level(1, 0.5)},
        "faults": {"F1": upright(1)},
        "box": BOX, "column": {}, "contacts": {}, "aoi": None, "extend": (),
        "self_intersections": False,
    }  # fmt: skip


def changed(given, key, value):
    """The inputs after a change, by the words of `Scene.replace`; an error where it refuses."""
    after = dict(given)
    if key not in ("horizons", "faults"):
        after[key] = value
        return after
    if any(one is None and name not in given[key] for name, one in value.items()):
        raise InputError("nothing to remove")
    after[key] = {n: one for n, one in {**given[key], **value}.items() if one is not None}
    after["column"] = {n: r for n, r in given["column"].items() if n in after["horizons"]}
    extend = given["extend"]
    keep = {n for n in (extend if extend else ()) if n in after["faults"]}
    after["extend"] = {n: extend[n] for n in keep} if isinstance(extend, dict) else sorted(keep)
    return after


def made(given):
    return gs.Scene(**given)


def result(make, *args):
    """Volumes, both ways, bytes of the patches and curves; or the words of the refusal."""
    try:
        scene = make(*args)
        volumes = {name: (u.volume, u.zone, u.block) for name, u in scene.units.items()}
        at_levels = scene.volumes.values.tobytes()
        patches = [getattr(scene.patches, name).tobytes() for name in ("local", "triangles")]
        return volumes, at_levels, patches, laws.curve_bytes(scene.curves), scene.box, scene.column
    except InvariantError:
        raise
    except GeosurfError as error:
        return type(error), str(error)


@pytest.mark.parametrize("seed", range(4))
def test_a_chain_of_replacements_is_the_scene_made_afresh(seed):
    """After each change; every third one goes back to an earlier scene of the family."""
    rng = np.random.default_rng([81, seed])
    family = [(start(), made(start()))]
    for step in range(14):
        inputs, scene = family[rng.integers(len(family)) if step % 3 == 2 else -1]
        key = str(rng.choice(list(CHOICES)))
        value = CHOICES[key][rng.integers(len(CHOICES[key]))]
        try:
            after = changed(inputs, key, value)
            made(after)
        except InputError:
            with pytest.raises(InputError):
                scene.replace(**{key: value})
            continue
        twin = scene.replace(**{key: value})
        assert result(lambda one: one, twin) == result(made, after), (key, value)
        family.append((after, twin))


def busy():
    """Horizons that cross, a fault that ends inside, is extended, and one that crosses itself."""
    crossed = np.array([(3, 0.5, 0), (3, 3, 0), (3, 2, 5)], dtype=float)
    turned = crossed + np.array([(0.5, 0, 0), (-0.5, 0, 0), (-0.5, 0, 0)])
    faults = {"F1": upright(2, low=2), "F2": upright(1), "F3": soup("F3", [crossed, turned])}
    return start() | {"faults": faults, "extend": {"F1": "down"}, "self_intersections": True}


@pytest.mark.parametrize(
    "key", ["box", "column", "contacts", "aoi", "extend", "self_intersections"]
)
def test_what_is_remembered_knows_each_input(key):
    """Scenes of one family that differ in one input only, in turn; they do differ."""
    family, results = made(busy()), []
    for value in CHOICES[key]:
        results.append(result(lambda one: one, family.replace(**{key: value})))
        assert results[-1] == result(made, busy() | {key: value}), value
        assert key == "self_intersections" or isinstance(results[-1][0], dict), results[-1]
    assert any(one != results[0] for one in results[1:])


def test_a_body_that_crosses_itself_and_was_not_split_is_refused_with_the_remedy():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    faces = corners[[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]]
    both = soup(
        "F3", np.concatenate([np.add(faces, at) for at in ((1, 1, -3), (1.25, 1.125, -2.875))])
    )
    inputs = start() | {"faults": {"F3": both}}
    with pytest.raises(GeometryError, match=r"crosses itself.*self_intersections=True") as caught:
        made(inputs).units  # noqa: B018
    assert caught.value.surfaces == ("F3",)
    split = made(inputs | {"self_intersections": True})
    assert split.check().ok
    with pytest.raises(GeometryError, match="crosses itself"):  # what is remembered is another
        split.replace(self_intersections=False).units  # noqa: B018


def test_a_sheet_is_not_remembered_with_other_faults():
    """Its fault was exchanged, and the sheet that ends on the old one came from memory."""
    one, two = upright(1).renamed("F1"), upright(2).renamed("F1")
    x, none = np.array([-1.0, 5.0]), np.empty((0, 3))
    torn = Sheet(
        "Top", gs.Lattice(x, x, np.full((2, 2), 3.0)), none[:, 0].astype(int), none.astype(int),
        none, none[:, 0] > 0, (gs.triangulate_fault(one),), {}, None,
    )  # fmt: skip
    scene = gs.Scene({"Top": torn}, {"F1": one}, BOX)
    assert scene.surface("Top").n_triangle == 2
    with pytest.raises(InputError, match="torn at fault 'F1', which is another surface here"):
        scene.replace(faults={"F1": two}).surface("Top")
    with pytest.raises(InputError, match="torn at fault 'F1', which is not in the scene"):
        scene.replace(faults={"F1": None}).surface("Top")
    assert scene.replace(faults={"F1": one}).surface("Top") is scene.surface("Top")
