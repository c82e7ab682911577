"""A vertical section along a bent line through three faults and two oil-water contacts."""

from field import SIZE, scene

import geosurf as gs

section = scene.section([(200, 600), (2900, 1000), (5900, 3900)])  # easting, northing [m]
gs.render_section(section, "docs/pictures/section.png", size=SIZE)
