"""A thickness map of one zone, with the fault polygons of its top and base."""

from field import SIZE, scene

import geosurf as gs

polygons = {name: scene.fault_polygons(name) for name in ("Top", "Middle")}
thickness = scene.thickness("Top/Middle", 30.0)
gs.render_thickness(thickness, "docs/pictures/isochore.png", polygons=polygons, size=SIZE)
