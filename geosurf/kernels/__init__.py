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
`location`    Location: which unit is at a point, and how far is the nearest boundary?
`sheets`      Sheets: the smoothest surface through data, cut where faults pass
============  ==================================================================================

Letters have the same meaning in all rooms; each module explains its own under *Notation*. Exact
decisions use the six arrays of one frame: ``x`` coordinates, ``t`` triangles, ``e`` edge planes,
``d`` definitions of constructed points, ``m`` the frame's integers, ``w`` the limb workspace.

An *entry*, called from Python, takes arrays one by one, because a tuple of arrays would cost 145 ns
per call instead of 10. Helpers inside an entry take bundles (named tuples such as
`exact_signs.Frame`), which cost nothing there.
"""

from geosurf.kernels.compile.jit import retain_pages

retain_pages()
