"""Readers of gridded horizons: each turns one format into `GridNodes`.

===============  ==================================================================
nodes.py         `GridHeader` and `GridNodes`: what all of them return
text.py          what text formats share
irap.py          IRAP classic and binary
zmap.py          ZMAP+
cps3.py          CPS-3
surfer.py        Surfer 6 and 7
storm.py         STORM
esri.py          ESRI text
gxf.py           GXF
geotiff.py       GeoTIFF, through rasterio
earthvision.py   EarthVision
ijxyz.py         seismic grids: inline, crossline, x, y, z
===============  ==================================================================
"""
