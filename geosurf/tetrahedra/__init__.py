"""Fill sealed units with tetrahedra: one conforming mesh with the unit of each.

===================  ==================================================================
mesh_units.py        `mesh_units`: the steps from units to a mesh
boundary.py          faces between units, each once, with the units on its two sides
refine.py            shorter edges of these faces
flat.py              flat parts of them, such as walls: points and edges may move there
run_tetgen.py        TetGen, the optional extra, and what it refuses
tetgen_process.py    what the process of TetGen runs
regions.py           the unit of each tetrahedron, from faces; conformity
===================  ==================================================================
"""

from geosurf.tetrahedra.mesh_units import mesh_units

__all__ = ["mesh_units"]
