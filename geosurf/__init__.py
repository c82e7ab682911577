"""geosurf: horizons and faults in, sealed and certified units out.

The pipeline, stage by stage::

    read         files -> xarray horizons, fault surfaces, points, polygons
    sheets       horizon data + faults -> horizon sheets that are torn at the faults
    triangulate  gridded data -> TriSurface; the walls of the model box
    faults       extended beyond the model box, truncated by each other
    intersect    surfaces -> the curves where they meet
    rebuild      surfaces -> patches that share vertices along the curves
    carve        patches -> closed units: zone x fault block x fluid contact
    measure      units and patches -> thickness maps, juxtaposition, cut-offs, throw, dips
    tetrahedra   units -> one conforming mesh of tetrahedra
    render       anything -> PNG, off-screen
    grid         a scene -> a corner-point grid for flow simulators
    report       a scene -> one HTML page;  write: anything -> files
    ensemble     many realisations of a scene -> quantiles of volumes, maps of probability

Names are imported when first used, so that ``import geosurf`` costs nothing. Editors find them
below ``TYPE_CHECKING``; a test keeps both lists equal.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from geosurf.accessor import when_xarray_is_there

__version__ = "0.1.0"

_HOME = {
    # read
    "read_horizon": "geosurf.read",
    "read_fault": "geosurf.read",
    "read_points": "geosurf.read",
    "read_polygons": "geosurf.read",
    "read_tops": "geosurf.read",
    "read_wells": "geosurf.read",
    "info": "geosurf.read.file_info",
    "FileInfo": "geosurf.read.file_info",
    "read_units": "geosurf.read.model3d_units",
    # triangulate
    "triangulate_horizon": "geosurf.triangulate",
    "triangulate_fault": "geosurf.triangulate",
    "triangulate_sticks": "geosurf.triangulate",
    "reproject": "geosurf.triangulate",
    "fault_from_polygons": "geosurf.triangulate",
    "build_walls": "geosurf.triangulate",
    "build_contacts": "geosurf.triangulate",
    # faults
    "extend_fault": "geosurf.faults",
    "lengthen_fault": "geosurf.faults",
    "split_fault": "geosurf.faults",
    "truncate_faults": "geosurf.faults",
    "propose_network": "geosurf.faults",
    # sheets
    "extend_horizon": "geosurf.sheets",
    "tear_horizon": "geosurf.sheets",
    "throw_horizon": "geosurf.sheets",
    "EllipticThrow": "geosurf.sheets",
    "propose_trim": "geosurf.sheets",
    # grid
    "build_grid": "geosurf.grid",
    # the engine
    "intersect_triangles": "geosurf.arrangement",
    "intersect_surfaces": "geosurf.intersect",
    "rebuild_surfaces": "geosurf.rebuild",
    "trim_sheets": "geosurf.rebuild",
    "carve_units": "geosurf.carve",
    "mesh_units": "geosurf.tetrahedra",
    # nouns
    "FluidContact": "geosurf.model",
    "TriSurface": "geosurf.model",
    "Lattice": "geosurf.model",
    "FaultSticks": "geosurf.model",
    "FaultNetwork": "geosurf.model",
    "NetworkTrial": "geosurf.model",
    "CornerPointGrid": "geosurf.model",
    "Curves": "geosurf.model",
    "Patches": "geosurf.model",
    "Sheet": "geosurf.model",
    "SheetReport": "geosurf.model",
    "ThrowReport": "geosurf.model",
    "TrimProposal": "geosurf.model",
    "FaultCut": "geosurf.model",
    "Unit": "geosurf.model",
    "Units": "geosurf.model",
    "TetMesh": "geosurf.model",
    "Certificate": "geosurf.model",
    # the whole way
    "Scene": "geosurf.scene",
    "show": "geosurf.scene.shown",
    "run_scenario": "geosurf.scenario",
    "run_ensemble": "geosurf.ensemble",
    "render_scene": "geosurf.render",
    "render_place": "geosurf.render",
    "render_thickness": "geosurf.render",
    "render_allan": "geosurf.render",
    "render_section": "geosurf.render",
    "render_grid_section": "geosurf.render",
    "PictureOverlay": "geosurf.render.overlay",
    "PictureStyle": "geosurf.render.picture_style",
    "report_scene": "geosurf.report",
    "write": "geosurf.write",
    "to_xtgeo": "geosurf.write.neighbours",
    "to_geodataframe": "geosurf.write.neighbours",
    # what geosurf assumed
    "GeosurfWarning": "geosurf.errors",
    # what it is doing
    "show_progress": "geosurf.conventions.running",
}
_ROOMS = ("synthetic", "ensemble", "errors", "conventions")

# isort: off
if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf import conventions as conventions
    from geosurf import ensemble as ensemble
    from geosurf import errors as errors
    from geosurf import synthetic as synthetic
    from geosurf.carve import carve_units as carve_units
    from geosurf.arrangement import intersect_triangles as intersect_triangles
    from geosurf.conventions.running import show_progress as show_progress
    from geosurf.ensemble import run_ensemble as run_ensemble
    from geosurf.errors import GeosurfWarning as GeosurfWarning
    from geosurf.faults import (
        extend_fault as extend_fault,
        lengthen_fault as lengthen_fault,
        propose_network as propose_network,
        split_fault as split_fault,
        truncate_faults as truncate_faults,
    )
    from geosurf.grid import build_grid as build_grid
    from geosurf.intersect import intersect_surfaces as intersect_surfaces
    from geosurf.model import (
        Certificate as Certificate,
        FluidContact as FluidContact,
        CornerPointGrid as CornerPointGrid,
        Curves as Curves,
        FaultCut as FaultCut,
        FaultNetwork as FaultNetwork,
        NetworkTrial as NetworkTrial,
        FaultSticks as FaultSticks,
        Lattice as Lattice,
        Patches as Patches,
        Sheet as Sheet,
        SheetReport as SheetReport,
        TetMesh as TetMesh,
        ThrowReport as ThrowReport,
        TriSurface as TriSurface,
        TrimProposal as TrimProposal,
        Unit as Unit,
        Units as Units,
    )
    from geosurf.read import (
        read_fault as read_fault,
        read_horizon as read_horizon,
        read_points as read_points,
        read_polygons as read_polygons,
        read_tops as read_tops,
        read_wells as read_wells,
    )
    from geosurf.read.file_info import (
        FileInfo as FileInfo,
        info as info,
    )
    from geosurf.read.model3d_units import read_units as read_units
    from geosurf.rebuild import (
        trim_sheets as trim_sheets,
        rebuild_surfaces as rebuild_surfaces,
    )
    from geosurf.render import (
        render_allan as render_allan,
        render_grid_section as render_grid_section,
        render_place as render_place,
        render_scene as render_scene,
        render_section as render_section,
        render_thickness as render_thickness,
    )
    from geosurf.render.overlay import PictureOverlay as PictureOverlay
    from geosurf.render.picture_style import PictureStyle as PictureStyle
    from geosurf.report import report_scene as report_scene
    from geosurf.scenario import run_scenario as run_scenario
    from geosurf.scene import Scene as Scene
    from geosurf.scene.shown import show as show
    from geosurf.sheets import (
        EllipticThrow as EllipticThrow,
        propose_trim as propose_trim,
        extend_horizon as extend_horizon,
        tear_horizon as tear_horizon,
        throw_horizon as throw_horizon,
    )
    from geosurf.tetrahedra import mesh_units as mesh_units
    from geosurf.triangulate import (
        build_contacts as build_contacts,
        build_walls as build_walls,
        triangulate_fault as triangulate_fault,
        triangulate_horizon as triangulate_horizon,
        reproject as reproject,
        triangulate_sticks as triangulate_sticks,
        fault_from_polygons as fault_from_polygons,
    )
    from geosurf.write import write as write
    from geosurf.write.neighbours import to_geodataframe as to_geodataframe
    from geosurf.write.neighbours import to_xtgeo as to_xtgeo
# isort: on

__all__ = ["__version__", *sorted(_HOME), *_ROOMS]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    if name in _ROOMS:
        return import_module(f"geosurf.{name}")
    raise AttributeError(f"module 'geosurf' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


when_xarray_is_there()  # DataArrays and Datasets get .geosurf
