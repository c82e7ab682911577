"""The format matrix: what is written, what comes back, and what other programs make of it.

====================  ======================================================================
`subjects`            one object of each kind that `geosurf.write` takes, and its places
`hostile`             objects that formats cannot hold, or hold only just
`round_trips`         write, read back, compare; what was lost
`peers`               the same files in other interpreters, with xtgeo, meshio, pyvista ...
`peer_reader`         what runs there: it knows nothing of geosurf
`speed`               maps of 1000 x 1000 and a million triangles, next to the peers
`page`                all of it as a page
====================  ======================================================================
"""
