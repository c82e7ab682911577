"""Kernels: arrays in, arrays out. numba compiles them; the same code runs as plain Python.

There is one room for each step of the method. Each room opens with a table of its files and the
papers that they follow. A room imports from those above it only (checked by the import contracts).

============  ==================================================================================
room          content
============  ==================================================================================
`compile`     How kernels are compiled, cached and called; it contains no kernel
`exact`       Exact arithmetic: signs of determinants, and points defined by what constructs them
`search`      Search: which triangles may meet? Trees of boxes and voxels
`lattices`    Lattices: gridded surfaces as nodes in rows and columns, and their properties
`contacts`    Contacts of triangles: how two triangles meet, and the named points where they do
`cutting`     Cutting: the exact constrained Delaunay triangulation of each face that is cut
`meshes`      Meshes: welding, edges, parts, chains, orders and volumes, by integer keys
`sheets`      Sheets: the smoothest surface through data, cut where faults pass
============  ==================================================================================

Letters have the same meaning in all rooms; each module explains its own under *Notation*. Exact
decisions use the six arrays of one frame: ``x`` coordinates, ``t`` triangles, ``e`` edge planes,
``d`` definitions of constructed points, ``m`` the frame's integers, ``w`` the limb workspace.

An *entry*, called from Python, takes arrays one by one, because a tuple of arrays would cost 145 ns
per call instead of 10. Helpers inside an entry take bundles (named tuples such as
`exact_signs.Frame`), which cost nothing there.
"""

import numpy as np

# Freed memory stays with the process, so that the next call reuses its pages. The C library of
# Linux returns it to the system until a program has freed a large block, as this one, which nobody
# touches: then it keeps up to twice that size, 64 MB at most. Each page requested again is a fault,
# 0.3 to 5 microseconds: on a virtual machine a third of the time for cutting a scene of 16 MB.
np.empty(32 * 2**20 - 2**16, dtype=np.uint8)  # [bytes]; the library learns nothing from more
