"""An Allan diagram: which zones face each other across fault F1."""

from field import SIZE, scene

import geosurf as gs

diagram, table = scene.allan("F1"), scene.juxtaposition("F1")
zones = list(dict.fromkeys(unit.zone for unit in scene.units.values()))
gs.render_allan(diagram, table, "docs/pictures/allan_F1.png", zones=zones, size=SIZE)
