"""Fill sealed units with tetrahedra: one conforming mesh with the unit of each.

===================  ==================================================================
mesh_units.py        `mesh_units`: from the faces between units to a mesh
tetgen_process.py    what the process of TetGen runs
===================  ==================================================================
"""

from geosurf.tetrahedra.mesh_units import mesh_units

__all__ = ["mesh_units"]
