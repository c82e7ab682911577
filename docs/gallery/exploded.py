"""Units, drawn apart: one colour per zone, one piece per fault block."""

from field import SIZE, scene

import geosurf as gs

gs.render_scene(scene, "docs/pictures/demo.png", show=["units"], exploded=0.15, size=SIZE)
