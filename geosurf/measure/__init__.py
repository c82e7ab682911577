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

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.measure.cutoffs import fault_polygons as fault_polygons
    from geosurf.measure.cutoffs import wall_lines as wall_lines
    from geosurf.measure.dips import orientation as orientation
    from geosurf.measure.faces import faces_of as faces_of
    from geosurf.measure.faces import side_of_words as side_of_words
    from geosurf.measure.juxtaposition import allan_diagram as allan_diagram
    from geosurf.measure.juxtaposition import juxtaposition_table as juxtaposition_table
    from geosurf.measure.misfit import well_misfit as well_misfit
    from geosurf.measure.sample import sample_units as sample_units
    from geosurf.measure.section import vertical_section as vertical_section
    from geosurf.measure.thickness import thickness_map as thickness_map
    from geosurf.measure.throw import separation as separation
else:
    __getattr__, __all__ = lazily(__name__)
