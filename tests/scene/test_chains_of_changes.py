"""Scenes made from scenes are those made afresh: change by change, moved surfaces, any threads."""

from __future__ import annotations

import sys
from functools import partial

import numpy as np
import pytest

import geosurf as gs
from geosurf.arrangement import arrange, gather, search
from geosurf.arrangement.threads import map_threads
from geosurf.carve import cells, measures
from geosurf.errors import GeometryError, GeosurfError, InputError, InvariantError
from geosurf.model import Lattice, Sheet
from geosurf.rebuild import assemble, repair
from tests import laws
from tests.strategies import BOX, grid, sheet, soup, upright

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

ARRAYS = ("x", "triangles", "surface", "key", "twin", "ring", "link", "patch")
AOI = [(0.5, 0.5), (3.5, 0.5), (3.5, 3.0), (2.0, 3.5), (0.5, 3.0)]


def level(z, slope=0.0):
    heights = z + slope * np.add.outer(np.arange(4.0), np.zeros(4))
    return grid("H", heights, spacing=2.0, corner=(-1.0, -1.0))


HORIZONS = (level(3), level(1), level(1, 0.5), level(2, -0.25), None)
FAULTS = (upright("F", 1), upright("F", 2), upright("F", 2, z=(2, 9)), None)
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
        "faults": {"F1": upright("F", 1)},
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


def result(scene):
    """Volumes, both ways, bytes of the pieces and curves; or the words of the refusal."""
    try:
        volumes = {name: (u.volume, u.zone, u.block) for name, u in scene.units.items()}
        patches = scene.patches
        pieces = [getattr(patches.pieces, name).tobytes() for name in ARRAYS]
        return (
            volumes, scene.volumes.values.tobytes(), pieces, patches.curve_edges.tobytes(),
            str(patches.report), laws.curve_bytes(scene.curves), scene.box, scene.column,
        )  # fmt: skip
    except InvariantError:
        raise
    except GeosurfError as error:
        return type(error), str(error)


@pytest.mark.parametrize("seed", range(4))
def test_a_chain_of_replacements_is_the_scene_made_afresh(seed):
    """After each change; every third one goes back to an earlier scene of the family."""
    rng = np.random.default_rng([81, seed])
    family = [(start(), gs.Scene(**start()))]
    for step in range(14):
        inputs, scene = family[rng.integers(len(family)) if step % 3 == 2 else -1]
        key = str(rng.choice(list(CHOICES)))
        value = CHOICES[key][rng.integers(len(CHOICES[key]))]
        try:
            after = changed(inputs, key, value)
            gs.Scene(**after)
        except InputError:
            with pytest.raises(InputError):
                scene.replace(**{key: value})
            continue
        twin = scene.replace(**{key: value})
        assert result(twin) == result(gs.Scene(**after)), (key, value)
        family.append((after, twin))


def test_a_body_that_crosses_itself_and_was_not_split_is_refused_with_the_remedy():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    faces = corners[[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]]
    both = soup(
        "F3", np.concatenate([np.add(faces, at) for at in ((1, 1, -3), (1.25, 1.125, -2.875))])
    )
    inputs = start() | {"faults": {"F3": both}}
    with pytest.raises(GeometryError, match=r"crosses itself.*self_intersections=True") as caught:
        gs.Scene(**inputs).units  # noqa: B018
    assert caught.value.surfaces == ("F3",)
    split = gs.Scene(**inputs | {"self_intersections": True})
    assert split.check().ok
    with pytest.raises(GeometryError, match="crosses itself"):  # what is remembered is another
        split.replace(self_intersections=False).units  # noqa: B018


def test_a_sheet_is_not_remembered_with_other_faults():
    """Its fault was exchanged, and the sheet that ends on the old one came from memory."""
    one, two = upright("F", 1).renamed("F1"), upright("F", 2).renamed("F1")
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


# ---- Scenes whose surfaces move: each has the bytes of the scene made afresh.

COARSE, FINE = 1 / 8, 1 / 512


def horizon(rng, level, step):
    """A grid of eighths: faults pass through nodes and along edges; horizons cross, and touch.

    Other numbers (step 0) have none of that, and multiples of a fine step little.
    """
    relief = rng.normal(0.0, 0.4, (7, 7))
    if step:
        most = 6 if step == COARSE else 400
        relief = rng.integers(-most, most + 1, (7, 7)) * step
    return grid("H", level + relief, corner=(-1.0, -1.0))


def fault(rng, step):
    """An upright or slanting sheet, which may end inside the model or miss a horizon."""
    off = rng.normal(0.0, 0.1, 2)
    if step:
        off = rng.integers(-60, 61, 2) * step if step == FINE else 0.0
    x, shift = rng.choice(9, 2, replace=False) / 2.0 + off
    low, high = sorted(rng.choice([-5.0, 0.0, 2.0, 4.0, 9.0], 2, replace=False))
    return sheet("F", [(x, -1, low), (x, 5, low), (shift, 5, high), (shift, -1, high)])


