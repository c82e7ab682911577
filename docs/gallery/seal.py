"""Shale gouge ratio of fault F1 on its Allan diagram: what the fault holds."""

from field import SIZE, scene

found = scene.seal("F1", vshale={"Top/Middle": 0.12, "Middle/Base": 0.25, "elsewhere": 0.8})
scene.plot.allan("F1", seal=found, path="docs/pictures/seal.png", size=SIZE)
