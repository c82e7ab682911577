"""Analytic worlds: surfaces whose curves and volumes are known.

====================  =========================================================
tilted_planes         two tilted planes and one dipping fault; exact
graben                three planes between two faults; exact
noisy                 `tilted_planes` with hashed noise; bounds
dome_and_flat_fault   a paraboloid cut by a flat surface; order 2
listric               a tilted plane and an arc of a circle; order 2
egg_box               many domes and one flat surface; order 2
waves                 a wavy horizon, a wavy fault; order 2, the curve at every place
hills                 any size, many faults; nothing is known but the number of curves
faulted_reservoir     a field to look at; little is known of it
faulted               planes to be moved by plane faults; exact, with throws and juxtaposition
torn                  a horizon as it is picked, smeared over its faults; cut-offs known
field_export          a whole field as files of other programs; all of it known
====================  =========================================================

`exact` means: planes stay planes when they are triangulated, so a correct
model meets the true numbers to rounding. `order 2` means: twice the nodes, a quarter
of the error. All functions take `n`, nodes per side, and `offset`.
"""

from geosurf.synthetic.domes import dome_and_flat_fault, egg_box, hills, listric, noisy, waves
from geosurf.synthetic.export import FieldTruth, field_export
from geosurf.synthetic.field import faulted_reservoir
from geosurf.synthetic.planar import faulted, graben, tilted_planes
from geosurf.synthetic.torn_horizon import torn
from geosurf.synthetic.world import World

__all__ = [
    "FieldTruth",
    "World",
    "dome_and_flat_fault",
    "egg_box",
    "faulted",
    "faulted_reservoir",
    "field_export",
    "graben",
    "hills",
    "listric",
    "noisy",
    "tilted_planes",
    "torn",
    "waves",
]
