"""Measure units and patches: maps, tables and profiles as xarray objects with units.

================  ===============================================================
columns.py        vertical lines through closed shells
thickness.py      isochore and isopach maps by block
faces.py          triangles of one surface, the units on both sides, its strike
lines.py          edges -> lines and rings; lists of lines as a dataset
cutoffs.py        cut-off lines by wall; fault polygons
throw.py          throw, heave, dip separation along a fault
juxtaposition.py  areas of zones that face each other; Allan diagrams
section.py        vertical sections
dips.py           area, dip and azimuth of surfaces
well_columns.py   vertical lines through wells
misfit.py         well tops compared with the horizons of a model
places.py         points, tables, maps and grids that users ask about
locate.py         which unit is at a point
sample.py         the same with names, as a dataset
================  ===============================================================
"""

from __future__ import annotations

from geosurf.measure.cutoffs import fault_polygons, wall_lines
from geosurf.measure.dips import orientation
from geosurf.measure.faces import faces_of, side_of_words
from geosurf.measure.juxtaposition import allan_diagram, juxtaposition_table
from geosurf.measure.misfit import well_misfit
from geosurf.measure.sample import sample_units
from geosurf.measure.section import vertical_section
from geosurf.measure.thickness import thickness_map
from geosurf.measure.throw import separation

__all__ = [
    "allan_diagram",
    "faces_of",
    "fault_polygons",
    "juxtaposition_table",
    "orientation",
    "sample_units",
    "separation",
    "side_of_words",
    "thickness_map",
    "vertical_section",
    "wall_lines",
    "well_misfit",
]
