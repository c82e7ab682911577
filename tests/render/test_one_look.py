"""Pictures of one scene agree: colours of units, contacts on maps, directions, depths."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.patches import PathPatch

import geosurf as gs
from geosurf.errors import InputError
from geosurf.measure.columns import residuals
from geosurf.render.colouring import colour_units
from geosurf.render.picture_style import PLAIN
from geosurf.scene.plots import fluids_on
from geosurf.scene.shown import IGNORED, USED, data_of
from tests.grids import ring_area
from tests.messages import refused

SMALL = (640, 400)


@pytest.fixture(scope="module")
def scene(graben):
    return graben.replace(contacts={"OWC": -2100.0})


def top_of(unit, horizon):
    """Map area [m2] of the part of a unit's upper side that is a horizon."""
    corners = unit.local[unit.triangles][:, :, :2]
    sides = corners[:, 1:] - corners[:, :1]
    up = 0.5 * (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    mine = unit.surface_of_triangle == unit.surface_names.index(horizon)
    return float(up[mine & (up > 0)].sum())


def test_a_unit_has_one_colour_in_sections_and_views(scene):
    colours = colour_units(scene.units, [*scene.units.values()], "unit", PLAIN).colours
    west, east, south, north = scene.box[:4]
    middle = 0.5 * (south + north)
    figure = scene.plot.section([(west, middle), (east, middle)], size=SMALL)
    drawn = {to_rgb(p.get_facecolor()) for p in figure.axes[1].artists + figure.axes[1].patches}
    drawn |= {to_rgb(p.get_facecolor()) for p in figure.findobj(PathPatch)}
    section = scene.section([(west, middle), (east, middle)])
    crossed = {str(name) for name in section.label.values} & set(scene.units.included())
    assert crossed
    for name in crossed:
        assert min(np.abs(np.subtract(colours[name], one)).max() for one in drawn) < 1e-6, name


def test_the_fill_above_a_contact_is_the_map_area_of_the_units_there(scene):
    for name in ("Top", "Base"):
        for area in fluids_on(scene, name):
            units = [
                unit
                for unit in scene.units.included().values()
                if unit.contact == area.interval and unit.zone.startswith(f"{name}/")
            ]
            assert sum(map(ring_area, area.rings)) == pytest.approx(
                sum(top_of(unit, name) for unit in units), rel=1e-9
            )
            assert len(area.lines) > 0


@pytest.mark.parametrize("turned", [False, True])
def test_allan_diagrams_have_west_or_south_on_the_left(turned):
    world = gs.synthetic.graben(n=9)
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    surface = gs.TriSurface("F1", "fault", fault.vertices, fault.triangles)
    if turned:  # dips the other way: its strike turns around
        west, east = world.box[:2]
        surface = gs.triangulate_fault(
            (fault.vertices * (-1, 1, 1) + (west + east, 0, 0), fault.triangles), name="F1"
        )
    scene = gs.Scene(world.horizons, {"F1": surface}, world.box)
    figure = scene.plot.allan("F1", size=SMALL)
    ends = [text.get_text() for text in figure.axes[1].texts]
    winds = [word for word in ends if word in ("N", "NE", "E", "SE", "S", "SW", "W", "NW")]
    assert winds[0] in ("S", "SW", "W", "NW")


def test_scenes_of_depths_show_depths():
    world = gs.synthetic.graben(n=9)
    down = {}
    for name, grid in world.horizons.items():
        down[name] = -grid
        down[name].attrs.pop("positive", None)
    scene = gs.Scene(down, world.faults, world.box, positive="down", length_unit="m")
    west, east, south, _ = world.box[:4]
    for words, shown in (({}, "Depth [m]"), ({"vertical": "elevation"}, "Elevation [m]")):
        figure = scene.plot.section(
            [(west, south + 10), (east, south + 10)], size=SMALL, style=gs.PictureStyle(**words)
        )
        axes = figure.axes[1]
        labels = [text.get_text() for text in axes.get_yticklabels()]
        assert axes.get_ylabel() == shown
        assert all(label.startswith("\N{MINUS SIGN}") for label in labels) == bool(words)


def test_residuals_of_a_torn_horizon_are_those_of_its_smear():
    world = gs.synthetic.torn("normal", n=41, smear=2)
    scene = gs.Scene(world.horizons, world.faults, tear=True)
    sheet = scene.sheets["Top"]
    parts = data_of(sheet, world.horizons["Top"], "Top", {})
    assert sum(map(len, parts.values())) == 41 * 41
    used, ignored = (residuals(sheet.surface, parts[key]) for key in (USED, IGNORED))
    assert np.nanmax(np.abs(used)) < 1e-6
    throw = np.nanmax(np.abs(sheet.cuts["F1"].throw))
    assert 0.1 * throw < np.nanmax(np.abs(ignored)) < throw

    # pictures: all data once, and a section that crosses the fault
    figure = scene.plot.residuals("Top", size=SMALL)
    assert any("20 m" in text.get_text() for text in figure.axes[0].texts)
    assert scene.plot.picks("F1", size=SMALL).axes[1].get_xlim()[0] == 0.0
    refused(InputError, "at is 2", scene.plot.picks, "F1", at=2)
    again = gs.Scene(scene.sheets, world.faults, scene.box)
    refused(InputError, r"data=gs\.read_horizon", again.plot.residuals, "Top")
    assert again.plot.residuals("Top", data=world.horizons["Top"], size=SMALL)
