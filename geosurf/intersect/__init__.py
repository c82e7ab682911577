"""Intersect surfaces: the curves along which they meet.

==============  =======================================================================
curves.py       `intersect_surfaces`: contacts of triangles -> curves
                areas where surfaces coincide, and their outlines
link.py         segments linked to curves, in one order for any order of the input
                segments on one line that overlap, split at common ends
                curves of torn horizons, which end on faults
==============  =======================================================================

The search follows Lo & Wang (2004, Eng. Comput. 20), the contacts of triangles Guigue & Devillers
(2003, J. Graphics Tools 8).
"""

from geosurf.intersect.curves import curves_of, intersect_surfaces, merge_curves

__all__ = ["curves_of", "intersect_surfaces", "merge_curves"]
