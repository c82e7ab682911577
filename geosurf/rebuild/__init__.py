"""Rebuild surfaces: split them along their common curves into one welded mesh.

=================  ====================================================================
assemble.py        pieces and patches from cut and uncut triangles
                   vertices of one surface in the same place
repair.py          vertices moved where rounding would make triangles cross
                   `rebuild_surfaces`: contacts of triangles -> patches
ghosts.py          `trim_sheets`: torn horizons trimmed at their faults
                   warning: vertices that a repair moved
                   the triangles of patches that are listed one by one
                   parts of torn sheets on the wrong side of a fault
                   what a model shows about torn sheets that were not cut alone
=================  ====================================================================

Cut triangles get a constrained Delaunay triangulation of implicit points (Attene 2020, Levy 2024).
"""

from geosurf.rebuild.ghosts import drop_triangles, trim_sheets
from geosurf.rebuild.repair import patches_from, rebuild_surfaces

__all__ = ["drop_triangles", "patches_from", "rebuild_surfaces", "trim_sheets"]
