"""Volumes of parts at level contacts: those of the arrangement with the contacts among surfaces."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfError
from tests.scene.small import ran
from tests.strategies import sheet

pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

BOX = (0.0, 6.0, 0.0, 6.0, -4.0, 8.0)


def horizon(rng, base, rising):
    """A lattice with whole heights, so that contacts often touch corners, edges and planes."""
    x = np.arange(-1.0, 8.0)
    z = base + rng.integers(0, 3, size=(len(x), len(x))).astype(float)
    return gs.TriSurface("H", "horizon", lattice=gs.Lattice(x, x, z, rising=rising))


def world(seed):
    """Two rough horizons that may touch, one or two faults, and one to three contacts."""
    rng = np.random.default_rng([44, seed])
    horizons = {
        "Top": horizon(rng, 3.0, bool(seed % 2)),
        "Base": horizon(rng, rng.integers(0, 3), bool(seed % 3)),
    }
    x = 0.5 * rng.integers(3, 9)
    dips = [(x, -1, -5), (x, 7, -5), (x + 1.5, 7, 9), (x + 1.5, -1, 9)]
    across = [(-1, 3, -5), (7, 3, -5), (7, 3, 9), (-1, 3, 9)]
    faults = {"F1": sheet("F1", dips), "F2": sheet("F2", across)}
    if seed % 3 == 0:
        del faults["F2"]

    upper, lower = sorted((rng.integers(0, 24, size=2) / 4.0).tolist(), reverse=True)
    contacts = [
        {"OWC": lower},
        {"GOC": upper, "OWC": lower},
        {"OWC": {"F1+": upper, "elsewhere": lower}},
        {
            "OWC": [
                gs.FluidContact(upper, zones="Top/Base"),
                gs.FluidContact(lower, zones="below Base"),
            ]
        },
    ][seed % 4]
    every = ["above Top", "Top/Base", "below Base"]  # contacts meet walls of the box as well
    return {"horizons": horizons, "faults": faults, "box": BOX, "contacts": contacts,
            "reservoir": every}  # fmt: skip


def found(make):
    """A result, or the words of the refusal."""
    try:
        return make()
    except GeosurfError as error:
        return type(error), str(error)


@pytest.mark.parametrize("first", range(0, 24, 6))
def test_they_are_those_of_the_arrangement(first):
    n_fast = 0
    for seed in range(first, first + 6):
        given = world(seed)
        scene = gs.Scene(**given)
        one, two = found(lambda s=scene: s.volumes), found(lambda s=scene: s.units.volumes)
        if isinstance(one, tuple) or isinstance(two, tuple):
            assert one == two, seed
            continue
        assert one.coords.equals(two.coords), seed
        assert one.attrs == two.attrs
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-12 * 432)
        assert one.sum().item() == pytest.approx(432.0, rel=1e-14)
        n_fast += scene._graph.units_at_levels is not None

        # to the byte from whatever scene of the family
        before = gs.Scene(**given | {"contacts": {"OWC": 2.125}})
        _ = before.volumes
        again = before.replace(contacts=given["contacts"])
        assert again.volumes.identical(one), seed
        assert again.volumes.values.tobytes() == one.values.tobytes()
    assert n_fast >= 1


def test_a_moved_contact_repeats_nothing_else():
    given = world(1)
    scene = gs.Scene(**given | {"contacts": {"OWC": 2.125}})
    _ = scene.volumes
    moved = scene.replace(contacts={"OWC": 2.375})
    assert moved.volumes.sum().item() == pytest.approx(432.0)
    assert ran(moved) == ["OWC"]


def test_a_contact_on_a_flat_top_is_left_to_the_arrangement():
    """Whether there is anything above it is decided by exact signs."""
    x = np.arange(-1.0, 8.0)
    flat = gs.TriSurface("T", "horizon", lattice=gs.Lattice(x, x, np.full((9, 9), 2.0)))
    for level, n_unit in ((2.0, 2), (1.0, 3)):
        contact = {"OWC": gs.FluidContact(level, zones="below Top")}
        scene = gs.Scene({"Top": flat}, {}, BOX, contacts=contact)
        assert len(scene.volumes) == n_unit
        assert (scene._graph.units_at_levels is None) == (level == 2.0)
        np.testing.assert_allclose(scene.volumes, scene.units.volumes, rtol=1e-15)


def test_slivers_are_merged_at_contacts_as_well():
    flat = gs.TriSurface("Top", "horizon", [[-1, -1, 3], [9, -1, 3], [9, 9, 3], [-1, 9, 3]],
                         [[0, 1, 2], [0, 2, 3]])  # fmt: skip
    merged = {"min_volume": 1.0, "merge": True}
    scene = gs.Scene({"Top": flat}, {}, BOX, contacts={"OWC": 2.99}, slivers=merged)
    assert scene.volumes.values.tolist() == scene.units.volumes.values.tolist()
    assert len(scene.volumes) == 2
