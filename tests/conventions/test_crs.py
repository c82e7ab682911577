"""Units of reference systems: metres, or refused; never taken for metres because nobody knows."""

import sys

import pytest

import geosurf as gs
from geosurf.conventions.crs import METRIC
from geosurf.errors import InputError


@pytest.mark.parametrize("crs", ["EPSG:2276", "EPSG:32664", "urn:ogc:def:crs:EPSG::2278"])
@pytest.mark.parametrize("there", [False, True])
def test_a_code_in_feet_is_refused_with_and_without_pyproj(monkeypatch, crs, there):
    if there:
        pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)")
    else:
        monkeypatch.setitem(sys.modules, "pyproj", None)
    gs.conventions.crs._metres.cache_clear()
    world = gs.synthetic.tilted_planes(n=5)
    world.horizons["Top"].attrs["crs"] = crs
    with pytest.raises(InputError, match=r"may be in feet\. Install it: pip|are in feet"):
        gs.Scene(world.horizons, world.faults, world.box).units  # noqa: B018
    gs.conventions.crs._metres.cache_clear()


def test_codes_that_need_no_pyproj_are_in_metres():
    CRS = pytest.importorskip("pyproj", reason="pyproj is not installed (extra crs)").CRS
    from pyproj.exceptions import CRSError

    known = 0
    for code in range(1024, 32768):
        if METRIC.fullmatch(str(code)):
            try:
                axes = CRS.from_epsg(code).axis_info
            except CRSError:
                continue
            assert all(axis.unit_conversion_factor == 1.0 for axis in axes), code
            known += 1
    assert known > 500


@pytest.mark.parametrize(("unit", "metres"), [("metre", 1.0), ("US survey foot", 0.3048006096)])
@pytest.mark.parametrize("words", ["VERT_CS", "VERTCRS"])
def test_the_vertical_part_of_a_system_is_in_metres_or_refused(unit, metres, words):
    height = f'{words}["NAVD88 height",UNIT["{unit}",{metres}]]'
    world = gs.synthetic.tilted_planes(n=5)
    flat = 'PROJCS["A",UNIT["metre",1]]'
    for one in world.horizons.values():
        one.attrs["crs"] = f'COMPD_CS["B",{flat},{height}]'
    scene = gs.Scene(world.horizons, world.faults, world.box)
    if metres == 1.0:
        assert len(scene.units)
        return
    with pytest.raises(InputError, match="vertical part of .* is in units of 0.304801 m"):
        scene.units  # noqa: B018
