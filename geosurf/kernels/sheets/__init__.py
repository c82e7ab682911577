"""Sheets: the smoothest surface through data, cut where faults pass.

=================  =====================================================  ====================
file               question                                               source
=================  =====================================================  ====================
`fault_trace`      Where does a fault meet a gridded horizon?             marching triangles
                   What is the value of a mesh at points of its plane?
`link_lines`       Which lines do links form? What is near a line?
                   How far is a datum from a fault? Which links are cut?
`node_bands`       Which nodes of a lattice lie in a band?
                   What are sums of products of a few columns?
`smooth_surface`   What are the equations of the smoothest surface?       Briggs 1974
                   How are they ordered, filled and solved?               Cuthill & McKee 1969
                   How many links away is a node?                         breadth-first search
`moved_rock`       Where are faults and beds that throw moves rock along?
                   Where was the rock that throw has brought to a place?
`torn_links`       Which triangles do cut links divide?
                   Which parts of a torn sheet remain?
                   Which corners of pieces are vertices of the sheet?
=================  =====================================================  ====================
"""
