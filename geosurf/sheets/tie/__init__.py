"""Horizons that meet well tops: data are corrected before the horizon is torn or cut.

===============  ==================================================================
tie_horizon.py   `tie_horizon`, `tied_sheet`: cut, compare, correct, until all tops are met
correction.py    what tops change at each vertex, by distances that go around faults
controls.py      tops on the cut horizon: residuals, and why others are not used
                 a horizon cut at its faults, with vertices of its own on each wall
===============  ==================================================================
"""

from geosurf.sheets.tie.tie_horizon import Tied, data_to_tie, tie_horizon, tied_sheet

__all__ = ["Tied", "data_to_tie", "tie_horizon", "tied_sheet"]
