"""Patches of a graben: every surface and wall, split where others meet it."""

import geosurf as gs

world = gs.synthetic.graben()
scene = gs.Scene(world.horizons, world.faults, world.box)
scene.plot.view(path="docs/pictures/patches.png", show=["patches", "curves"], size=(960, 600))
