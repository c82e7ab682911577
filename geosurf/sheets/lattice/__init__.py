"""The lattice of a horizon: its frame, its data, and the smoothest surface on it.

- `frame`: the lattice of a horizon: places in cells, whatever way the grid is turned
- `sets`: sets of whole numbers, as increasing arrays: nodes, links, edges
- `data`: horizon data in any form -> picks on one lattice: which node, what elevation
- `working_grid`: heights of all nodes of a lattice, of which a band is made anew again and again
- `solve`: the smoothest sheet through trusted data: only the nodes near faults are unknown
- `drape`: the horizon filled across its faults without any tear, and which absent nodes may be
  filled
- `noise`: how noisy are data on a lattice, and how hard may a sheet be held to them?
"""
