"""Horizons, faults and the curves where they meet, from the southwest."""

from field import SIZE, scene

scene.plot.view("southwest", path="docs/pictures/view_southwest.png", size=SIZE)
