"""Every column that is a length, in every unit and kind of file: the same data, or a refusal."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from tests.grids import gridded

METRES = {"m": 1.0, "ft": 0.3048, "km": 1000.0, "ftUS": 1200.0 / 3937.0}
PATH = [  # md, easting, northing, elevation; with a station given twice
    (0.0, 4000.0, 5000.0, 30.0),
    (900.0, 4000.0, 5000.0, -870.0),
    (900.0, 4000.0, 5000.0, -870.0),
    (1500.0, 4360.0, 5000.0, -1350.0),
    (2100.0, 4360.0, 5480.0, -1710.0),
]


def in_units(rows, unit, md_unit):
    return [(row[0] / METRES[md_unit], *(v / METRES[unit] for v in row[1:])) for row in rows]


def text_of(rows, sign=","):
    return "\n".join(sign.join(repr(float(v)) for v in row) for row in rows)


def write(tmp_path, name, text):
    (tmp_path / name).write_text(text + "\n")
    return tmp_path / name


def assert_path(wells, rows=PATH):
    """Every station, the last one too, in metres."""
    wanted = np.array(rows)
    found = np.column_stack([wells[k].values for k in ("md", "easting", "northing", "elevation")])
    wanted = wanted[np.append(True, np.diff(wanted[:, 0]) > 0)]
    found = found[np.append(True, np.diff(found[:, 0]) > 0)]
    np.testing.assert_allclose(found, wanted, atol=1e-6)


@pytest.mark.parametrize("md_unit", ["m", "ft"])
@pytest.mark.parametrize("unit", METRES)
def test_wells_with_units_in_the_header(tmp_path, unit, md_unit):
    if unit == md_unit == "m":
        header = "MD,X,Y,Z"
    else:
        header = f"MD [{md_unit}],X [{unit}],Y [{unit}],Z [{unit}]"
    file = write(tmp_path, "w.csv", f"{header}\n{text_of(in_units(PATH, unit, md_unit))}")
    words = {"length_unit": "m"} if header == "MD,X,Y,Z" else {}
    assert_path(gs.read_wells(file, positive="up", **words))


def tables(unit):
    """Reader, text, words that are passed, and what comes out, for each kind of table."""
    m = METRES[unit]
    top = f"W1,4000.0,5000.0,{-1350.0 / m!r},Top"
    up, here = {"positive": "up"}, {"positive": "up", "length_unit": unit}
    place = {"elevation": [-1350.0], "easting": [4000.0]}
    return {
        "survey": (gs.read_wells, f"Well,MD [{unit}],Inc,Azi\nA,0.0,0,90\nA,{600.0 / m!r},0,90",
                   {"heads": {"A": (10.0, 20.0, 25.0)}},
                   {"md": [0.0, 600.0], "elevation": [25.0, -575.0]}),
        "tops by header": (gs.read_tops, f"Well,X,Y,Z [{unit}],Surface\n{top}", up, place),
        "tops by argument": (gs.read_tops, f"Well,X,Y,Z,Surface\n{top}", here, place),
        "points": (gs.read_points,
                   f"Well,MD,X,Y,Z\nA,{900.0 / m!r},4000.0,5000.0,{-870.0 / m!r}", here,
                   {"md": [900.0], "elevation": [-870.0], "easting": [4000.0]}),
    }  # fmt: skip


@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("kind", tables("m"))
def test_tables_in_every_unit(tmp_path, kind, unit):
    read, text, words, wanted = tables(unit)[kind]
    found = read(write(tmp_path, "t.csv", text), **words)
    for key, values in wanted.items():
        np.testing.assert_allclose(found[key].values, values, atol=1e-9)


PETREL = """# WELL TRACE FROM PETREL
# WELL NAME:              W1
# WELL HEAD X-COORDINATE: 4000.0 (m)
# WELL HEAD Y-COORDINATE: 5000.0 (m)
# WELL DATUM (KB, Kelly bushing, from MSL): {kb} ({unit})
# DEPTH (Z, TVD_Z) GIVEN IN {unit}-UNITS
#=====
 MD X Y Z
