"""The lattice of a horizon: its frame, its data, and the smoothest surface on it.

=====================  ============================================================================
frame.py               columns and rows from easting and northing, however the grid is rotated
find_lattice.py        the lattice that points sit on
picks.py               horizon data on a lattice: which node, what elevation
scattered.py           scattered points, with a lattice over them
data.py                horizon data in any form -> picks, or scattered points
noise.py               noise of the data, and their weight against smoothness
solve.py               the smoothest surface through data (Briggs 1974), in a band of nodes
fourth_differences.py  differences for data that are met exactly (Wahba 1990)
sparse.py              the same energy as a sparse matrix, for scattered points
drape.py               a surface filled across faults without a tear; absent nodes to fill
working_grid.py        heights of all nodes, of which a band is solved again and again
=====================  ============================================================================
"""
