"""Fill sealed units with tetrahedra: one conforming mesh with the unit of each.

===================  ==================================================================
mesh_units.py        `mesh_units`: the steps from units to a mesh
boundary.py          faces between units, each once, with the units on its two sides
tetgen_process.py    what the process of TetGen runs
===================  ==================================================================
"""

from geosurf.tetrahedra.mesh_units import mesh_units

__all__ = ["mesh_units"]
