"""Scenes made from scenes take nothing for another thing; the bytes of any number of threads."""

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
from geosurf.model import Sheet
from geosurf.rebuild import assemble, repair
from tests import laws
from tests.scene.conftest import level
from tests.strategies import BOX, grid, sheet, soup, upright

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

ARRAYS = ("x", "triangles", "surface", "key", "twin", "ring", "link", "patch")


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


def test_a_body_that_crosses_itself_and_was_not_split_is_refused_with_the_remedy():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    faces = corners[[(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]]
    both = soup(
        "F3", np.concatenate([np.add(faces, at) for at in ((1, 1, -3), (1.25, 1.125, -2.875))])
    )
    plain = gs.Scene({"Top": level(3), "Base": level(1)}, {"F3": both}, BOX)
    with pytest.raises(GeometryError, match=r"crosses itself.*self_intersections=True") as caught:
        plain.units  # noqa: B018
    assert caught.value.surfaces == ("F3",)
    split = plain.replace(self_intersections=True)
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


# ---- Scenes whose surfaces move.


def horizon(rng, level, coarse):
    """A grid, perhaps of eighths: then faults pass through nodes and edges, and horizons touch."""
    relief = rng.integers(-6, 7, (7, 7)) / 8 if coarse else rng.normal(0.0, 0.4, (7, 7))
    return grid("H", level + relief, corner=(-1.0, -1.0))


def fault(rng, coarse):
    """An upright or slanting sheet, which may end inside the model or miss a horizon."""
    off = 0.0 if coarse else rng.normal(0.0, 0.1, 2)
    x, shift = rng.choice(9, 2, replace=False) / 2.0 + off
    low, high = sorted(rng.choice([-5.0, 0.0, 2.0, 4.0, 9.0], 2, replace=False))
    return sheet("F", [(x, -1, low), (x, 5, low), (shift, 5, high), (shift, -1, high)])


# ---- Passes over ranges of triangles, edges and records in threads: the bytes of one thread.
LEAST = [
    (arrange, "_RECORDS_OF_A_THREAD"),
    (gather, "_PAIRS_IN_THREADS"),
    (gather, "_PAIRS_OF_A_THREAD"),
    (search, "_POINTS_OF_A_THREAD"),
    (search, "_SUSPECTS_OF_A_THREAD"),
    (search, "_CONTACTS_OF_A_THREAD"),
    (assemble, "_MANY"),
    (repair, "_MANY"),
    (cells, "_TRIANGLES"),
    (cells, "_EDGES"),
    (cells, "_PARENTS"),
    (cells, "_SEAMS"),
    (measures, "_ELEMENTS"),
]


def results(seed, coarse):
    """Bytes of a scene, and of it with a fault, then a horizon moved: each as made afresh."""
    rng = np.random.default_rng([98, seed])
    horizons = {name: horizon(rng, z, coarse) for name, z in (("Top", 4), ("Mid", 2), ("Base", 0))}
    faults = {"F1": upright("F1", 1.5), "F2": fault(rng, coarse)}
    scene = gs.Scene(horizons, faults, BOX)
    found = [result(scene)]
    for change in ({"F2": fault(rng, coarse)}, {"Mid": horizon(rng, 2, coarse)}):
        given = faults if "F2" in change else horizons
        given |= change
        scene = scene.replace(**{"faults" if given is faults else "horizons": change})
        found.append(result(scene))
        assert found[-1] == result(gs.Scene(horizons, faults, BOX))
        try:
            found.append([[unit.volume, unit.area] for unit in scene.units.values()])
        except GeosurfError:
            found.append([])
    return found


@pytest.mark.parametrize("coarse", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_any_number_of_threads_gives_the_bytes_of_one(seed, coarse, monkeypatch):
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(seed, coarse)
    assert any(isinstance(one, tuple) and isinstance(one[0], dict) for one in alone)
    for where, name in LEAST:
        monkeypatch.setattr(where, name, 1)
    for n in ("3", "8"):
        monkeypatch.setenv("GEOSURF_THREADS", n)
        assert results(seed, coarse) == alone


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


@pytest.mark.parametrize("coarse", [True, False])
def test_no_two_ranges_write_one_number(coarse, monkeypatch):
    """Also where a race would be too rare to be seen, and in whatever order tasks are done."""
    monkeypatch.setenv("GEOSURF_THREADS", "1")
    alone = results(0, coarse)
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
    assert results(0, coarse) == alone
