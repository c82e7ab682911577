"""Thickness maps and Allan diagrams, judged by pixels; colours that all readers tell apart."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import xarray as xr
from matplotlib.path import Path

from geosurf.errors import GeosurfWarning, InputError
from geosurf.model import TriSurface
from geosurf.render import (
    palette,
    render_surfaces,
)
from geosurf.render.allan import _legend, _spread, draw_allan
from geosurf.render.compose import plotted
from geosurf.render.diagram import highest_in_view
from geosurf.render.furniture import Sheet, plain_number
from geosurf.render.isochores import _checked, _dense, cut_by_faults, draw_thickness
from geosurf.render.section import draw_section
from tests.measure.worlds import faulted

SIZE = (640, 400)


@pytest.fixture(scope="module")
def scene():
    return faulted((1.0, 6.0))


def pixels(path):
    from matplotlib.image import imread

    return imread(path)[:, : int(SIZE[0] * 0.76), :3]


def share(image, colour):
    """Part of the picture that has a colour, within rounding and smoothing."""
    return float((np.abs(image - np.array(colour)) < 0.02).all(axis=2).mean())


def test_an_allan_diagram_has_colours_of_the_footwall_and_stripes_of_the_hanging_wall(
    scene, tmp_path, monkeypatch
):
    monkeypatch.setattr("geosurf.render.diagram.AROUND", 99.0)  # all of the fault
    zones = ["above Top", "Top/Base", "below Base"]
    shown = scene.allan("F1"), scene.juxtaposition("F1")
    image = pixels(plotted(draw_allan, *shown, path=tmp_path / "a.png", zones=zones, size=SIZE))
    areas = scene.juxtaposition("F1").to_dataframe()
    parts = {zone: share(image, palette.stratum(i)) for i, zone in enumerate(zones)}
    frame = sum(parts.values())
    assert frame > 0.2
    # half of an area of two zones has the colour of either
    for zone, part in parts.items():
        mine = (
            areas.area
            * 0.5
            * ((areas.zone_plus == zone).astype(int) + (areas.zone_minus == zone).astype(int))
        )
        assert part / frame == pytest.approx(mine.sum() / areas.area.sum(), abs=0.06)


def test_areas_of_a_legend_have_one_unit():
    pairs = {("Top", "Base"): 3.5e6, ("Base", "Top"): 2500.0}
    colours = dict.fromkeys(("Top", "Base"), (0.0, 0.0, 0.0))
    details = [entry.detail for entry in _legend(pairs, colours)]
    assert details == ["against Base, 3.5 km²", "against Top, 0.0025 km²"]


def test_names_of_faults_stand_where_their_lines_leave_a_section():
    line = np.array([[0.0, 9.0], [4.0, 1.0], [6.0, -3.0]])  # its vertices are apart
    np.testing.assert_allclose(highest_in_view(line, 0.0, 5.0), [2.0, 5.0])
    np.testing.assert_allclose(highest_in_view(line[::-1], 0.0, 5.0), [2.0, 5.0])
    np.testing.assert_allclose(highest_in_view(line, 0.0, 9.0), [0.0, 9.0])
    np.testing.assert_allclose(highest_in_view(line, -2.0, 1.0), [4.0, 1.0])
    assert highest_in_view(line, 10.0, 11.0) is None


def test_a_diagram_shows_what_is_near_the_cutoffs(scene, tmp_path, monkeypatch):
    shown = scene.allan("F1"), scene.juxtaposition("F1")
    words = {"zones": ["above Top", "Top/Base", "below Base"], "size": SIZE}
    near = pixels(plotted(draw_allan, *shown, path=tmp_path / "a.png", **words))
    monkeypatch.setattr("geosurf.render.diagram.AROUND", 99.0)
    whole = pixels(plotted(draw_allan, *shown, path=tmp_path / "b.png", **words))
    middle, outer = palette.stratum(1), palette.stratum(2)
    assert share(near, middle) > 1.1 * share(whole, middle)
    assert 0.02 < share(near, outer) < share(whole, outer)


def test_the_same_diagram_has_the_same_bytes(scene, tmp_path):
    shown = scene.allan("F1"), scene.juxtaposition("F1")
    one, two = (
        plotted(draw_allan, *shown, path=tmp_path / f"{i}.png", size=SIZE) for i in range(2)
    )
    assert one.read_bytes() == two.read_bytes()


def test_a_diagram_and_a_table_of_two_faults_are_refused(scene, tmp_path):
    table = scene.juxtaposition("F1").assign_attrs(fault="F2")
    with pytest.raises(
        InputError, match=r"diagram is of fault 'F1', the table of fault 'F2'. Pass"
    ):
        plotted(draw_allan, scene.allan("F1"), table, path=tmp_path / "a.png")
    empty = scene.allan("F1")
    empty = empty.isel(line=np.flatnonzero(empty.kind.values == "cut-off"))
    with pytest.raises(InputError, match=r"fault 'F1' has units on one side only.*Enlarge the box"):
        plotted(draw_allan, empty, scene.juxtaposition("F1"), path=tmp_path / "a.png")


def test_names_are_spread_and_stay_in_order():
    for levels in itertools.combinations([0.0, 0.1, 0.2, 1.0, 5.0, 5.1, 9.0], 5):
        found = _spread(list(levels), 0.5)
        assert (np.diff(found) >= 0.5 - 1e-12).all()
        assert np.mean(found) == pytest.approx(np.mean(levels))


def test_a_thickness_map_shows_all_of_the_zone_and_its_polygons(scene, tmp_path):
    found = scene.thickness("Top/Base", 0.5)
    polygons = {name: scene.fault_polygons(name) for name in ("Top", "Base")}
    bare = pixels(plotted(draw_thickness, found, path=tmp_path / "a.png", size=SIZE))
    image = pixels(
        plotted(draw_thickness, found, path=tmp_path / "b.png", size=SIZE, polygons=polygons)
    )
    thick = palette.rgb(palette.THICKNESS[-1])
    assert share(bare, thick) > 0.2  # ten metres nearly everywhere
    red = [float((shown[:, :, 0] > shown[:, :, 2] + 0.3).mean()) for shown in (bare, image)]
    assert red[0] == 0.0
    assert red[1] > 5e-4


def test_neither_contours_nor_colours_follow_a_fault_through_a_zone(scene):
    """The fault dips at 45 degrees; Top is cut at its polygon, Base ten metres further down dip."""
    found = scene.thickness("Top/Base", 0.5)
    polygons = {name: scene.fault_polygons(name) for name in ("Top", "Base")}
    _, x, y = _checked(found)
    cut = cut_by_faults(x, y, polygons)
    whole = np.nansum(found.values, axis=0)
    np.testing.assert_allclose(whole[~cut], 10.0, atol=1e-9)
    assert 0.0 < (cut & (whole > 9.999)).mean() < 0.15  # a cell or two on either side
    assert not cut_by_faults(x, y, {}).any()


@pytest.mark.parametrize("seed", range(5))
def test_nodes_between_polygons_are_those_that_all_distances_find(seed):
    """Rings at any place, far from most nodes: distances of all nodes to all points of rings."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(60.0), np.arange(50.0))
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    round_ = np.column_stack([3.0 * np.cos(turn), 8.0 * np.sin(turn), 0.0 * turn])
    places = [rng.uniform(0.0, 60.0, 3) for _ in range(2)]
    rings = [round_ + place for place in (*places, places[0] + (rng.uniform(6.0, 12.0), 3.0, 0.0))]
    top, base = (
        xr.Dataset(
            {
                "easting": ("point", np.concatenate(some)[:, 0]),
                "northing": ("point", np.concatenate(some)[:, 1]),
                "count": ("line", [40] * len(some)),
                "fault": ("line", names),
            }
        )
        for some, names in ((rings[:2], ["F1", "F2"]), (rings[2:], ["F1"]))
    )
    nodes = np.column_stack([x.ravel(), y.ravel()])
    expected = np.zeros(len(nodes), dtype=bool)
    lines = [_dense(np.vstack([ring, ring[:1]])[:, :2], 0.5) for ring in rings]
    for ring in rings:
        expected |= Path(np.vstack([ring, ring[:1]])[:, :2]).contains_points(nodes)
    for one, two in ((lines[0], lines[2]), (lines[1], lines[1])):
        to = [np.hypot(*(nodes[:, None] - line[None]).transpose(2, 0, 1)) for line in (one, two)]
        across = np.hypot(*(one[:, None] - two[None]).transpose(2, 0, 1)).min(axis=1)
        nearest = to[0].argmin(axis=1)
        expected |= to[0].min(axis=1) + to[1].min(axis=1) <= across[nearest] + 2.0

    cut = cut_by_faults(x, y, {"Top": top, "Base": base}).ravel()
    assert cut.any()
    assert (cut != expected).sum() == 0


