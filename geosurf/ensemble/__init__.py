"""Many realisations of one model: volumes under uncertainty, with their quantiles and maps.

============  ===================================================================
run.py        `run_ensemble`: all of it; progress
plan.py       one ensemble, prepared: what a worker needs for realisation k
change.py     what one realisation changes, in which data, and where its numbers come from
models.py     what realisations are made of: a scene, a function, a scenario
uncertain.py  depths of horizons, velocities, fluid contacts; uncertain_faults.py: faults
fields.py     Gaussian random fields on a lattice, conditioned to known values
record.py     the result of one realisation: volumes, maps, juxtaposed zones; rock and fluids
on_dask.py    realisations on Dask: threads, processes, clusters
store.py      the Zarr store
results.py    `Ensemble`: sums, quantiles, convergence, tornado; tables as text and csv
report.py     its charts; one HTML page of all
============  ===================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily
from geosurf.model.distributions import Discrete as Discrete
from geosurf.model.distributions import Normal as Normal
from geosurf.model.distributions import Triangular as Triangular
from geosurf.model.distributions import Uniform as Uniform

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.ensemble.fields import Covariance as Covariance
    from geosurf.ensemble.fields import FieldGrid as FieldGrid
    from geosurf.ensemble.fields import GaussianField as GaussianField
    from geosurf.ensemble.results import Ensemble as Ensemble
    from geosurf.ensemble.results import open_ensemble as open_ensemble
    from geosurf.ensemble.run import realisations as realisations
    from geosurf.ensemble.run import realise as realise
    from geosurf.ensemble.run import run_ensemble as run_ensemble
    from geosurf.ensemble.uncertain import ContactLevel as ContactLevel
    from geosurf.ensemble.uncertain import DepthError as DepthError
    from geosurf.ensemble.uncertain import DepthShift as DepthShift
    from geosurf.ensemble.uncertain import VelocityFactor as VelocityFactor
    from geosurf.ensemble.uncertain_faults import FaultDip as FaultDip
    from geosurf.ensemble.uncertain_faults import FaultShift as FaultShift
    from geosurf.ensemble.uncertain_faults import Throw as Throw
else:
    # a worker process needs neither reports nor statistics
    __getattr__, __all__ = lazily(__name__)
