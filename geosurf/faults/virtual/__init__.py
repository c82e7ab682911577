"""Virtual walls: faults that die inside the model, continued along the shortest join.

=============  ====================================================================
edges.py       pieces of faults and walls between the lines at which others cross them
tips.py        ends of faults inside the model: lines off all other faults
joins.py       the shortest way from a tip line to a fault or to the boundary
walls.py       the walls of all faults, one after the other
=============  ====================================================================
"""
