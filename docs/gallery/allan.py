"""An Allan diagram: which zones face each other across fault F1."""

from field import SIZE, scene

scene.plot.allan("F1", path="docs/pictures/allan_F1.png", size=SIZE)
