"""Gridded data, sticks and boxes -> `TriSurface`.

==============  ==================================================
horizon.py      a horizon in any of its forms: grid, mesh; one diagonal rule
grids.py        arrays of xarray: checked, in metres; those in a store read into memory, or in
                bands where they do not fit
decimate.py     every k-th node of a grid, with the error that this makes
spikes.py       nodes that stand out from all around them
fault.py        a fault in any of its forms: grid, sticks, mesh
                fluid contacts: levels and grids
fault_polygons  fault polygons of horizons: both cut-off lines, and beyond
mesh.py         a horizon or fault from vertices and triangles
                triangles without area, found exactly; closed bodies and folds of horizons
                normals of faults: into the hanging wall
neighbours.py   surfaces and lines of other packages
                easting and northing in another coordinate reference system
sticks.py       fault sticks: orient, order along strike, join
outline.py      a polygon: refused where it meets itself, triangulated
                the six sides of the model box, or a fence around a polygon
                sides along the rim of a horizon, moved off it by a stated amount
                polygons that shrink: fewer corners, sides moved inward
footprint.py    where a horizon is in the map: its rim
                the default model box
shared_area.py  the default area: the outline that all horizons share
==============  ==================================================
"""

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.triangulate.fault import build_contacts as build_contacts
    from geosurf.triangulate.fault import triangulate_fault as triangulate_fault
    from geosurf.triangulate.fault_polygons import fault_from_polygons as fault_from_polygons
    from geosurf.triangulate.fault_polygons import propose_dip as propose_dip
    from geosurf.triangulate.horizon import triangulate_horizon as triangulate_horizon
    from geosurf.triangulate.mesh import orient_fault as orient_fault
    from geosurf.triangulate.neighbours import reproject as reproject
    from geosurf.triangulate.outline import build_walls as build_walls
    from geosurf.triangulate.sticks import triangulate_sticks as triangulate_sticks
else:
    __getattr__, __all__ = lazily(__name__)
