"""RESQML 2.0.1 (``.epc`` with ``.h5``): surfaces, points and lines of a package.

| module | what it does |
|---|---|
| `package` | opens the zip file, its objects and its arrays |
| `representations` | which objects there are, what each holds, and its places in metres |
| `surfaces` | what callers read: horizons, faults, points, polygons, paths of wells |
"""
