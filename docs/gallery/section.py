"""A vertical section along a bent line through three faults and two oil-water contacts."""

from field import SIZE, scene

line = [(200, 600), (2900, 1000), (5900, 3900)]  # easting, northing [m]
scene.plot.section(line, path="docs/pictures/section.png", size=SIZE)
