"""What users build and ask: horizons, faults and a box in; every result when it is requested.

===================  =====================================================================
scene.py             `Scene`: its inputs, its results by name, and its measures
inputs.py            `SceneInputs`: what it is made of, frozen and checked once
graph.py             `Graph`: what depends on what, from surfaces to units, on one page
surfaces.py          files, grids and meshes -> the surfaces of the graph
area.py              the box, the area of interest, and the origin of the local frame
faults.py            faults, extended and truncated
horizon_ends.py      faults that end at horizons, virtual walls at their targets; ended.py loads it
input_warnings.py    warnings about inputs that look wrong
curves.py            the curves of one pair, and those of all pairs
reference_systems.py  well tops and area in the system of the surfaces
wells.py             well tops, and their misfits
contact_volumes.py   volumes at level contacts, from the model without them
measures.py          measures that are more than a call of `geosurf.measure`
memory.py            results by what went into them; steps and warnings
pictures.py          the pictures of a report
picture_contents.py  what maps and sections of a scene show
attempt.py           an error of one picture costs no other result
card.py              the card of a scene in a notebook
shown.py             interactive views of all nouns together: `gs.show`
interactive_view.py  a page that notebooks show in a frame
plots.py             `Scene.plot`: maps, diagrams and views
===================  =====================================================================
"""

from __future__ import annotations

from geosurf.scene.scene import Scene

__all__ = ["Scene"]
