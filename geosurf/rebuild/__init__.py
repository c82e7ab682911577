"""Rebuild surfaces: split them along their common curves into one welded mesh.

=================  ====================================================================
patches.py         `rebuild_surfaces`: contacts of triangles -> patches
assemble.py        pieces and patches from cut and uncut triangles
repair.py          vertices moved where rounding would make triangles cross
moves.py           warning: vertices that a repair moved
ghosts.py          `trim_sheets`: torn horizons trimmed at their faults
closed_sheets.py   what a model shows about torn sheets that were not cut alone
listed.py          the triangles of patches that are listed one by one
wall_sides.py      parts of torn sheets on the wrong side of a fault
equal_vertices.py  vertices of one surface in the same place
=================  ====================================================================

Cut triangles get a constrained Delaunay triangulation of implicit points (Attene 2020, Levy 2024).
"""

from geosurf.rebuild.ghosts import drop_triangles, trim_sheets
from geosurf.rebuild.patches import patches_from, rebuild_surfaces

__all__ = ["drop_triangles", "patches_from", "rebuild_surfaces", "trim_sheets"]
