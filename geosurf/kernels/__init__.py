"""Kernels: arrays in, arrays out. numba compiles them; the same code runs as plain Python.

One room for each step of the method; each opens with a table of its files and the papers that they
follow. A room imports from those above it only (checked by the import contracts).

============  ==================================================================================
room          what happens there
============  ==================================================================================
`compile`     How kernels are compiled, kept and called; no kernel is in here
`exact`       Exact arithmetic: signs of determinants and points that are known by what makes them
`search`      Search: which triangles may meet? Trees of boxes and voxels
`lattices`    Lattices: gridded surfaces as nodes in rows and columns, and what is known of them
`contacts`    Contacts of triangles: how they meet, and the named points where they do
`cutting`     Cutting: the exact constrained Delaunay triangulation of each face that is cut
`meshes`      Meshes: welding, edges, parts, chains, orders and volumes, by integer keys
`smooth`      Smooth curves: where the cubics through two lattices meet, to a tolerance
`sheets`      Sheets: the smoothest surface through data, torn where faults cut it
============  ==================================================================================

Letters are the same in all of them. What decides exactly takes the six arrays of one frame,
always in this order: ``x`` coordinates, ``t`` triangles, ``e`` edge planes, ``d`` definitions of
constructed points, ``m`` the frame's integers, ``w`` the limb workspace; one bundle of arrays
would read better, but a tuple of arrays costs 145 ns a call instead of 10 (measured). The
triangulation of a face adds ``h``, ``q``, ``f``, ``s``, ``k``: see `delaunay`.
"""

from geosurf.kernels.compile.memory_pages import retain_pages

retain_pages()
