"""Carve patches into closed units, named by zone, fault block and fluid contact, and certify them.

===================  ==================================================================
units.py             `carve_units`: the steps from patches to units
cells.py             cells of space and the faces between them (Weiler model, Levy 2024)
                     which sides of triangles face each other across an edge
                     where parts end, and the order of triangles around edges
measures.py          volume below, area and bounds of each face
                     compensated and exact volumes (Dekker 1971, Shewchuk 1997)
zones.py             on which side of each horizon and contact each cell is
                     blocks of a zone, named by the sides of faults
column.py            rules of the stratigraphic column: sides of horizons -> zones
                     sides of triangles of a fault, which may end at a horizon
clipped.py           parts of horizons that these rules removed
                     triangles of some faces, one by one
fluids.py            units split at their fluid contacts
                     volumes of the parts of finished units at level contacts
                     warning: horizons in the wrong order
                     warning: units thinner than the rounding error
regions.py           blocks of the zones of a field that belong together
                     which neighbour each sliver becomes a part of
outside.py           walls, and the cells outside of them
                     exact vertical rays through triangles
shells.py            closed shells and their volumes
certificate.py       `certify`: the properties of a model, recomputed from the result
certificate_lines    its lines in their order, from their facts
certificate_facts    what is read from the model: its runs, and its other triangles
certificate_runs     what is read from the runs of one lattice, row by row
certificate_shells   edges and sizes of shells; units fill the box
certificate_names    names of units match their bounding surfaces
===================  ==================================================================
"""

from geosurf.carve.cells import find_cells
from geosurf.carve.units import carve_cells, carve_units

__all__ = ["carve_cells", "carve_units", "find_cells"]
