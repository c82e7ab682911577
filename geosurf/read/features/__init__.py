"""Readers of points and lines with attributes, from geographic information systems.

===============  ==================================================================
collection.py    `Features`: what both formats hold -> points, polygons, fault sticks
geojson.py       GeoJSON
shapefile.py     ESRI shapefile: .shp with .dbf and .prj
===============  ==================================================================
"""
