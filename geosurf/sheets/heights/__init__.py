"""Heights of all nodes: each side of a fault from its own side only.

- `heights`: picks and faults -> heights of all nodes, each side built from its own side only
- `scattered`: points that sit on no lattice: the unknowns do, and each point is a row of the
  equations
- `tip_solve`: heights of solved nodes again, with the shapes of a throw that dies at tips
- `tip_residual`: the smoothest rest: a sheet around the tips of its faults, less the shapes that
  bend it there
- `relief`: what both walls of a fault have in common under noise: the relief that was there
  before it tore
- `smear`: how far off are data that were distrusted, seen where the sheets reach them from close
  by?
- `missing`: blocks beside a fault in which a horizon has no data at all
- `overlap`: how far the data of a horizon overlap at its faults, before anything is rebuilt
"""
