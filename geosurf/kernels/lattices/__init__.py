"""Lattices: gridded surfaces as nodes in rows and columns, and what is known of them.

===================  =======================================================  =================
file                 question                                                 source
===================  =======================================================  =================
`prefetch`           memory that is asked for before it is read
`lattice_corners`    corners and normals of a lattice
`survey`             what is a lattice like? boxes, holes, how cells lie
`cell_bounds`        how do cells lie, as far as bounds of their edges tell?
`strips`             what no curve touches of a lattice, as runs
`strip_triangles`    runs as triangles again
`triangle_list`      the same for a list of triangles; Morton order           Morton 1966
`coarsen`            fewer triangles within a tolerance                       Evans et al. 2001
`third_differences`  third differences of a grid
===================  =======================================================  =================
"""
