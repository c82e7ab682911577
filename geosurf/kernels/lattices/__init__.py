"""Lattices: gridded surfaces as nodes in rows and columns, and their properties.

===================  ========================================================  =================
file                 question                                                  source
===================  ========================================================  =================
`prefetch`           How is memory requested before it is read?
`lattice_corners`    Where are the corners and normals of the triangles?
`survey`             Which boxes, holes and cell shapes has a lattice?
`cell_bounds`        What do bounds of edges prove about the cells of a tile?
`strips`             Which triangles does no curve touch? As runs of rows.
`strip_links`        Which runs lie behind the edges of listed triangles?
`strip_triangles`    Which triangles and points do runs stand for?
`triangle_list`      The same for a list of triangles, in Morton order.        Morton 1966
`near_cells`        Which cells come near another surface?
`third_differences`  How rough is a grid? Third differences.
`sets`               Which whole numbers, nodes, links, edges, occur? With numpy.
===================  ========================================================  =================
"""
