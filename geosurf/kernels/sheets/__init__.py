"""Sheets: the smoothest surface through data, torn where faults cut it.

=================  =========================================================  ====================
file               question                                                   source
=================  =========================================================  ====================
`fault_distance`   how far is a datum from a fault? which links does it cut?
`fault_trace`      where a fault meets a drape                                marching triangles
`link_lines`       lines of links, and what is near them
`node_bands`       some nodes of a lattice, increasing
`smooth_surface`   the smoothest surface: its equations
`envelope_solver`  equations ordered, filled and solved in a narrow band      Cuthill & McKee 1969
`column_products`  sums of products of a few columns
`graph_distance`   how many links away is a node?                             breadth-first search
`sheet_trim`       which of these pieces stay
`sheet_corners`    corners of the pieces of a torn sheet
=================  =========================================================  ====================
"""
