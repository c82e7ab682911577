"""A thickness map of one zone, with the fault polygons of its top and base."""

from field import SIZE, scene

scene.plot.thickness("Top/Middle", 30.0, path="docs/pictures/isochore.png", size=SIZE)
