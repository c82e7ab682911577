"""Closures of a horizon: crests, spill points, leaks at faults by juxtaposition."""

from field import SIZE, scene

found = scene.closures("Top", faults="juxtaposition")
scene.plot.map("Top", closures=found, path="docs/pictures/closures.png", size=SIZE)
