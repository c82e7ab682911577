"""Figures of matplotlib: into the axes of a user, in world coordinates, and as vector files."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import geosurf as gs
from geosurf.conventions import palette
from geosurf.errors import InputError
from geosurf.render.compose import plotted
from geosurf.render.diagram import draw_throw
from geosurf.render.map import draw_remedies
from geosurf.render.overlay import NEAR, tops_on_map, tops_on_section
from geosurf.render.sheet import Sheet, lay_out
from tests.grids import gridded

X, Y = 456_000.0, 6_780_000.0


def moved(da):
    """A grid at UTM coordinates."""
    return da.assign_coords(easting=da.easting + X, northing=da.northing + Y)


@pytest.fixture(scope="module")
def scene():
    world = gs.synthetic.torn(n=17)
    horizons = {name: moved(da) for name, da in world.horizons.items()}
    base = moved(world.horizons["Top"] - 90.0).assign_attrs(world.horizons["Top"].attrs)
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    wall = gs.TriSurface("F1", "fault", fault.vertices + np.array([X, Y, 0.0]), fault.triangles)
    w, e, s, n, low, high = world.box
    box = (w + X, e + X, s + Y, n + Y, low - 100.0, high)
    return gs.Scene({**horizons, "Base": base}, {"F1": wall}, box, tear=True)


def line_through(scene):
    w, e, s, n, _, _ = scene.box
    return [(w, 0.5 * (s + n)), (e, 0.5 * (s + n))]


PLOTS = {
    "map": lambda scene, ax: scene.plot.map("Top", ax=ax),
    "thickness": lambda scene, ax: scene.plot.thickness("Top/Base", 50.0, ax=ax),
    "section": lambda scene, ax: scene.plot.section(line_through(scene), ax=ax),
    "allan": lambda scene, ax: scene.plot.allan("F1", ax=ax),
    "throw": lambda scene, ax: scene.plot.throw("F1", ax=ax),
    "column": lambda scene, ax: scene.plot.column(ax=ax),
}


@pytest.mark.parametrize("plot", PLOTS)
def test_each_plot_is_a_figure_or_goes_into_axes(scene, plot):
    own = PLOTS[plot](scene, None)
    assert isinstance(own, Figure)
    if plot == "column":  # the quickest to draw
        assert own._repr_png_().startswith(b"\x89PNG")

    # nothing is drawn outside the axes of a user, but for a colour bar
    figure = Figure(figsize=(8, 4))
    mine, other = figure.subplots(1, 2)
    assert PLOTS[plot](scene, mine) is figure
    assert not [*other.lines, *other.patches, *other.collections, *other.texts]
    assert mine.lines or mine.patches or mine.collections
    assert len(figure.axes) <= 3


def test_figures_can_be_pickled(scene):
    for figure in (scene.plot.map("Top"), scene.plot.view(size=(300, 200))):
        assert pickle.loads(pickle.dumps(figure))._repr_png_() == figure._repr_png_()


def test_maps_have_world_coordinates(scene):
    ax = Figure().subplots()
    scene.plot.map("Top", ax=ax)
    w, e, s, n, _, _ = scene.box
    np.testing.assert_allclose([*ax.get_xlim(), *ax.get_ylim()], [w, e, s, n], atol=1.0)
    assert ax.get_aspect() == 1.0
    drawn = np.concatenate([np.concatenate(c.get_segments()) for c in ax.collections
                            if hasattr(c, "get_segments")])  # fmt: skip
    assert (drawn.min(axis=0) >= (w - 1, s - 1)).all()
    assert (drawn.max(axis=0) <= (e + 1, n + 1)).all()


def test_the_throw_that_is_drawn_is_the_throw(scene):
    ax = Figure().subplots()
    scene.plot.throw("F1", ax=ax)
    drawn = np.concatenate([line.get_xydata() for line in ax.lines if len(line.get_xdata()) > 2])
    for name in ("Top", "Base"):
        throw = scene.throw(name, "F1")
        known = np.isfinite(throw.throw.values)
        points = np.column_stack([throw.along_strike.values, throw.throw.values])[known]
        assert {tuple(p) for p in points} <= {tuple(p) for p in drawn}
    assert np.nanmax(drawn[:, 1]) > 20.0
    # a band where the data show a throw: beside this fault, there are too few for a trend
    assert not ax.collections
    assert "Dotted" not in " ".join(t.get_text() for t in scene.plot.throw("F1").findobj(Text))


def test_the_legend_of_a_throw_picture_names_horizons_without_a_line():
    # the fault is straight at Top, turns back along its strike at Base, and ends above Deep
    axis = np.linspace(0.0, 1000.0, 11)
    levels = {"Top": -100.0, "Base": -300.0, "Deep": -600.0}
    horizons = {name: gridded(np.full((11, 11), z), axis) for name, z in levels.items()}
    straight = [(500, 200), (500, 400), (500, 600), (500, 800)]
    turning = [(520, 200), (480, 560), (560, 440), (500, 800)]
    rows = {-50.0: straight, -200.0: straight, -250.0: turning, -350.0: turning}
    points = [(*point, z) for z, row in rows.items() for point in row]
    cells = [row + k for row in (0, 4, 8) for k in range(3)]
    triangles = [t for i in cells for t in ((i, i + 1, i + 4), (i + 1, i + 5, i + 4))]
    fault = gs.TriSurface("F1", "fault", points, triangles)
    scene = gs.Scene(horizons, {"F1": fault}, (0, 1000, 0, 1000, -700, 0))
    ax = Figure().subplots()
    with pytest.warns(gs.GeosurfWarning, match="does not show 'Base': the cut-off line"):
        scene.plot.throw("F1", ax=ax)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "Top: 0 to 0 m",
        "Base: not measured, see warnings",
        "Deep: not cut by this fault",
    ]


def test_the_column_has_the_mean_thickness_of_zones(scene):
    ax = Figure().subplots()
    scene.plot.column(ax=ax)
    table = scene.units.table
    for zone in dict.fromkeys(table.zone.values.tolist()):
        mine = table.zone.values == zone
        mean = table.volume.values[mine].sum() / table.map_area.values[mine].sum()
        words = f"{zone}\n{mean:.0f} m" if zone in scene.reservoir else zone
        assert words in [text.get_text() for text in ax.texts]
    assert "Base" in [text.get_text() for text in ax.texts]


def test_a_thickness_map_may_be_of_what_lies_above_a_contact(scene):
    z = scene.units["Top/Base"].vertices[:, 2]
    cut = scene.replace(contacts={"OWC": float(0.5 * (z.min() + z.max()))})
    figure = cut.plot.thickness("Top/Base", contact="above OWC")
    titles = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert "Top/Base, above OWC: isochore map" in titles
    with pytest.raises(InputError, match="no contact interval 'OWC'"):
        cut.plot.thickness("Top/Base", contact="OWC")


@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png"])
def test_files_have_the_same_bytes_twice(scene, tmp_path, suffix):
    found = []
    for name in ("a", "b"):
        path = plotted(
            draw_throw, {"Top": scene.throw("Top", "F1")}, path=tmp_path / f"{name}{suffix}"
        )
        found.append(path.read_bytes())
    assert found[0] == found[1]
    assert not re.search(rb"20[0-9]{2}-[01][0-9]-[0-3][0-9]", found[0])


def test_zones_of_a_grid_have_the_colours_of_sections(scene, tmp_path):
    """The first zone of a grid is the second of the model."""
    from matplotlib.image import imread

    grid = gs.build_grid(scene, cell=500, layers={"Top/Base": 2})
    path = gs.render_grid_section(grid, tmp_path / "row.png", size=(400, 250))
    pixels = np.round(255 * imread(path)[:, :, :3]).astype(int).reshape(-1, 3)
    counts = [
        (np.abs(pixels - np.round(255 * np.array(palette.stratum(k)))) <= 1).all(axis=1).sum()
        for k in range(3)
    ]
    assert counts[1] > 500
    assert counts[0] == counts[2] == 0


# ---- Wells on maps and sections: which tops are drawn, where, and what is refused.
@pytest.fixture(scope="module")
def model(graben):
    """A scene and the misfits of its tops: two wells on the middle line, one far off."""
    rows = [
        (well, horizon, east, north, -2100.0)
        for well, east, north in (("25/4-1", 900.0, 1500.0), ("B", 2000.0, 1530.0), ("C", 900, 9))
        for horizon in ("Top", "Base")
    ]  # fmt: skip
    names = ("well", "horizon", "easting", "northing", "elevation")
    tops = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    return graben.replace(tops=tops)


def test_a_map_has_the_tops_of_its_horizon(model):
    shown = tops_on_map(model.misfit(), "Base")
    assert [(top.well, top.horizon) for top in shown] == [
        ("25/4-1", "Base"), ("B", "Base"), ("C", "Base"),
    ]  # fmt: skip
    assert shown[1].place.tolist() == [2000.0, 1530.0]


def test_a_section_has_the_tops_near_it_by_distance_along_it(model):
    bent = np.array([[0.0, 1500.0], [1500.0, 1500.0], [1500.0, 2500.0], [4000.0, 2500.0]])
    shown, near = tops_on_section(model.misfit(), bent)
    assert near == pytest.approx(NEAR * 5000.0)
    assert [(top.well, top.place.tolist()) for top in shown] == [
        ("25/4-1", [900.0, -2100.0]), ("25/4-1", [900.0, -2100.0]),
    ]  # fmt: skip
    straight = np.array([[100.0, 1500.0], [4000.0, 1500.0]])
    shown, _ = tops_on_section(model.misfit(), straight)
    assert [top.well for top in shown] == ["25/4-1"] * 2 + ["B"] * 2
    assert [top.place[0] for top in shown] == [800.0, 800.0, 1900.0, 1900.0]


# ---- Maps mark the places where a tear needed a remedy.
def remedy(kind, place):
    return gs.GeosurfWarning(kind, "F1", "Something was done.", "Do it yourself.", place)


def test_each_place_on_the_map_is_marked_once():
    sheet = Sheet(lay_out((640, 400)))
    axes = Figure().add_subplot()
    axes.set_xlim(1000, 1100)
    axes.set_ylim(2000, 2100)
    listed = [
        remedy("tear left out", (1040.0, 2060.0, -5.0)),
        remedy("wall made level", (1010.0, 2020.0, -5.0)),
        remedy("fault extended", (5000.0, 2020.0, -5.0)),  # off the map
        remedy("trim changed", None),
    ]
    (entry,) = draw_remedies(sheet, axes, listed)
    assert entry.label == "2 places of remedies"
    assert entry.detail == "tear left out: 1, wall made level: 1"
    places = sorted((float(x), float(y)) for line in axes.lines for x, y in line.get_xydata())
    assert places == [(1010.0, 2020.0), (1040.0, 2060.0)]
    assert all(np.allclose(line.get_markeredgecolor(), palette.ACCENT) for line in axes.lines)
    assert draw_remedies(sheet, axes, listed[2:]) == []
