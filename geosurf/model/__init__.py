"""The nouns that travel between stages: surfaces, curves, patches, units.

All are immutable and hold read-only arrays. Coordinates of inputs are world
metres; results keep local coordinates (`local`, exact to the frame) and an
`origin`, and add the two for people and files (`vertices`, `points`).
"""

from __future__ import annotations

from geosurf.model.base import frozen
from geosurf.model.certificate import Certificate, Check
from geosurf.model.column import RULES, Clipped, FluidContact, Remnant, check_column
from geosurf.model.curves import CurveIssue, Curves, Touch, TriangleContact, VoxelSearch
from geosurf.model.faults import (
    ExtendedFault,
    Extension,
    TruncatedFaults,
    Truncation,
)
from geosurf.model.grids import CornerPointGrid
from geosurf.model.lattice import Lattice
from geosurf.model.network import FaultNetwork
from geosurf.model.network_rows import NetworkDecision, NetworkRow, NetworkTrial
from geosurf.model.patches import Patches
from geosurf.model.sheet_report import FaultCut, LostThrow, SheetReport, ThrowReport, TrimProposal
from geosurf.model.sheets import Sheet
from geosurf.model.surfaces import ROLES, FaultSticks, TriSurface
from geosurf.model.tet_mesh import TetMesh
from geosurf.model.unit import Unit
from geosurf.model.units import Units

__all__ = [
    "ROLES",
    "RULES",
    "Certificate",
    "Check",
    "Clipped",
    "CornerPointGrid",
    "CurveIssue",
    "Curves",
    "ExtendedFault",
    "Extension",
    "FaultCut",
    "FaultNetwork",
    "FaultSticks",
    "FluidContact",
    "Lattice",
    "LostThrow",
    "NetworkDecision",
    "NetworkRow",
    "NetworkTrial",
    "Patches",
    "Remnant",
    "Sheet",
    "SheetReport",
    "TetMesh",
    "ThrowReport",
    "Touch",
    "TriSurface",
    "TriangleContact",
    "TrimProposal",
    "TruncatedFaults",
    "Truncation",
    "Unit",
    "Units",
    "VoxelSearch",
    "check_column",
    "frozen",
]
