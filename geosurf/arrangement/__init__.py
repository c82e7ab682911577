"""Find which triangles meet, and the named points where they meet: exact arrangements.

=================  ====================================================================
search.py          `find_contacts`: surfaces -> contacts of their triangles, with named points
trees.py           surfaces as the search takes them: checked, with trees of boxes (Morton order)
candidates.py      pairs of triangles that may meet, of each pair of surfaces, and of a torn sheet
                   with itself; stored for the next search of both
tree_pairs.py      such pairs of two trees, and of two grids of one survey or with straight axes
voxels.py          such pairs from voxels in a common box (Lo & Wang 2004)
gather.py          the faces that may meet, in one numbering; and how they meet
triangles.py       `intersect_triangles`: two triangles, all cases (Guigue & Devillers 2003)
                   the exact test of a rounded mesh
arrange.py         faces cut along their contacts (Attene 2020, Levy 2024)
threads.py         independent tasks in threads, results in order
                   error before pairs of triangles exceed the memory
                   arrays that were made with room for more
=================  ====================================================================

The rooms `intersect`, `rebuild` and `carve` use these contacts.
"""

from __future__ import annotations

from geosurf.arrangement.candidates import KnownPairs
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.arrangement.triangles import intersect_triangles
from geosurf.arrangement.voxels import search_voxels

__all__ = [
    "Contacts", "KnownPairs", "find_contacts", "intersect_triangles",
    "search_voxels",
]  # fmt: skip
