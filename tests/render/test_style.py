"""Styles, cameras, colourings, names and overlays of pictures."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.image import imread
from matplotlib.text import Text

from geosurf.conventions import palette
from geosurf.errors import InputError
from geosurf.render.colouring import Selection, check_colour_by
from geosurf.render.compose import plotted
from geosurf.render.layers import shortened_apart
from geosurf.render.map import draw_map
from geosurf.render.overlay import PictureOverlay
from geosurf.render.picture_style import DARK_PAPER, PictureStyle
from geosurf.render.sheet import _joins_letters
from geosurf.render.surface_layers import show_units
from geosurf.scene.plots import ScenePlots
from tests.messages import refused

SMALL = (320, 220)


def pixels(path):
    return imread(path)[..., :3]


def part(image, colour, near=0.02):
    """Part of the picture in a colour."""
    return (np.abs(image - colour) < near).all(axis=2).mean()


def test_themes_change_the_background_and_no_zone(scene, tmp_path):
    images = {}
    looks = {"light": {}, "dark": {"theme": "dark"}, "none": {"transparent": True}}
    for name, style in looks.items():
        path = tmp_path / f"{name}.png"
        scene.plot.view(path=path, show=["units"], size=SMALL, style=PictureStyle(**style))
        images[name] = imread(path)
    assert part(images["light"][..., :3], palette.PAPER) > 0.5
    assert part(images["dark"][..., :3], DARK_PAPER) > 0.5

    # a transparent picture on white is the light one, but for the rounding of edges
    clear = images["none"]
    assert (clear[..., 3] == 0.0).mean() > 0.5
    on_white = clear[..., :3] * clear[..., 3:] + 1.0 - clear[..., 3:]
    assert np.abs(on_white - images["light"][..., :3]).mean() < 0.004
    model = (clear[..., 3] == 1.0) & (
        np.abs(clear[..., :3] - images["light"][..., :3]).max(2) < 0.01
    )
    assert part(images["dark"][model][None, :, :3], images["light"][model][None, :, :3]) > 0.8


def test_only_selects_surfaces_units_zones_and_blocks(scene, units, tmp_path):
    assert len(show_units(units).legend) == 6
    path = tmp_path / "x.png"
    for only, count in ((["Top/Base"], 2), (["F1-"], 3), (["below Base F1+"], 1)):
        scene.plot.view(path=path, show=["units"], only=only, size=SMALL)
        assert pixels(path).min() < 0.9
        assert len(show_units(units, only=Selection(tuple(only))).legend) == count
    ScenePlots(scene).view(path=path, only=["Base"], show=["horizons"], size=SMALL)
    assert part(pixels(path), palette.stratum(0), 0.05) < 0.005


def test_numbers_of_units_become_colours_with_a_bar(units):
    volumes = {name: unit.volume for name, unit in units.items()}
    by_name = show_units(units, colour_by=volumes)
    as_array = show_units(units, colour_by=np.array(list(volumes.values())))
    colours = [layer.colour for layer in by_name.layers]
    assert colours == [layer.colour for layer in as_array.layers]
    assert by_name.bar is not None
    largest = max(volumes, key=volumes.__getitem__)
    darkest = min(by_name.legend, key=lambda entry: sum(entry.colour))
    assert darkest.label == largest

    # no value: grey; another number of values or another name: an error
    assert show_units(units, colour_by={largest: 1.0}).legend[0].detail in ("no value", "1")
    refused(InputError, "2 numbers for 6 units", show_units, units, colour_by=[1.0, 2.0])
    refused(InputError, "'Nope', which is not a unit", show_units, units, colour_by={"Nope": 1.0})
    refused(InputError, "Use one of unit, zone", lambda: check_colour_by(object()))


@given(st.lists(st.text("ab1/ _", min_size=1, max_size=60), max_size=12), st.integers(10, 34))
def test_different_names_have_different_short_labels(names, most):
    labels = shortened_apart(names, most)
    assert set(labels) == set(names)
    assert len(set(labels.values())) == len(labels)
    assert all(len(label) <= most for label in labels.values())
    assert all(labels[name] == name for name in names if len(name) <= most)


@pytest.mark.parametrize("name", ["Верх", "Κορυφή", "قمة"])
def test_cyrillic_greek_and_arabic_have_letters(top, name):
    with warnings.catch_warnings(record=True, action="always") as found:
        picture = plotted(draw_map, top.renamed(name), size=SMALL)._repr_png_()
    apart = name == "قمة" and not _joins_letters()  # by older versions of matplotlib
    assert ["letters apart" in str(one.message) for one in found] == [True] * apart
    assert picture != plotted(draw_map, top.renamed("Top"), size=SMALL)._repr_png_()


def test_an_overlay_is_drawn_on_views_maps_and_sections(scene, top, curves, tmp_path):
    overlay = PictureOverlay(
        wells={"W": [[458000, 6781500, -1700], [458000, 6781500, -2500]]},
        polygons={"Licence": [[456500, 6780500], [459500, 6780500], [459500, 6782500]]},
        points={"Picks": [[458500, 6782000, -1750.0]]},
    )
    path = tmp_path / "x.png"
    ScenePlots(scene).view(path=path, overlay=overlay, size=(640, 400))
    purple, pink = palette.rgb("#5b2a86"), palette.rgb("#b3005e")
    assert part(pixels(path), purple, 0.1) > 5e-4
    assert part(pixels(path), pink, 0.1) > 5e-5
    figure = plotted(draw_map, top, curves, size=SMALL, overlay=overlay)
    assert "W" in [text.get_text() for text in figure.axes[1].texts]
    figure = ScenePlots(scene).section([(457000, 6781000), (460000, 6781000)], overlay=overlay)
    words = [text.get_text() for text in figure.findobj(Text)]
    assert "within 60 m" in words  # nothing is: no numbers of what is elsewhere
    assert not {"1 well", "1 data point, within 60 m"} & set(words)
    outline = [[0, 0, 0], [9, 0, 0], [9, 9, 0]]
    assert PictureOverlay(polygons={"A": outline}).polygons["A"][0].shape == (3, 2)
    for wrong in ({"wells": {"W": [1, 2]}}, {"points": {"P": [[0, 0, np.nan]]}}, {"points": 3}):
        with pytest.raises(InputError):
            PictureOverlay(**wrong)
