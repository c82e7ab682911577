"""What the user learns about a sheet: cut-offs, misfit, trim.

=================  ===============================================================================
describe.py        the `SheetReport`, and the profiles of each fault
cutoffs.py         cut-off lines of both walls, throw and heave along the fault
lengthening.py     what to type so that a fault is continued
propose_trim.py    `propose_trim`: how far data are smeared, and the trim that follows
=================  ===============================================================================
"""
