"""Horizons that meet well tops: data are corrected before the horizon is torn or cut.

===============  ==================================================================
tie_horizon.py   `tie_horizon`, `tied_sheet`: cut, compare, correct, until all tops are met
cut_horizon.py   a horizon cut at its faults, with vertices of its own on each wall
map_distance.py  distances in the map that do not cross a fault
controls.py      tops on the cut horizon: residuals, and why others are not used
correction.py    the correction that meets the residuals and ends at the range
horizon_data.py  grids, meshes and points whose elevations are corrected
===============  ==================================================================
"""

from geosurf.sheets.tie.horizon_data import data_to_tie
from geosurf.sheets.tie.tie_horizon import Tied, tie_horizon, tied_sheet

__all__ = ["Tied", "data_to_tie", "tie_horizon", "tied_sheet"]
