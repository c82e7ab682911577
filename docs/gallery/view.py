"""Horizons, faults and the curves where they meet, from the southwest."""

from field import SIZE, scene

import geosurf as gs

gs.render_scene(scene, "docs/pictures/view_southwest.png", view="southwest", size=SIZE)
