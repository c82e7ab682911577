"""Faults on the lattice of a horizon: traces, cut links, distances, tips and slip.

=================  ===============================================================================
traces.py          where each fault meets the horizon in the map
fault_distance.py  distance of data from a fault at their own height, of nodes from a trace
cut_edges.py       links of the lattice that faults cut
                   the last link of a tear: each node on its own side of the fault
                   walls of a fault: how wide the gap or the overlap is along a trace
network.py         traces of all faults, and how each ends: at a tip, at the rim, on another fault
tips.py            shapes of throw that dies at the tips of a fault (Williams 1957)
fault_profile.py   a fault seen along its strike: how far across it is, by distance and elevation
                   lines down the dip of a fault, along which walls move where its strike turns
slip.py            how walls move along a fault; throw of an ellipse
                   throw in any form that users give: numbers, profiles, functions, maps
=================  ===============================================================================
"""

DIRECTIONS = ("local", "mean")  # in which walls move and throw is read
