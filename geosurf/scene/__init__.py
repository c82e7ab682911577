"""What users build and ask: horizons, faults and a box in; every result when it is requested.

==================  ======================================================================
scene.py            `Scene`: its inputs, its results by name, its measures and views
given.py            inputs as they were given, which an ensemble varies
inputs.py           `SceneInputs`: what it is made of, frozen and checked once
graph.py            `Graph`: what depends on what, from surfaces to units, on one page
surfaces.py         files, grids, points and meshes -> the surfaces of the graph; well tops
depth.py            inputs in time become inputs in depth, and back
zones.py            horizons made from the thickness of zones
area.py             the box, the area of interest, the origin of the local frame; regions of
                    the field, proposed, named, or kept from the scene before
input_checks.py     warnings about inputs that look wrong; reference systems
faults.py           faults, extended and truncated
horizon_ends.py     faults that end at horizons, virtual walls at their targets
tearing.py          horizons torn at the faults of the scene
                    until all of them end on the same faults
memory.py           results by what went into them; steps and warnings
result_cache.py     results in a folder, which later runs find again
plots.py            `Scene.plot`: maps, diagrams and views
pictures.py         the pictures of a report: an error of one costs no other result
shown.py            the card of a scene; `geosurf.show`; data of a sheet
                    a page that notebooks show in a frame
==================  ======================================================================
"""

from __future__ import annotations

from geosurf.scene.scene import Scene

__all__ = ["Scene"]
