"""Heights of all nodes of a horizon, each wall of a fault from data of its own side only.

===============  =================================================================================
passes.py        the two passes, in order: start here
                 which picks a pass uses
                 heights from scattered points: each is a row of the equations
                 what a finished pass shows: picks in gaps, misfits of ignored data
state.py         picks and faults of one horizon, and the picks near each fault
                 what passes exchange: tears, selection of picks, evidence, heights
                 how far off ignored data are, and the weight that leaves them in wedges
grid_solver.py   heights of gridded picks: only nodes near faults are unknown
                 blocks between faults without data: joined to a neighbour, or refused
tip_solve.py     the solve with those shapes, and with what walls have in common
                 shapes of throw at tips, taken where they pay (in the sense of Bayes, MacKay 1992)
cutoffs.py       fault polygons: heights of nodes from which walls reach their lines
relief.py        what both walls have in common under noise (partial splines, Wahba 1990)
wrong_side.py    points that fit the other wall of a fault: left out before all passes
missing.py       blocks next to a fault without data: filled, or refused
===============  =================================================================================
"""
