"""Thickness maps and Allan diagrams, judged by pixels; colours that all readers tell apart."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text

from geosurf.conventions import palette
from geosurf.errors import GeosurfWarning
from geosurf.model import TriSurface
from geosurf.render import render_place
from geosurf.render.allan import draw_allan
from geosurf.render.compose import plotted
from geosurf.render.furniture import Sheet, plain_number
from geosurf.render.isochores import _checked, cut_by_faults, draw_thickness
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
    shown = scene.allan("F1"), scene.juxtaposition("F1", "all")
    image = pixels(plotted(draw_allan, *shown, path=tmp_path / "a.png", zones=zones, size=SIZE))
    areas = scene.juxtaposition("F1", "all").to_dataframe()
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
    none = dict.fromkeys(polygons, polygons["Top"].isel(line=slice(0, 0)))
    for shown in (polygons, none):
        figure = plotted(draw_thickness, found, size=SIZE, polygons=shown)
        words = {text.get_text() for text in figure.findobj(Text)}
        assert ("Fault polygons" in words) == (shown is polygons)


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


def test_letters_that_the_font_lacks_are_replaced_and_named_once(tmp_path):
    ramp = TriSurface("\u50a8\u5c42 A", "fault", [[0, 0, 0], [9, 0, 0], [0, 9, 5]], [[0, 1, 2]])
    with pytest.warns(GeosurfWarning, match="lacks: '\u50a8', '\u5c42'") as caught:
        render_place([ramp], (0, 0, 0), tmp_path / "s.png", size=SIZE, title="\u5c42")
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
    assert f"Thickness {where}: {plain_number(height)} m" in said
    assert sum("everywhere" in words for words in said) == (not faulted)
