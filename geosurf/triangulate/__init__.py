"""Gridded data, sticks and boxes -> `TriSurface`.

==============  ==================================================
horizon.py      a gridded horizon: checks, and one diagonal rule
stored.py       grids in a store: read into memory, or in bands where they do not fit
fault.py        a fault in any of its forms: grid, sticks, mesh
mesh.py         a horizon or fault from vertices and triangles
neighbours.py   surfaces and lines of other packages
sticks.py       fault sticks: orient, order along strike, join
fault_polygons.py fault polygons of horizons: both cut-off lines, and beyond
orient.py       normals of faults: into the hanging wall
walls.py        the six sides of the model box, or a fence around a polygon
outline.py      a polygon: refused where it meets itself, triangulated
box.py          the default model box
footprint.py    where a horizon is in the map: its rim
shared_area.py  the default area: the outline that all horizons share
inward.py       polygons that shrink: fewer corners, sides moved inward
rims.py         sides along the rim of a horizon, moved off it by a stated amount
reprojection.py easting and northing in another coordinate reference system
contacts.py     fluid contacts: levels and grids
degenerate.py   triangles without area, found exactly
==============  ==================================================
"""

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.triangulate.contacts import build_contacts as build_contacts
    from geosurf.triangulate.fault import triangulate_fault as triangulate_fault
    from geosurf.triangulate.fault_polygons import fault_from_polygons as fault_from_polygons
    from geosurf.triangulate.horizon import triangulate_horizon as triangulate_horizon
    from geosurf.triangulate.orient import orient_fault as orient_fault
    from geosurf.triangulate.reprojection import reproject as reproject
    from geosurf.triangulate.sticks import triangulate_sticks as triangulate_sticks
    from geosurf.triangulate.walls import build_walls as build_walls
else:
    __getattr__, __all__ = lazily(__name__)
