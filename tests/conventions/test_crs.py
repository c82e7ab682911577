"""Units of reference systems: metres, or refused; never taken for metres because nobody knows."""

from __future__ import annotations

import gc
import os
import sys
import time
import weakref
from fractions import Fraction

import numpy as np
import pytest

import geosurf as gs
from geosurf.carve.certificate_facts import Facts
from geosurf.conventions import checks, shift_is_exact
from geosurf.conventions import running as module
from geosurf.conventions.checks import crs_of_foreign, lines_of_foreign, points_of_foreign
from geosurf.conventions.crs import METRIC
from geosurf.conventions.running import count_of, running, silence
from geosurf.errors import FormatError, InputError
from geosurf.triangulate.outline import check_outline
from tests.messages import refused


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
    refused(InputError, r"vertical part of .* is in units of 0\.304801 m", lambda: scene.units)


# ---- Which shifts of coordinates lose nothing.
@pytest.mark.parametrize("shape", [(7,), (7, 5), (0,), (3, 0)])
@pytest.mark.parametrize("at_once", [1, 4, 1000])
def test_a_shift_is_exact_if_that_of_every_coordinate_is(shape, at_once, rng, monkeypatch):
    """Coordinates are looked at some at a time; the answer is that of rational numbers."""
    monkeypatch.setattr(checks, "_AT_ONCE", at_once)
    values, shift = 456_000.0 + rng.integers(0, 9000, shape) / 8.0, 455_680.0
    if values.size:
        values.flat[-1] = np.nan
    assert shift_is_exact(values, shift)
    for k in range(values.size - 1):
        odd = values.copy()
        odd.flat[k] = 1e-9
        assert Fraction(odd.flat[k]) - Fraction(shift) != Fraction(odd.flat[k] - shift)
        assert not shift_is_exact(odd, shift)


# ---- Facts of certificates go with their last user.


def test_facts_go_with_their_last_user():
    """They are as large as the model, and the second run of a certificate comes after them."""
    world = gs.synthetic.tilted_planes()
    facts = Facts.of(gs.Scene(world.horizons, world.faults, world.box).patches)
    gone = weakref.ref(facts)
    gc.disable()
    try:
        del facts
        assert gone() is None
    finally:
        gc.enable()


# ---- Places and lines of other packages, by objects that look like theirs.
SQUARE = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0), (0.0, 0.0)]


class Shape:
    """As shapely has it: polygons have no coordinates of their own, and say so loudly."""

    def __init__(self, geom_type, coords=(), holes=(), parts=None):
        self.geom_type, self._coords, self.interiors = geom_type, coords, holes
        if geom_type == "Polygon":
            self.exterior = Shape("LinearRing", coords)
        if parts is not None:
            self.geoms = parts

    @property
    def coords(self):
        if self.geom_type == "Polygon":
            raise NotImplementedError
        return self._coords


class Frame:
    """As geopandas has it."""

    def __init__(self, shapes, crs=None):
        self.geometry, self.crs, self.geom_type = shapes, crs, None


class Polygons:
    """As xtgeo has it."""

    xname, yname, zname, pname = "X_UTME", "Y_UTMN", "Z_TVDSS", "POLY_ID"

    def __init__(self, points, z=0.0):
        x, y = np.array(points).T
        self.table = {"X_UTME": x, "Y_UTMN": y, "Z_TVDSS": 0 * x + z, "POLY_ID": 0 * x}

    def get_dataframe(self):
        return self.table


def test_points_and_lines_of_geopandas_and_shapely():
    cloud = Frame(
        [Shape("MultiPoint", parts=[Shape("Point", [(1, 2, 3)])]), Shape("Point", [(4, 5, 6)])]
    )
    assert points_of_foreign(cloud).tolist() == [[1, 2, 3], [4, 5, 6]]
    area = Shape("Polygon", SQUARE)
    assert [line.tolist() for line in lines_of_foreign(area)] == [[list(p) for p in SQUARE]]
    assert crs_of_foreign(Frame([area], "EPSG:23031")) == "EPSG:23031"
    for wrong in (Frame([area]), Frame([Shape("Point", [(1, 2)])])):
        refused(ValueError, "points in space", points_of_foreign, wrong)
    refused(ValueError, "holes", lambda: lines_of_foreign(Shape("Polygon", SQUARE, holes=[SQUARE])))


