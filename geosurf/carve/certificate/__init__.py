"""Certify a model: each of its properties is recomputed from the result.

===================  ==================================================================
certify.py           `certify`, and `same_bytes` of two runs
                     the lines without a list of all triangles
                     the lines from all triangles, with what is wrong, and where
lines.py             the lines of a certificate in their order
                     checks from their facts
facts.py             facts from runs of lattices
elements.py          triangles and runs, as checks read them
                     check: units fill the box without overlap
names.py             check: names of units match their bounding surfaces
                     adjacency of units, recomputed for the checks
===================  ==================================================================
"""

from geosurf.carve.certificate.certify import certify, certify_repeated, same_bytes

__all__ = ["certify", "certify_repeated", "same_bytes"]
