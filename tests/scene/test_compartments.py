"""Laws of compartments: volumes add up, walls are shortest, names do not matter; or an error."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeometryError, InputError

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.GeosurfWarning")

BOX = (0.0, 16.0, 0.0, 16.0, -12.0, 0.0)
FLAT = [[-1, -1], [17, -1], [17, 17], [-1, 17]]


def level(z: float) -> tuple[list, list]:
    return [[x, y, z] for x, y in FLAT], [[0, 1, 2], [0, 2, 3]]


HORIZONS = {"Top": level(-4.0), "Base": level(-8.0)}


def fault(start, end, dip=0.0, top=1.0, base=-13.0) -> tuple[list, list]:
    """A plane of two triangles between two places on the map, moved by `dip` at its base."""
    (a, b), (c, d) = start, end
    along = np.array([c - a, d - b], dtype=float)
    across = dip * np.array([along[1], -along[0]]) / np.linalg.norm(along)
    low = [(a + across[0], b + across[1], base), (c + across[0], d + across[1], base)]
    return [(a, b, top), (c, d, top), low[1], low[0]], [[0, 1, 2], [0, 2, 3]]


def scene(faults, compartments=None) -> gs.Scene:
    return gs.Scene(HORIZONS, faults, BOX, compartments=compartments)


def assert_divided(plain: gs.Scene, walled: gs.Scene) -> None:
    """Compartments add up to the blocks without them, zone by zone, and the certificate holds."""
    assert walled.check().ok, walled.check()
    total: Counter = Counter()
    for unit in walled.units.values():
        total[unit.zone, unit.compartment_of] += unit.volume
    blocks = {(unit.zone, unit.block): unit.volume for unit in plain.units.values()}
    assert total.keys() == blocks.keys()
    for key, volume in blocks.items():
        assert total[key] == pytest.approx(volume, rel=1e-12)


def test_a_fault_that_dies_divides_the_field_along_the_shortest_join() -> None:
    """A wall of a vertical plane: distances and volumes follow by hand."""
    faults = {"F1": fault((6, 5), (6, 10))}
    walled = scene(faults, True)
    assert_divided(scene(faults), walled)
    joins = {wall.side: wall for wall in walled.virtual_walls}
    assert {side: (one.target, one.length) for side, one in joins.items()} == {
        "start": ("boundary", 5.0),
        "end": ("boundary", 6.0),
    }
    assert joins["end"].area == pytest.approx(6.0 * 12.0)

    # straight to the south, and to the west or north, which are equally near: 6 m
    zone = {unit.block: unit.volume for unit in walled.units.values() if unit.zone == "Top/Base"}
    assert sorted(zone) == ["F1+", "F1-"]
    assert min(zone.values()) in (pytest.approx(4.0 * 6 * 10), pytest.approx(4.0 * 6 * 16))
    table = walled.units.table
    assert set(table["compartment_of"].values) == {"whole"}
    assert "compartment_of" not in scene(faults).units.table.coords


def test_a_contact_may_be_of_one_compartment() -> None:
    faults = {"F1": fault((6, 5), (6, 10))}
    walled = scene(faults, True).replace(contacts={"OWC": {"F1+": -6.0}})
    inside = {side: [u for u in walled.units.on(side) if u.zone in walled.reservoir]
              for side in ("F1+", "F1-")}  # fmt: skip
    assert {unit.contact for unit in inside["F1+"]} == {"above OWC", "below OWC"}
    assert {unit.contact for unit in inside["F1-"]} == {""}


@pytest.mark.parametrize(
    ("compartments", "error", "words"),
    [
        ({"F9": True}, InputError, "'F9', which is not a fault"),
        ({"F1": "F9"}, InputError, "joins 'F1' to 'F9'"),
        ({"F1": "F2"}, InputError, "dies inside the model at both ends"),
        ({"F1": {"end": "boundary"}}, GeometryError, "its start stays open"),
        ({"F1": {"start": "boundary", "end": "F2"}}, GeometryError, "'F2'.*dies inside the model"),
        ({"F1": {"start": "boundary", "end": "F3"}}, GeometryError, "lies 'F2'"),
    ],
)
def test_what_cannot_be_divided_is_an_error(compartments, error, words) -> None:
    faults = {
        "F1": fault((3, 4), (3, 12)),
        "F2": fault((8, 2), (8, 14)),
        "F3": fault((13, -1), (13, 17)),
    }
    with pytest.raises(error, match=words):
        _ = scene(faults, compartments).units


def random_faults(seed: int) -> dict:
    """Two or three faults on whole numbers: parallel, crossing, meeting, dying above or below."""
    rng = np.random.default_rng(seed)
    found = {}
    for k in range(int(rng.integers(2, 4))):
        while True:
            a, c = rng.integers(2, 15, (2, 2))
            if np.abs(a - c).sum() > 3:
                break
        top, base = (1.0, -13.0) if rng.random() < 0.6 else (-5.0, -9.0)
        dip = float(rng.integers(-2, 3))
        found[f"F{k + 1}"] = fault(a.tolist(), c.tolist(), dip, top, base)
    return found


@pytest.mark.parametrize("seed", range(12))
def test_lattice_worlds_are_divided_exactly_or_refused(seed: int) -> None:
    faults = random_faults(seed)
    walled = scene(faults, True)
    if seed in (5, 9):
        with pytest.raises(GeometryError, match=r"fault 'F[123]'.*near \(E") as caught:
            _ = walled.units
        assert caught.value.place is not None
        return
    assert_divided(scene(faults), walled)
