"""Heights and cut links -> a torn mesh that its faults close, exactly.

- `torn_mesh`: lattice and cut links -> a mesh that is torn there: the virtual node construction
- `ghosts`: heights of ghosts: each sheet carried on past the fault, by the same energy as the
  sheet itself
- `islands`: the triangles of a band, apart by the faults that can meet them: what is cut by
  itself
- `leaks`: where a torn sheet that was cut by its faults would end anywhere but on them
- `cut`: the exact cut of a torn sheet by its faults, near the faults: cut-offs, and leaks if
  there are any
- `build`: heights -> a torn mesh that its faults close: rings of ghosts and ends of tears,
  checked exactly
- `finish`: from a closed mesh to a `Sheet`: what sheets as picked and sheets by throw have in
  common
- `overlap_points`: scattered points of an overlapping sheet that lie past the trace of their
  fault
"""
