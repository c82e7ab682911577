"""Readers of gridded horizons: each turns one format into a DataArray.

===============  ==================================================================
nodes.py         `GridHeader` and `grid_array`: what all of them return; what text formats share
text_grids.py    ESRI text, GXF, CPS-3, ZMAP+
binary_grids.py  IRAP classic and binary, STORM, Surfer 6 and 7
node_lists.py    a node on each line: seismic grids (IJXYZ), EarthVision
===============  ==================================================================
"""
