"""RESQML 2.0.1 (``.epc`` with ``.h5``): surfaces, points and lines of a package.

| module | what it does |
|---|---|
| `package` | opens the zip file, its objects and its arrays |
| `arrays` | numbers of an object: in the HDF5 file, constant, or evenly spaced |
| `places` | from points of a representation to easting, northing, elevation in metres |
| `representations` | which objects there are, and what each holds |
| `wells` | paths of wells: control points of trajectories |
| `surfaces` | what callers read: horizons, faults, points, polygons |
"""