#=====
"""


@pytest.mark.parametrize("unit", ["m", "ft"])
def test_petrel_traces_state_the_unit_of_depths(tmp_path, unit):
    size = METRES[unit]
    rows = [(md / size, x, y, z / size) for md, x, y, z in PATH]
    head = PETREL.format(kb=30.0 / size, unit=unit)
    assert_path(gs.read_wells(write(tmp_path, "W1.dev", head + text_of(rows, " "))))


@pytest.mark.parametrize("positive", ["up", "down"])
@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("suffix", ["nc", "zmap", "irap", "asc", "cps3"])
def test_grids_in_every_unit_and_sign(tmp_path, suffix, unit, positive):
    """Also with values of both signs: absent nodes are those of the file's mark, no others."""
    values = np.array([[-1200.0, -999.0, 12.0], [-1300.0, -9.0, np.nan], [-8.0, -99.0, -999.5]])
    axis = np.array([0.0, 100.0, 200.0])
    horizon = gridded(values, axis + 5000.0, axis).rename("elevation")
    turned = 1.0 if positive == "up" else -1.0
    stored = (horizon * turned / METRES[unit]).assign_attrs(units="m", positive="up")
    file = tmp_path / f"h.{suffix}"
    if suffix == "nc":
        stored.attrs = {}
        stored.to_dataset(name="elevation").to_netcdf(file, engine="h5netcdf")
    else:
        try:
            gs.write(stored, file)
        except gs.errors.GeosurfError:
            pytest.skip("this format is not written for grids")
    found = gs.read_horizon(file, positive=positive, length_unit=unit)
    np.testing.assert_allclose(found.values, values, rtol=1e-6, atol=1e-4)
    assert found.attrs["positive"] == "up"
    assert found.attrs["units"] == "m"


@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("where", ["elevation", "easting", "northing"])
def test_arrays_declare_the_unit_of_each_coordinate(where, unit):
    size = METRES[unit]
    x, y = np.linspace(0.0, 3000.0, 7), np.linspace(0.0, 2000.0, 5)
    scale = {key: size if key == where else 1.0 for key in ("elevation", "easting", "northing")}
    z = np.full((5, 7), -1000.0) + 0.01 * x
    axes = x / scale["easting"], y / scale["northing"]
    said = unit if where == "elevation" else "m"
    top = gridded(z / scale["elevation"], *axes, units=said)
    for key in ("easting", "northing"):
        top[key].attrs["units"] = unit if key == where else "m"
    box = (0.0, 3000.0, 0.0, 2000.0, -1200.0, -900.0)
    units = gs.Scene({"Top": top}, {}, box).units
    assert units["above Top"].volume == pytest.approx(3000.0 * 2000.0 * 85.0, rel=1e-9)


@pytest.mark.parametrize("unit", METRES)
def test_sticks_and_polygons_in_every_unit(tmp_path, unit):
    size = METRES[unit]
    end = (999.0, 999.0, 999.0)
    rows = []
    for y in (20.0, 90.0):
        rows += [(10.0, y, -1000.0 / size), (15.0, y, -1200.0 / size), end]
    file = write(tmp_path, "F1.pol", text_of(rows, " "))
    sticks = gs.read_fault(file, positive="up", length_unit=unit)
    assert [stick[:, 2].tolist() for stick in sticks.sticks] == [
        pytest.approx([-1000.0, -1200.0])
    ] * 2
    lines = gs.read_polygons(file, positive="up", length_unit=unit)
    assert [line[:, 2].min() for line in lines] == [pytest.approx(-1200.0)] * 2


@pytest.mark.parametrize("unit", METRES)
def test_meshes_in_every_unit(tmp_path, unit):
    corners = np.array([(0.0, 0.0, -1000.0), (100.0, 0.0, -1010.0), (0.0, 100.0, -990.0)])
    surface = gs.TriSurface("F1", "fault", corners, [[0, 1, 2]])
    scaled = gs.TriSurface("F1", "fault", corners / (1, 1, METRES[unit]), [[0, 1, 2]])
    for suffix in ("ts", "vtp", "stl", "obj"):
        gs.write(scaled, tmp_path / f"F1.{suffix}")
        if suffix == "ts" and unit != "m":  # the file states metres
            with pytest.raises(gs.errors.InputError, match="unit"):
                gs.read_fault(tmp_path / "F1.ts", positive="up", length_unit=unit)
            continue
        found = gs.read_fault(tmp_path / f"F1.{suffix}", positive="up", length_unit=unit)
        order = np.lexsort(found.vertices.T)
        wanted = surface.vertices[np.lexsort(surface.vertices.T)]
        np.testing.assert_allclose(found.vertices[order], wanted, rtol=1e-6)