@pytest.mark.parametrize("throw", [(0.0, 0.0), (-4.0, -4.0)])
def test_flat_and_doubled_zones_are_drawn(throw, tmp_path):
    found = faulted(throw).thickness("Top/Base", 1.0)
    assert plotted(draw_thickness, found, path=tmp_path / "a.png", size=SIZE).is_file()


def test_maps_of_nothing_are_refused(scene, tmp_path):
    found = scene.thickness("Top/Base", 1.0)
    with pytest.raises(InputError, match=r"'Top/Base' has no values, or.*Use smaller cells"):
        plotted(draw_thickness, found.where(False), path=tmp_path / "a.png")
    with pytest.raises(InputError, match=r"dimensions \('northing', 'easting'\), expected block"):
        plotted(draw_thickness, found.isel(block=0), path=tmp_path / "a.png")


# what readers with red, green or blue blindness see (Machado et al. 2009, severity 1)
BLIND = {
    "none": np.eye(3),
    "red": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "green": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "blue": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def lab(colour, kind):
    """CIE 1976 L*a*b* of a colour as some eyes see it."""
    c = np.asarray(colour)
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    light = np.clip(BLIND[kind] @ light, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    f = to_xyz @ light / np.array([0.9505, 1.0, 1.089])
    f = np.where(f > 0.008856, np.cbrt(f), 7.787 * f + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("kind", BLIND)
def test_neighbours_in_the_column_and_all_faults_are_told_apart(kind):
    def apart(one, two):
        return np.linalg.norm(lab(one, kind) - lab(two, kind))

    strata = palette.STRATA
    assert min(apart(a, b) for a, b in zip(strata, strata[1:] + strata[:1], strict=True)) > 18.0
    assert min(apart(a, b) for a, b in itertools.combinations(palette.FAULTS, 2)) > 18.0
    thickness = [lab(palette.rgb(code), kind)[0] for code in palette.THICKNESS]
    assert (np.diff(thickness) < -4.0).all()  # darker is thicker


@pytest.mark.parametrize("name", ["$\\bad{", "$x$ and $y", "a_b^c"])
def test_names_are_no_formulas(scene, tmp_path, name):
    section = scene.section([(0.0, 15.0), (60.0, 15.0)])
    section["label"] = section.label.astype(object).where(section.kind != "fault", name)
    section.attrs["faults"] = [name]
    assert plotted(draw_section, section, path=tmp_path / "s.png", size=SIZE).is_file()


def test_letters_that_the_font_lacks_are_replaced_and_named_once(tmp_path):
    ramp = TriSurface("\u50a8\u5c42 A", "fault", [[0, 0, 0], [9, 0, 0], [0, 9, 5]], [[0, 1, 2]])
    with pytest.warns(GeosurfWarning, match="lacks: '\u50a8', '\u5c42'") as caught:
        render_surfaces([ramp], path=tmp_path / "s.png", size=SIZE, title="\u5c42")
    assert len(caught) == 1
    assert (tmp_path / "s.png").is_file()


def texts_of(monkeypatch, draw):
    """What a picture says, in words."""
    said, text = [], Sheet.text
    monkeypatch.setattr(
        Sheet,
        "text",
        lambda self, at, words, *a, **k: (said.append(words), text(self, at, words, *a, **k)),
    )
    draw()
    return said


@pytest.mark.parametrize("height", [70.0, 0.001, 1234.5])
@pytest.mark.parametrize("faulted", [False, True])
def test_the_key_says_everywhere_only_where_that_is_true(tmp_path, monkeypatch, height, faulted):
    """A level zone is thinner where a fault cuts through it: mean and largest differ there."""
    values = np.full((1, 20, 30), height)
    ring = xr.Dataset(
        {"easting": ("point", [9.0, 12, 12, 9]), "northing": ("point", [-9.0, -9, 99, 99]),
         "fault": ("line", ["F1"]), "count": ("line", [4]), "kind": ("line", ["gap"])}
    )  # fmt: skip
    if faulted:
        values[:, :, 9:13] *= 0.5
    coords = {"block": ["all"], "northing": np.arange(20.0), "easting": np.arange(30.0)}
    found = xr.DataArray(values, coords, ("block", "northing", "easting"), attrs={"zone": "A/B"})
    polygons = {"A": ring} if faulted else {}
    said = texts_of(
        monkeypatch,
        lambda: plotted(
            draw_thickness, found, path=tmp_path / "m.png", polygons=polygons, size=SIZE
        ),
    )
    mean, most = f"mean {values.mean():.4g} m", f"max {height:.4g} m"
    assert f"{mean}, {most}" in said
    where = "away from faults" if faulted else "everywhere"
    assert f"{where} {plain_number(height)} m" in said
    assert sum("everywhere" in words for words in said) == (not faulted)


def test_blocks_that_add_up_to_one_thickness_are_not_said_to_have_it_everywhere(
    tmp_path, monkeypatch
):
    values = np.full((2, 20, 30), np.nan)
    values[0, :, :15], values[1, :, 15:] = 70.0, 70.0
    values[:, :, 14] = [[30.0], [40.0]]  # the fault runs through these cells
    coords = {"block": ["F1-", "F1+"], "northing": np.arange(20.0), "easting": np.arange(30.0)}
    found = xr.DataArray(values, coords, ("block", "northing", "easting"), attrs={"zone": "A/B"})
    said = texts_of(
        monkeypatch, lambda: plotted(draw_thickness, found, path=tmp_path / "m.png", size=SIZE)
    )
    assert "all blocks together 70 m" in said
    assert not any("everywhere" in words for words in said)
