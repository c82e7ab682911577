"""Lattices: gridded surfaces as nodes in rows and columns, and their properties.

===================  ========================================================  =================
file                 question                                                  source
===================  ========================================================  =================
`lattice_corners`    Where are the corners and normals of the triangles?
                     Which triangles and points do runs stand for?
                     The same for a list of triangles, in Morton order.        Morton 1966
`decimate`           Which nodes does a coarser grid keep? What comes near a surface?
                     How rough is a grid? Third differences.
`survey`             Which boxes, holes and cell shapes has a lattice?
                     What do bounds of edges prove about the cells of a tile?
`sets`               Which numbers are in several arrays? No kernel.
`strips`             Which triangles does no curve touch? As runs of rows.
                     Which runs lie behind the edges of listed triangles?
===================  ========================================================  =================
"""
