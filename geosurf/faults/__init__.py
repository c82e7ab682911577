"""Fault networks: extended, truncated by each other, and proposals for both.

==================  ================================================================
rules.py            truncations and extensions as users give them; their order
                    each piece of a mesh as a fault of its own
                    older faults that end at a younger one on both sides: two halves
rim.py              the open rim of a fault: start, end, up and down
                    which way a fault goes on beyond its rim
                    where rims and lines meet the box, and leave it
extend.py           extension until the fault leaves the model box
                    extension by a given distance
                    strips of triangles along a rim, with notches filled
sides.py            on which side of a fault another one leaves their common curve
truncate.py         truncation: which parts of a fault stay
distance.py         the closest approach of an open end to another fault
                    faults that do not reach the model
                    faults that end just inside of a side of the model
propose.py          contacts, near misses and dangling ends, each with a proposal
                    extension beyond a main fault
joins.py            the shortest way from a tip line to a fault or to the boundary
virtual_walls.py    walls of level lines behind faults that die inside the model
dangling.py         ends in the model box that are left once a network is as proposed
==================  ================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.faults.extend import extend_fault as extend_fault
    from geosurf.faults.extend import lengthen_fault as lengthen_fault
    from geosurf.faults.propose import propose_network as propose_network
    from geosurf.faults.rules import split_fault as split_fault
    from geosurf.faults.truncate import truncate_faults as truncate_faults
else:
    __getattr__, __all__ = lazily(__name__)
