"""Paths of wells: from positions, or from measured depths and directions.

layouts.py    files -> names of columns, rows of words, what the header states
names.py      usual names of columns
columns.py    which columns a file has, and their numbers
heads.py      where wells begin
stations.py   checks of measured depths and directions
curvature.py  minimum curvature
paths.py      `read_wells`: rows -> places along each well
"""

from geosurf.read.wells.columns import holds_wells
from geosurf.read.wells.heads import heads_of, holds_heads
from geosurf.read.wells.paths import read_wells

__all__ = ["heads_of", "holds_heads", "holds_wells", "read_wells"]
