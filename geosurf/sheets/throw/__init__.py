"""A continuous horizon and the throw of its faults -> a torn sheet.

=================  ===============================================================================
throw_horizon.py   `throw_horizon`: the steps, in order
best_attempt.py    attempts in turn: the first that closes, or the best
attempt.py         one attempt: traces, the wall of each node, and its height
tear_ends.py       where tears end, and errors where throw is left without a fault
movement.py        parts of the throw in the walls of all faults
displacement.py    the height of each sheet anywhere, as if its wall had no end
sectors.py         faults that cross near the horizon: wedges without it, cut-offs to expect
measured_throw.py  throw measured between the cut-offs, and what is lost at tips
=================  ===============================================================================
"""
