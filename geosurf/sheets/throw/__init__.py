"""A continuous horizon and the throw of its faults -> a torn sheet.

=================  ===============================================================================
throw_horizon.py   `throw_horizon`: the steps, in order
thrown.py          which wall each node belongs to, and where its sheets are
displacement.py    the height of each sheet anywhere, as if its wall had no end
measured_throw.py  throw measured between the cut-offs, and what is lost at tips
=================  ===============================================================================
"""
