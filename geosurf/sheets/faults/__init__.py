"""Faults as a sheet sees them: traces, links that they cut, distances, tips and branches.

- `traces`: faults on the lattice of a horizon: where each meets the horizon in the map
- `fault_distance`: how far is a datum from a fault at its own height; how far is a node from a
  trace in the map
- `cut_edges`: links of the lattice that faults cut: one table, from which solve and mesh take
  their parts
- `fault_profile`: a fault seen along its strike: how far across it is, for a distance along and
  an elevation
- `network`: traces of all faults and how each ends: at a tip, at the rim of the data, or on
  another fault
- `branches`: faults that end on another fault: their traces, on the wall of the main fault that
  they are in
- `dip_lines`: lines down the dip of a fault: which way a wall moves along it where its strike
  turns
- `slip`: how much throw a fault has, and how its walls move along it
- `tips`: how throw dies at the tips of a fault, which the smoothest sheet alone cannot know
- `heave`: where the cut-offs of both walls of a fault lie: how wide the gap, or the overlap,
  along a trace
- `last_edges`: the last link of a tear: both of its nodes on their own sides of the fault, or the
  sheet leaks
"""