@pytest.mark.parametrize("seed", range(3))
def test_grids_that_are_newly_crossed_are_those_made_afresh(seed):
    """Runs that nothing touched are cut, also amid a patch: a hill rises into a horizon,
    and then a ring around it.
    """
    rng = np.random.default_rng([84, seed])
    axis = np.linspace(-1.0, 5.0, 25)
    away = np.hypot(*np.meshgrid(axis - 2.0, axis - 2.0))
    hill, ring = np.exp(-(away**2) / 0.15), np.exp(-((away - 1.3) ** 2) / 0.03)

    def gridded(level, height, what=hill):
        heights = level + height * what + rng.normal(0.0, 0.02, (25, 25))
        return gs.TriSurface("H", "horizon", lattice=Lattice(axis, axis, heights))

    changes = {"horizons": {"Top": gridded(4.0, 0.0), "Mid": gridded(2.0, 0.5)}}
    changes["horizons"]["Base"] = gridded(0.5, 0.0)
    changes["faults"] = {"F1": fault(rng, 0.0), "F2": fault(rng, 0.0)}
    scene = gs.Scene(**changes, box=BOX)
    _ = result(scene)
    for k in range(6):
        kind = "faults" if k == 3 else "horizons"
        name = ("Mid", "Base", "Mid", "F1", "Base", "Top")[k]
        one = (
            gridded(2.0, 3.0), gridded(0.5, 5.0, ring), gridded(2.0, 2.5), fault(rng, 0.0),
            gridded(0.5, 0.0), gridded(4.0, 0.5),
        )[k]  # fmt: skip
        changes = {**changes, kind: {**changes[kind], name: one}}
        scene = scene.replace(**{kind: {name: one}})
        assert result(scene) == result(gs.Scene(**changes, box=BOX)), k


# ---- Passes over ranges of triangles, edges and records in threads: the bytes of one thread.
LEAST = [
    (arrange, "_RECORDS_OF_A_THREAD"),
    (gather, "_PAIRS_IN_THREADS"),
    (gather, "_POINTS"),
    (gather, "_SUSPECTS"),
    (gather, "_CONTACTS"),
    (search, "_PAIRS_OF_A_THREAD"),
    (search, "_CONTACTS_OF_A_THREAD"),
    (assemble, "_MANY"),
    (repair, "_MANY"),
    (cells, "_TRIANGLES"),
    (cells, "_EDGES"),
    (cells, "_PARENTS"),
    (cells, "_SEAMS"),
    (measures, "_TRIANGLES"),
    (measures, "_MANY_RUNS"),
]


def results(seed, step):
    """Bytes of a scene, and of scenes in which a fault, then a horizon has moved."""
    rng = np.random.default_rng([98, seed])
    horizons = {name: horizon(rng, z, step) for name, z in (("Top", 4), ("Mid", 2), ("Base", 0))}
    faults = {"F1": upright("F1", 1.5), "F2": fault(rng, step)}
    scene = gs.Scene(horizons, faults, BOX)
    found = [result(scene)]
    for change in (
        {"faults": {"F2": fault(rng, step)}},
        {"horizons": {"Mid": horizon(rng, 2, step)}},
    ):
        scene = scene.replace(**change)
        found.append(result(scene))
        try:
            found.append([[unit.volume, unit.area] for unit in scene.units.values()])
        except GeosurfError:
            found.append([])
    return found


@pytest.mark.parametrize("step", [COARSE, 0.0])
@pytest.mark.parametrize("seed", range(3))
def test_any_number_of_threads_gives_the_bytes_of_one(seed, step, monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(seed, step)
    assert any(isinstance(one, tuple) and isinstance(one[0], dict) for one in alone)
    for where, name in LEAST:
        monkeypatch.setattr(where, name, 1)
    for n in ("2", "3", "8"):
        monkeypatch.setenv("GEOSURF_THREADS", n)
        assert results(seed, step) == alone


def arrays_of(task):
    """Arrays that a task is given, also by what it is to call."""
    for one in task:
        if isinstance(one, partial):
            yield from arrays_of(one.args)
        elif isinstance(one, tuple):
            yield from arrays_of(one)
        elif isinstance(one, np.ndarray) and one.flags.c_contiguous and one.size:
            yield one


def written_by(work, task):
    """What a task returns, and addresses of the numbers that it changes."""
    arrays = list(arrays_of(task))
    before = [one.tobytes() for one in arrays]
    found, addresses = work(*task), set()
    for one, old in zip(arrays, before, strict=True):
        differ = np.frombuffer(one.tobytes(), np.uint8) != np.frombuffer(old, np.uint8)
        first = one.__array_interface__["data"][0]
        addresses |= {first + at - at % one.itemsize for at in np.flatnonzero(differ).tolist()}
    return found, addresses


def one_by_one(work, rows, worth=True):
    """`map_threads`, backwards; no two tasks may change one number."""
    found, changed = [], set()
    for row in list(rows)[::-1]:
        result, own = written_by(work, row)
        assert not own & changed, f"two tasks of {work} write one number"
        changed |= own
        found.append(result)
    return found[::-1]


@pytest.mark.parametrize("step", [COARSE, 0.0])
def test_no_two_ranges_write_one_number(step, monkeypatch):
    """Also where a race would be too rare to be seen, and in whatever order tasks are done."""
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(0, step)
    for where, name in LEAST:
        monkeypatch.setattr(where, name, 1)
    monkeypatch.setenv("GEOSURF_THREADS", "3")
    users = [
        module
        for name, module in list(sys.modules.items())
        if name.startswith("geosurf.") and getattr(module, "map_threads", None) is map_threads
    ]
    for module in users:
        monkeypatch.setattr(module, "map_threads", one_by_one)
    assert results(0, step) == alone
