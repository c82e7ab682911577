"""Sealed models in the two kinds of file that hold them: units out are units in."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

import geosurf as gs
from geosurf.read.model3d import read_regions
from tests.strategies import faulted_worlds
from tests.write.sealed import assert_equal, carve

SUFFIXES = (".ml", ".epc")


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=7)
@given(surfaces=faulted_worlds())
def test_units_of_small_worlds_come_back(surfaces, suffix, tmp_path_factory):
    pytest.importorskip("h5py")
    one, two = (tmp_path_factory.mktemp("worlds") for _ in range(2))
    units = carve(surfaces)
    (path, *_) = gs.write(units, one / f"m{suffix}", name="m")
    back = gs.read_units(path)
    assert_equal(back, units)
    gs.write(back, two / f"m{suffix}", name="m")
    first, again = ({p.name: p.read_bytes() for p in folder.iterdir()} for folder in (one, two))
    assert first == again
    if suffix == ".ml":
        volumes = [unit.volume for unit in back.values()]
        assert list(read_regions(path).values()) == pytest.approx(volumes, rel=1e-13)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_labels_roles_and_the_reference_system_come_back(graben, suffix, tmp_path):
    pytest.importorskip("h5py")
    path = gs.write(graben, tmp_path / f"m{suffix}", name="m")[0]
    back = gs.read_units(path)
    assert_equal(back, graben)
    assert any(unit.contact for unit in back.values())
    assert back.crs == next(iter(back.values())).crs == "EPSG:32631"
    roles = {source.name: source.role for source in back.piece_sides[0].sources}
    assert {name: roles[name] for name in ("OWC", "F1", "Top", "west")} == {
        "OWC": "contact", "F1": "fault", "Top": "horizon", "west": "wall",
    }  # fmt: skip
    assert "read_units" in gs.info(path).read_with
