"""Measure units and patches: maps, tables and profiles as xarray objects with units.

================  ===============================================================
columns.py        vertical lines through wells
                  vertical lines through wells
thickness.py      isochore and isopach maps by block
                  horizons on the nodes of a grid, and what that loses at faults
faces.py          triangles of one surface, the units on both sides, its strike
                  area, dip and azimuth of surfaces
cutoffs.py        cut-off lines by wall; fault polygons
                  areas of zones that face each other; Allan diagrams
closures.py       closures of horizons, spill points, leaks at faults
throw.py          throw, heave, dip separation along a fault
                  throw of torn horizons compared with their data
                  well tops compared with the horizons of a model
walls.py          both walls of a fault: which layers face each other, what slipped past
seal.py           shale gouge ratio, smear, threshold pressure of faults
velocity.py       velocities of zones: numbers, maps, functions of depth, checkshots
time_to_depth.py  depth of a model in time, and back, along vertical lines
rock.py           rock properties by zone, region or fluid: numbers, maps, distributions
volumetrics.py    net and pore volume, fluids in place
section.py        vertical sections
                  edges -> lines and rings; lists of lines as a dataset
regions.py        regions by a place, a polygon or sides of faults; places for their names
places.py         points, tables, maps and grids that users ask about
                  the same with names, as a dataset
locate.py         which unit is at a point
================  ===============================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.measure.cutoffs import allan_diagram as allan_diagram
    from geosurf.measure.cutoffs import fault_polygons as fault_polygons
    from geosurf.measure.cutoffs import juxtaposition_table as juxtaposition_table
    from geosurf.measure.cutoffs import wall_lines as wall_lines
    from geosurf.measure.faces import faces_of as faces_of
    from geosurf.measure.faces import orientation as orientation
    from geosurf.measure.faces import side_of_words as side_of_words
    from geosurf.measure.places import sample_units as sample_units
    from geosurf.measure.section import vertical_section as vertical_section
    from geosurf.measure.thickness import thickness_map as thickness_map
    from geosurf.measure.throw import separation as separation
    from geosurf.measure.throw import throw_audit as throw_audit
    from geosurf.measure.throw import well_misfit as well_misfit
else:
    __getattr__, __all__ = lazily(__name__)
