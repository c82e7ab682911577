"""What maps and sections of a scene show: surfaces, lines, well tops, thickness."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import GeosurfWarning
from geosurf.model import Curves, SheetReport, TriSurface
from geosurf.model.expected import flag_of
from geosurf.model.protocols import MeasuredModel
from geosurf.render.map import MAX_MAP_TRIANGLE
from geosurf.render.picture_style import PictureStyle
from geosurf.render.thin_units import as_modelled
from geosurf.scene.virtual_walls import lines_on
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

CELLS = 200  # of a thickness map, along the longer side of the box


def map_of(
    scene: MeasuredModel, name: str, clip: bool
) -> tuple[TriSurface, Curves, dict[str, Any]]:
    """What a map of a horizon shows: surface, curves, and the other arguments of `draw_map`."""
    west, east, south, north = scene.box[:4]

    # the outline that clips: the area of interest, or the box in the map
    ring = np.array([(west, south), (east, south), (east, north), (west, north)])
    inside = ring if scene.aoi is None else scene.aoi
    surface = scene.surface(name)
    options = {
        "outline": inside if flag_of(clip, "clip") else None,
        "faults": scene.fault_names,
        "tops": tops_of_scene(scene),
        "hatched": surface,
        "remedies": _remedies(scene, name),
        "virtual_walls": lines_on(scene.patches, name) if scene.virtual_walls else {},
    }
    return as_modelled(scene, surface, MAX_MAP_TRIANGLE), scene.curves, options


def _remedies(scene: MeasuredModel, name: str) -> tuple[GeosurfWarning, ...]:
    """What closed the tear of a horizon where its faults alone did not."""
    sheet = scene.sheets.get(name)
    report = None if sheet is None else sheet.report
    return report.remedies if isinstance(report, SheetReport) else ()


def tops_of_scene(scene: MeasuredModel) -> Any:
    """The misfits of the well tops, if the scene has some."""
    return None if scene.tops is None else scene.misfit()


def thickness_of(
    scene: MeasuredModel, zone: str, grid: Any
) -> tuple[xarray.DataArray, dict[str, xarray.Dataset]]:
    """Thickness map of a zone, and the fault polygons of the horizons above and below."""
    if grid is None:
        # CELLS along the longer side, whatever the size of the field: pictures have that many
        # pixels to show
        west, east, south, north = scene.box[:4]
        grid = max(east - west, north - south) / CELLS
    thickness = scene.thickness(zone, grid)
    names = [name for name in zone.split("/") if name in scene.horizon_names]
    return thickness, {name: scene.fault_polygons(name) for name in names}


def neighbours(scene: MeasuredModel) -> list[tuple[str, str]]:
    """Pairs of horizons with a zone between them, youngest first."""
    # only zones that have units: the column or the box may have removed one, and its neighbours
    # then name the zone
    zones = {unit.zone for unit in scene.units.values()}
    names = scene.horizon_names
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    return [(a, b) for a, b in pairs if f"{a}/{b}" in zones]


def cut_horizons(scene: MeasuredModel, fault: str) -> list[str]:
    """Names of the horizons that a fault cuts, youngest first."""
    return [name for name in scene.horizons_inside if scene.cutoffs(name, fault)]


def middle_lines(box: Sequence[float]) -> list[np.ndarray]:
    """Lines through the middle of a box, from west to east and from south to north."""
    west, east, south, north = box[:4]
    x, y = 0.5 * (west + east), 0.5 * (south + north)
    return [np.array([(west, y), (east, y)]), np.array([(x, south), (x, north)])]


def warn_of_colours(scene: MeasuredModel, style: PictureStyle) -> None:
    """Warn of colours for names that the model does not have."""
    if not style.colours:
        return
    known = {*scene.horizon_names, *scene.fault_names}
    for unit in scene.units.values():
        known |= {unit.name, unit.zone, unit.block, unit.contact}
    for name in style.colours:
        if name not in known:
            guess = did_you_mean(name, known)
            effect = f"No surface, zone, block or unit is called {name!r}: its colour is not used."
            warn(GeosurfWarning("picture", "colours", effect, f"Correct the name.{guess}"))
