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

Names are imported when first used, so that ``import geosurf`` costs nothing: see `geosurf.lazy`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

__version__ = "0.1.0"

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
    from geosurf.grid import fault_multipliers as fault_multipliers
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
        ThrowAudit as ThrowAudit,
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
    from geosurf.read.file_info import FileInfo as FileInfo, info as info
    from geosurf.read.sealed_model import read_units as read_units
    from geosurf.rebuild import trim_sheets as trim_sheets, rebuild_surfaces as rebuild_surfaces
    from geosurf.render import (
        render_grid_section as render_grid_section,
        render_place as render_place,
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
        propose_dip as propose_dip,
    )
    from geosurf.write import write as write
    from geosurf.write.points_and_lines import to_geodataframe as to_geodataframe
    from geosurf.write.points_and_lines import to_xtgeo as to_xtgeo
# isort: on

__getattr__, _names = lazily(__name__)
__all__ = ["__version__", *_names]


def __dir__() -> list[str]:
    return sorted(__all__)
