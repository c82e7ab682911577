"""Writers: what comes back equals what went out, files are whole, bytes are the same."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import geosurf as gs
from geosurf.errors import InputError, OutputError
from tests.grids import gridded

EXACT = (".ts", ".vtp", ".vtu", ".vtk", ".obj", ".ply")


def surface(**vertex_data):
    # coordinates that no decimal of few digits holds
    vertices = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0.2], [0, 1, 1 / 3]]) * math.pi
    vertices += [456_789.123, 6_789_012.345, -2000.1]
    return gs.TriSurface("F 1", "fault", vertices, [[0, 1, 2], [0, 2, 3]], vertex_data=vertex_data)


def curves():
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [5, 5, 5.1]])
    return gs.Curves(
        names=("Top", "F1", "F2"),
        local=points,
        origin=np.array([1024.0, 0, 0]),
        segments=np.array([[0, 1], [1, 2], [2, 0], [2, 3]]),
        surfaces_of_segment=np.array([[0, 1], [0, 1], [0, 1], [0, 2]]),
        curves=(np.array([0, 1, 2, 0]), np.array([2, 3])),
        surfaces_of_curve=np.array([[0, 1], [0, 2]]),
        closed=np.array([True, False]),
    )


def horizon(values=((1.5, np.nan), (2.5, 1 / 3)), rotated=False, **attrs):
    values = np.array(values, dtype=float)
    attrs = {"long_name": "Top"} | attrs
    row, column = np.indices(values.shape)
    if not rotated:
        axes = 500_000.2 + 10.0 * column[0], 6_000_000.1 + 20.0 * row[:, 0]
        return gridded(values, *axes, **attrs)
    cos, sin = math.cos(0.4), math.sin(0.4)
    easting = 500.2 + 10 * column * cos - 20 * row * sin
    return gridded(values, easting, 700.1 + 10 * column * sin + 20 * row * cos, **attrs)


@pytest.mark.parametrize("suffix", [*EXACT, ".stl"])
def test_surfaces_come_back_exactly(tmp_path, suffix):
    paths = gs.write(surface(), tmp_path / f"fault{suffix}")
    assert paths == [tmp_path / f"fault{suffix}"]
    back = gs.read_fault(paths[0])
    np.testing.assert_array_equal(back.vertices, surface().vertices)
    np.testing.assert_array_equal(back.triangles, surface().triangles)
    assert back.name == ("F 1" if suffix in (".ts", ".vtp") else "fault")
    assert (paths.notes == ()) == (suffix in (".ts", ".vtp"))
    (again,) = gs.write(surface(), tmp_path / f"again{suffix}")
    assert again.read_bytes() == paths[0].read_bytes()
    assert b"2026-" not in again.read_bytes()


@pytest.mark.parametrize("suffix", [".ts", ".vtp", ".vtu", ".vtk"])
def test_vertex_data_come_back(tmp_path, suffix):
    data = {"throw": np.array([1.5, np.nan, 3, 4]), "normal": np.eye(4)[:, :3]}
    (path,) = gs.write(surface(**data), tmp_path / f"fault{suffix}")
    back = gs.read_fault(path).vertex_data
    for key, value in data.items():
        np.testing.assert_array_equal(back[key], value)


def test_vtp_is_what_pyvista_reads_and_writes(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    (path,) = gs.write(surface(throw=np.arange(4)), tmp_path / "fault.vtp")
    mesh = pyvista.read(path)
    np.testing.assert_array_equal(mesh.points, surface().vertices)
    np.testing.assert_array_equal(mesh.regular_faces, surface().triangles)
    assert mesh.points.dtype == np.float64
    assert mesh.field_data["name"][0] == "F 1"
    assert mesh.point_data["throw"].tolist() == [0, 1, 2, 3]
    mesh.save(tmp_path / "again.vtp")
    back = gs.read_fault(tmp_path / "again.vtp")
    np.testing.assert_array_equal(back.vertices, surface().vertices)
    np.testing.assert_array_equal(back.triangles, surface().triangles)
    np.testing.assert_array_equal(back.vertex_data["throw"], np.arange(4))
    assert back.name == "F 1"


def test_curves(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    (path,) = gs.write(curves(), tmp_path / "curves.vtp")
    lines = pyvista.read(path)
    np.testing.assert_array_equal(lines.points, curves().points)
    assert lines.lines.tolist() == [4, 0, 1, 2, 0, 2, 2, 3]
    assert lines.cell_data["surfaces"].tolist() == [[0, 1], [0, 2]]
    assert lines.field_data["surface_names"].tolist() == ["Top", "F1", "F2"]

    written = gs.write(curves(), tmp_path / "curves.pol")
    back = gs.read_polygons(written[0], positive="up")
    for line, curve in zip(back, curves().curves, strict=True):
        np.testing.assert_array_equal(line, curves().points[curve])
    assert any("names" in note for note in written.notes)

    (path,) = gs.write(curves(), tmp_path / "curves.pl")
    text = path.read_text()
    assert text.count("GOCAD PLine 1") == text.count("\nEND\n") == 2
    assert "name:Top x F1" in text
    assert "name:Top x F2" in text
    # a closed curve names its first vertex again instead of repeating it
    assert text.count("VRTX") == 5
    assert "SEG 3 1" in text


@pytest.mark.parametrize("suffix", [".vtp", ".vtu"])
def test_patches_keep_their_labels(tmp_path, suffix, planes):
    pyvista, patches = pytest.importorskip("pyvista"), planes.patches
    (path,) = gs.write(patches, tmp_path / f"patches{suffix}")
    mesh = pyvista.read(path)
    np.testing.assert_array_equal(mesh.points, patches.vertices)
    for label in ("patch", "parent", "surface"):
        expected = getattr(patches, f"{label}_of_triangle")
        np.testing.assert_array_equal(mesh.cell_data[label], expected)
        assert np.ptp(expected) > 0


@pytest.mark.parametrize("suffix", [".vtp", ".ts", ".stl"])
def test_a_unit_comes_back_closed(tmp_path, suffix, planes):
    unit = planes.units["Top/Base F1+"]
    (path,) = gs.write(unit, tmp_path / f"unit{suffix}")
    back = gs.read_fault(path)
    corners = back.vertices[back.triangles] - unit.origin
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(unit.volume, rel=1e-12)
    assert back.n_vertex == len(unit.local)
    if suffix == ".ts":
        assert path.read_text().count("TFACE") == 1  # xtgeo reads no second one


def test_units_as_tables(tmp_path, planes):
    volumes = [unit.volume for unit in planes.units.values()]
    (path,) = gs.write(planes.units, tmp_path / "units.nc")
    with xr.open_dataset(path) as table:
        assert table.unit.values.tolist() == [*planes.units]
        assert table.block.values.tolist() == [unit.block for unit in planes.units.values()]
        assert table.volume.values.tolist() == volumes
        assert table.volume.attrs["units"] == "m3"
        assert table.attrs["box"].tolist() == [*planes.box]
    (path,) = gs.write(planes.units, tmp_path / "units.csv")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["unit"] for row in rows] == [*planes.units]
    assert [float(row["volume_m3"]) for row in rows] == volumes


@pytest.mark.parametrize("rotated", [False, True])
@pytest.mark.parametrize("positive", ["up", "down"])
def test_netcdf_horizon_comes_back(tmp_path, rotated, positive):
    top = horizon(rotated=rotated, positive=positive, crs="EPSG:23031", flag=True, nothing=None)
    (path,) = gs.write(top, tmp_path / "top.nc")
    back = gs.read_horizon(path, name="Top")
    sign = 1 if positive == "up" else -1
    np.testing.assert_array_equal(back.values, sign * top.values)
    np.testing.assert_array_equal(back.easting.values, top.easting.values)
    np.testing.assert_array_equal(back.northing.values, top.northing.values)
    assert back.dims == top.dims
    assert back.attrs["crs"] == "EPSG:23031"
    assert top.attrs["nothing"] is None  # the caller's object is as it was


def test_netcdf_horizon_must_say_what_it_holds(tmp_path):
    with pytest.raises(InputError, match=r"'top': are the values depth or elevation\?"):
        gs.write(horizon(positive=None).rename("top"), tmp_path / "top.nc")
    with pytest.raises(InputError, match="length unit is missing"):
        gs.write(horizon(units=None), tmp_path / "top.nc")
    assert list(tmp_path.iterdir()) == []


number = st.floats(-1e4, 1e4).map(lambda x: x + 0.0)
value = st.one_of(number, st.just(math.nan))


@st.composite
def grid_files(draw):
    """IRAP classic text of any small grid: rotated, flipped, with holes."""
    ncol, nrow = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    step = st.sampled_from([10.0, 12.5, 40.115, -25.0, 1 / 3])
    xinc, yinc = draw(step), draw(step)
    rotation = draw(st.sampled_from([0.0, 30.0, 90.0, 140.00001525878906, 359.5]))
    x, y = draw(st.sampled_from([0.0, 461500.25])), draw(st.sampled_from([0.0, -7.3, 5926500.1]))
    values = draw(st.lists(value, min_size=ncol * nrow, max_size=ncol * nrow))
    words = " ".join("9999900.0" if math.isnan(v) else repr(v) for v in values)
    return (
        f"-996 {nrow} {xinc!r} {yinc!r}\n{x!r} 0 {y!r} 0\n{ncol} {rotation} {x!r} {y!r}\n"
        f"0 0 0 0 0 0 0\n{words}\n"
    )


@given(text=grid_files())
def test_any_regular_grid_survives_irap(tmp_path_factory, text):
    folder = tmp_path_factory.mktemp("grid")
    (folder / "in.irap").write_text(text)
    top = gs.read_horizon(folder / "in.irap", positive="up", name="Top")
    for key in ("out.irapasc", "out.gri"):
        written = gs.write(top, folder / key)
        back = gs.read_horizon(written[0], positive="up", name="Top")
        assert back.dims == top.dims
        exact = key != "out.gri"
        check = np.testing.assert_array_equal if exact else np.testing.assert_allclose
        loose = {} if exact else {"rtol": 1e-6, "atol": 1e-3}
        check(back.values, top.values, **loose)
        check(back.easting.values, top.easting.values, **loose)
        check(back.northing.values, top.northing.values, **loose)


@pytest.mark.parametrize("rotated", [False, True])
def test_grids_without_stated_geometry_fit_their_nodes(tmp_path, rotated):
    top = horizon(np.arange(12.0).reshape(3, 4), rotated=rotated)
    (path,) = gs.write(top, tmp_path / "top.irapasc")
    back = gs.read_horizon(path, positive="up")
    np.testing.assert_array_equal(back.values, top.values)
    np.testing.assert_allclose(back.easting.values, top.easting.values, rtol=1e-14)
    np.testing.assert_allclose(back.northing.values, top.northing.values, rtol=1e-14)
    # a cut-out no longer fits the origin in its attributes
    back.attrs |= {"xori": 0.0}
    part = back[1:, 1:]
    again = gs.read_horizon(gs.write(part, tmp_path / "part.irapasc")[0], positive="up")
    np.testing.assert_array_equal(again.values, part.values)
    np.testing.assert_allclose(again.easting.values, part.easting.values, rtol=1e-14)


def test_what_float32_loses_is_stated(tmp_path):
    written = gs.write(horizon(), tmp_path / "top.gri")
    assert "float32: nodes moved by up to 0.1" in written.notes[0]
    assert "values by up to 9.93e-09" in written.notes[0]
    assert "positive='up'" in written.notes[1]
    back = gs.read_horizon(written[0], positive="up")
    assert back.northing.values[0] == 6_000_000.0


@pytest.mark.parametrize("turn", [0.0, 17.0, 33.3, 90.0, 211.0])
@pytest.mark.parametrize("off", [0.0, 0.0007, 0.01, 0.3])
def test_a_grid_that_is_nearly_square_is_written_with_the_loss(tmp_path, turn, off):
    """Nodes of a text with millimetres, and axes that are off square by `off` over the map."""
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    i, j = 25.0 * np.arange(50), 30.0 * np.arange(40)[:, None]
    skew = i + off * j / j.max()
    x = np.round(461_000 + cos * skew - sin * j, 3)
    y = np.round(5_931_000 + sin * skew + cos * j, 3)
    top = gridded(i + j, x, y)
    if off > 0.1:
        with pytest.raises(OutputError, match="not on a regular rectangular grid"):
            gs.write(top, tmp_path / "top.irapasc")
        return
    (path,) = written = gs.write(top, tmp_path / "top.irapasc")
    back = gs.read_horizon(path, positive="up")
    places = (back[key].broadcast_like(back) for key in ("easting", "northing"))
    east, north = (place.transpose(*back.dims).values for place in places)
    moved = np.hypot(east - x, north - y).max()
    stated = [loss.metres for loss in written.lost if loss.what == "precision"]
    assert moved <= (stated or [1e-6])[0] * 1.001 <= 0.011
    assert (moved > 0.6 * stated[0]) if stated else turn % 90 == off == 0


@pytest.mark.parametrize("name", ["F1", "F 1", "a{b}", " lead", "two\nlines", "a,b", "tab\tx"])
def test_a_name_that_is_changed_is_among_the_losses(tmp_path, name):
    written = gs.write(surface().renamed(name), tmp_path / "a.ts")
    back = gs.read_fault(written[0])
    told = [loss.sentence for loss in written.lost if loss.what == "name"]
    assert told == (
        [] if back.name == name else [f"The name {name!r} is written as {back.name!r}."]
    )
    for suffix, changed in ((".zmap", name.replace(",", " ")), (".cps3", name)):
        written = gs.write(horizon(), tmp_path / f"a{suffix}", name=name)
        told = [loss.what for loss in written.lost].count("name")
        assert told == (" ".join(changed.split()) != name)


def test_a_folder_that_cannot_be_written(tmp_path, planes):
    with pytest.raises(OutputError, match=r"F1.ts: cannot be written \(No such file.*Check"):
        gs.write(surface(), tmp_path / "none" / "F1.ts")
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match=r"cannot be written \(.*is a file, not a folder"):
        gs.write(surface(), tmp_path / "file" / "F1.ts")
    with pytest.raises(OutputError, match="cannot be written"):
        gs.write(planes.units, tmp_path / "file" / "model.vtm")
    (tmp_path / "model").write_text("in the way")
    with pytest.raises(OutputError, match="cannot be written"):
        gs.write(planes.units, tmp_path / "model.vtm")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "model"]


def test_real_grids_are_written_as_their_program_wrote_them(tmp_path, shared):
    """Depth read and depth written again: every byte is that of the original."""
    folders = ("drogon_xtgeo/horizons_gri", "reek/horizons_gri")
    paths = [sorted((shared / "data" / folder).glob("*.gri"))[0] for folder in folders]
    for path in paths:
        top = gs.read_horizon(path, positive="down")
        depth = (-top).assign_attrs(top.attrs | {"positive": "down"})
        written = gs.write(depth, tmp_path / path.name)
        assert written[0].read_bytes() == path.read_bytes()
        assert written.largest_difference == 0.0
        assert [one.what for one in written.lost] == ["direction"]
        assert "depth" in written.notes[0]
        back = gs.read_horizon(gs.write(top, tmp_path / "top.irapasc")[0], positive="up")
        np.testing.assert_array_equal(back.values, top.values)
        np.testing.assert_array_equal(back.easting.values, top.easting.values)
