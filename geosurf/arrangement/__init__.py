"""Which triangles meet, and in which named points: what intersect, rebuild and carve depend on."""

from __future__ import annotations

from geosurf.arrangement.search import Contacts, find_contacts, search_voxels
from geosurf.arrangement.triangles import intersect_triangles

__all__ = ["Contacts", "find_contacts", "intersect_triangles", "search_voxels"]
