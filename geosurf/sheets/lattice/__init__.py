"""The lattice of a horizon: its frame, its data, and the smoothest surface on it.

=====================  ============================================================================
frame.py               columns and rows from easting and northing, however the grid is rotated
picks.py               horizon data on a lattice: which node, what elevation
scattered.py           scattered points, with a lattice over them
data.py                horizon data in any form -> picks, or scattered points
noise.py               noise of the data, and their weight against smoothness
solve.py               the smoothest surface through data (Briggs 1974), in a band of nodes
sparse.py              the same energy as a sparse matrix, for scattered points
drape.py               a surface filled across faults without a tear; absent nodes to fill
=====================  ============================================================================
"""
