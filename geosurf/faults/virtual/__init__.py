"""Virtual walls: faults that die inside the model, continued along the shortest join.

=============  ====================================================================
joins.py       the shortest way from a tip line to a fault or to the boundary
walls.py       the walls of all faults, one after the other
=============  ====================================================================
"""
