"""What the user learns about a sheet: cut-offs, misfit, trim.

=================  ===============================================================================
describe.py        the `SheetReport`, and the profiles of each fault
                   cut-off lines of both walls, throw and heave along the fault
fault_ends.py      throw that data show where a fault ends, and the sheet does not have
audit.py           the throw of a sheet beside what data on both sides show
propose_trim.py    `propose_trim`: how far data are smeared, and the trim that follows
remedies.py        what to type so that a sheet closes, or a fault is continued
=================  ===============================================================================
"""
