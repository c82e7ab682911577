"""Paths of wells: from positions, or from measured depths and directions.

columns.py    files -> names of columns, rows of words, what the header states; where wells begin
paths.py      `read_wells`: rows -> places along each well, by minimum curvature
"""

from geosurf.read.wells.columns import heads_of, holds_heads, holds_wells
from geosurf.read.wells.paths import read_wells

__all__ = ["heads_of", "holds_heads", "holds_wells", "read_wells"]
