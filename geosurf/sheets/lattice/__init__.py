"""The lattice of a horizon: its frame, its data, and the smoothest surface on it.

=====================  ============================================================================
picks.py               columns and rows from easting and northing, however the grid is rotated
                       horizon data on a lattice: which node, what elevation
                       noise of the data, and their weight against smoothness
data.py                horizon data in any form -> picks, or scattered points
                       scattered points, with a lattice over them
solve.py               the smoothest surface through data (Briggs 1974), in a band of nodes
                       the same energy as a sparse matrix, for scattered points
                       a surface filled across faults without a tear; absent nodes to fill
=====================  ============================================================================
"""