@pytest.mark.parametrize("area", [Shape("Polygon", SQUARE), Frame([Shape("Polygon", SQUARE)]),
                                  Polygons(SQUARE), Polygons(SQUARE, 1700.0)])  # fmt: skip
def test_areas_of_other_packages_are_outlines(area):
    assert check_outline(area).tolist() == [list(p) for p in SQUARE[:-1]]


def test_depths_of_xtgeo_are_not_taken_for_elevations():
    refused(ValueError, "elevation or depth", lambda: lines_of_foreign(Polygons(SQUARE, 1700.0)))
    with pytest.raises(InputError, match="elevation or depth"):
        gs.PictureOverlay(points={"picks": Polygons(SQUARE)})
    assert len(gs.PictureOverlay(polygons={"licence": Polygons(SQUARE)}).polygons["licence"]) == 1


def test_systems_of_gocad_lines_are_read(tmp_path):
    text = 'GOCAD PLine 1\nHEADER {{\nname:{0}\n}}\nGOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME "{1}"\n'
    text += "END_ORIGINAL_COORDINATE_SYSTEM\nILINE\nVRTX 1 0 0 5\nVRTX 2 9 0 5\nSEG 1 2\nEND\n"
    one, two = text.format("a", "EPSG:23031"), text.format("b", "EPSG:32631")
    (tmp_path / "one.pl").write_text(one)
    (tmp_path / "two.pl").write_text(one + two)
    assert gs.read_fault(tmp_path / "one.pl").crs == "EPSG:23031"
    refused(FormatError, "several coordinate reference systems", gs.read_fault, tmp_path / "two.pl")


# ---- The line that shows what is running: after a while, where somebody watches, then gone.
def until(condition):
    """Wait for another thread; a loaded machine may take its time."""
    end = time.monotonic() + 20.0
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()


@pytest.fixture
def lines(monkeypatch):
    """What is shown, within milliseconds."""
    shown: list[str] = []
    monkeypatch.setattr(module, "_board", module._Board())
    monkeypatch.setattr(module, "_sink", lambda: shown.append)
    for name, seconds in (("AFTER", 0.03), ("EVERY", 0.01), ("GRACE", 0.01)):
        monkeypatch.setattr(module, name, seconds)
    return shown


def test_the_outermost_and_the_innermost_step_are_named_and_the_line_goes(lines):
    count_of("tear Top", 2, 4)
    with running("report"):
        until(lambda: any(line.startswith("report, 0 s") for line in lines))
        with running("scene"), running("tear Top"):
            until(lambda: any("report, tear Top (2 of 4)" in line for line in lines))
    assert lines[-1] == ""
    assert not any("scene" in line for line in lines)
    until(lambda: module._board.watcher is None)


@pytest.mark.parametrize("how", ["silence", "show_progress", "environment"])
def test_it_is_silent_on_request(how, lines, monkeypatch):
    if how == "environment":
        monkeypatch.setenv("GEOSURF_PROGRESS", "off")
    if how == "show_progress":
        gs.show_progress(False)
        gs.show_progress(False)
    try:
        with silence() if how == "silence" else running("outside"), running("inside"):
            assert module._board.watcher is None
    finally:
        gs.show_progress()
    monkeypatch.delenv("GEOSURF_PROGRESS", raising=False)
    with running("again"):
        until(lambda: lines)


def test_nobody_watches_a_pipe_and_somebody_a_terminal(monkeypatch):
    assert module._sink() is None
    master, slave = os.openpty()
    with os.fdopen(slave, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        show = module._sink()
        show("tear Top, 2 s ...")
        show("")
        expected = b"\r\x1b[Ktear Top, 2 s ...\r\r\x1b[K\r"
        found = b""
        while len(found) < len(expected):  # one read may end between two lines
            found += os.read(master, 99)
        assert found == expected
    os.close(master)


def test_a_scene_announces_its_steps_unless_its_caller_does(lines, monkeypatch):
    world, seen = gs.synthetic.tilted_planes(n=5), []
    steps = []
    monkeypatch.setattr(module._board, "push", lambda words, show: steps.append(words))
    monkeypatch.setattr(module._board, "pop", lambda words: None)
    assert gs.Scene(world.horizons, world.faults, world.box).units
    assert any("units" in step or "carve" in step for step in steps)
    steps.clear()
    assert gs.Scene(
        world.horizons, world.faults, world.box, on_start=lambda *s: seen.append(s)
    ).units
    assert seen
    assert steps == []
