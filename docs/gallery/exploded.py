"""Units, drawn apart: one colour per zone, one piece per fault block."""

from field import SIZE, scene

scene.plot.view(path="docs/pictures/demo.png", show=["units"], exploded=0.15, size=SIZE)
