"""A continuous horizon and the throw of its faults -> a torn sheet.

=================  ===============================================================================
throw_horizon.py   `throw_horizon`: the steps, in order
attempt.py         one attempt: traces, the wall of each node, and its height
                   where tears end, and errors where throw is left without a fault
displacement.py    the height of each sheet anywhere, as if its wall had no end
                   parts of the throw in the walls of all faults
=================  ===============================================================================
"""
