"""Many realisations of one model: volumes under uncertainty, with their quantiles and maps.

=================  ============================================================
run.py             `run_ensemble`: all of it
plan.py            one ensemble, prepared: what a worker needs for realisation k
models.py          what realisations are made of: a scene, a function
change.py          what one realisation changes of a model, and where its numbers come from
described.py       what is uncertain, in words with units
depths.py          uncertain horizons: shifts, and errors correlated in the map
contact_levels.py  uncertain fluid contacts
throws.py          uncertain throw; fault_moves.py: position and dip
horizon_data.py    the data of a horizon, as places and elevations
fields.py          Gaussian random fields on a lattice, conditioned to known values
record.py          the result of one realisation; maps.py: its maps
juxtapositions.py  zones that face each other across faults
on_dask.py         realisations on Dask: threads, processes, clusters
store.py           the Zarr store; sums.py: its maps
results.py         quantiles, convergence, tornado; also as text
report.py          one HTML page; charts.py: its figures
scenario_model.py  the tables [ensemble] and [[uncertain]] of a scenario
=================  ============================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily
from geosurf.model.distributions import Discrete as Discrete
from geosurf.model.distributions import Normal as Normal
from geosurf.model.distributions import Triangular as Triangular
from geosurf.model.distributions import Uniform as Uniform

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.ensemble.contact_levels import ContactLevel as ContactLevel
    from geosurf.ensemble.depths import DepthError as DepthError
    from geosurf.ensemble.depths import DepthShift as DepthShift
    from geosurf.ensemble.fault_moves import FaultDip as FaultDip
    from geosurf.ensemble.fault_moves import FaultShift as FaultShift
    from geosurf.ensemble.fields import Covariance as Covariance
    from geosurf.ensemble.fields import FieldGrid as FieldGrid
    from geosurf.ensemble.fields import GaussianField as GaussianField
    from geosurf.ensemble.juxtapositions import juxtaposition as juxtaposition
    from geosurf.ensemble.report import report_ensemble as report_ensemble
    from geosurf.ensemble.results import convergence as convergence
    from geosurf.ensemble.results import open_ensemble as open_ensemble
    from geosurf.ensemble.results import quantiles as quantiles
    from geosurf.ensemble.results import tornado as tornado
    from geosurf.ensemble.results import volumes_by as volumes_by
    from geosurf.ensemble.run import realize as realize
    from geosurf.ensemble.run import run_ensemble as run_ensemble
    from geosurf.ensemble.throws import Throw as Throw
else:
    # a worker process needs neither reports nor statistics
    __getattr__, __all__ = lazily(__name__)
