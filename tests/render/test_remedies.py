"""Maps mark the places where a tear needed a remedy."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import geosurf as gs
from geosurf.conventions import palette
from geosurf.render.map import draw_remedies
from geosurf.render.sheet import Sheet, lay_out


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
