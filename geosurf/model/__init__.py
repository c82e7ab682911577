"""The nouns that travel between stages: surfaces, curves, patches, units.

All are immutable and hold read-only arrays. Coordinates of inputs are world
metres; results keep local coordinates (`local`, exact to the frame) and an
`origin`, and add the two for people and files (`vertices`, `points`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily
from geosurf.model.base import frozen as frozen

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.model.column import RULES as RULES
    from geosurf.model.column import Clipped as Clipped
    from geosurf.model.column import FluidContact as FluidContact
    from geosurf.model.column import Remnant as Remnant
    from geosurf.model.column import check_column as check_column
    from geosurf.model.grids import CornerPointGrid as CornerPointGrid
    from geosurf.model.lattice import Lattice as Lattice
    from geosurf.model.network import ExtendedFault as ExtendedFault
    from geosurf.model.network import Extension as Extension
    from geosurf.model.network import FaultNetwork as FaultNetwork
    from geosurf.model.network import NetworkDecision as NetworkDecision
    from geosurf.model.network import NetworkRow as NetworkRow
    from geosurf.model.network import NetworkTrial as NetworkTrial
    from geosurf.model.network import TruncatedFaults as TruncatedFaults
    from geosurf.model.network import Truncation as Truncation
    from geosurf.model.patches import Curves as Curves
    from geosurf.model.patches import Patches as Patches
    from geosurf.model.patches import TetMesh as TetMesh
    from geosurf.model.patches import Touch as Touch
    from geosurf.model.patches import TriangleContact as TriangleContact
    from geosurf.model.patches import TriangleSteps as TriangleSteps
    from geosurf.model.patches import VoxelSearch as VoxelSearch
    from geosurf.model.sheets import FaultCut as FaultCut
    from geosurf.model.sheets import LostThrow as LostThrow
    from geosurf.model.sheets import Sheet as Sheet
    from geosurf.model.sheets import SheetReport as SheetReport
    from geosurf.model.sheets import ThrowAudit as ThrowAudit
    from geosurf.model.sheets import ThrowReport as ThrowReport
    from geosurf.model.sheets import TrimProposal as TrimProposal
    from geosurf.model.surfaces import ROLES as ROLES
    from geosurf.model.surfaces import FaultSticks as FaultSticks
    from geosurf.model.surfaces import TriSurface as TriSurface
    from geosurf.model.units import Certificate as Certificate
    from geosurf.model.units import Check as Check
    from geosurf.model.units import Unit as Unit
    from geosurf.model.units import Units as Units
else:
    __getattr__, __all__ = lazily(__name__)
