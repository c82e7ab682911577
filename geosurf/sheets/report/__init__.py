"""What a user is told about a sheet: cut-offs, misfit, trim.

- `cutoffs`: cut-off lines of both walls after the exact cut, and throw and heave along the fault
- `describe`: what a user is told about a sheet: the `SheetReport`, and the profiles of each fault
- `holdout_misfit`: distrusted data against the finished sheet, each against the wall that it is
  on
- `tip_throw`: throw that the data still show where a fault ends inside them
- `propose_trim`: how far are data smeared over their faults? Asked of the data that a generous
  trim hides
"""
