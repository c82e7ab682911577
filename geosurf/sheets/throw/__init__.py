"""A continuous horizon and the throw of its faults -> a torn sheet.

- `throw_horizon`: a continuous horizon and the throw of its faults -> a sheet that is torn there
- `thrown`: a horizon that its faults move: which wall each node belongs to, and where its sheets
  are
- `displacement`: a horizon moved by its faults: the height of each sheet anywhere, as if its wall
  had no end
- `measured_throw`: by throw: what is found between the cut-offs of a sheet, beside what was asked
  for
"""
