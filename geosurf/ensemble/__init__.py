"""Many models of one scene: volumes under uncertainty, with their quantiles and maps.

================  =============================================================
streams.py        one stream of random numbers for each realisation and parameter
covariance.py     how errors at two places are related
field_grid.py     the lattice that a random field is simulated on
fields.py         Gaussian random fields, conditioned to known values
================  =============================================================
"""

from __future__ import annotations

from geosurf.ensemble.covariance import Covariance
from geosurf.ensemble.field_grid import FieldGrid
from geosurf.ensemble.fields import GaussianField
from geosurf.model.distributions import Discrete, Normal, Triangular, Uniform

__all__ = [
    "Covariance",
    "Discrete",
    "FieldGrid",
    "GaussianField",
    "Normal",
    "Triangular",
    "Uniform",
]
