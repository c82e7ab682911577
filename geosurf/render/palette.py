"""Colours of zones, faults and maps: distinct in print and for colour-blind readers.

All colours are sRGB triples from 0 to 1.
"""

from __future__ import annotations

from geosurf.conventions.colours import (
    FAULTS as FAULTS,
)
from geosurf.conventions.colours import (
    RGB as RGB,
)
from geosurf.conventions.colours import (
    STRATA as STRATA,
)
from geosurf.conventions.colours import (
    fault as fault,
)
from geosurf.conventions.colours import (
    rgb as rgb,
)
from geosurf.conventions.colours import (
    shade as shade,
)
from geosurf.conventions.colours import (
    stratum as stratum,
)

INK = rgb("#26292e")
FAINT = rgb("#5b626d")  # of text, too: contrast 6.2 on white
PAPER = (1.0, 1.0, 1.0)
CURVE = rgb("#111111")
CONTACT = rgb("#1539b8")
ACCENT = rgb("#c8102e")
FRAME = rgb("#9aa0a8")
VOXEL = rgb("#3b6ea5")

WALL = rgb("#d4d7db")

# Elevation in map view, low to high.
ELEVATION = ("#2f4858", "#4a7285", "#7ea3a5", "#b9c9a9", "#e6dba8", "#dfb76c", "#bf8145", "#8a4b2f")
# Thickness, thin to thick: darker is thicker, also in print and for colour-blind readers.
THICKNESS = ("#f7f0cf", "#dbe3b0", "#b2d2aa", "#84bcab", "#5fa2ab", "#4886a3", "#3b6a96")
