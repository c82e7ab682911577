"""Pinch a horizon out: in blocks without data it takes over the mesh of another one.

A sheet falls apart into blocks where faults cut through. The part of a block without data is
exchanged for that of the other horizon, triangle by triangle, with what reaches past the faults. So
the two coincide exactly, and the zone between them is absent there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geosurf.conventions import area_text, place
from geosurf.errors import GeometryError, GeosurfWarning
from geosurf.model import Sheet, SheetReport, TriSurface
from geosurf.model.lattice import Lattice
from geosurf.sheets.heights.stand_in import StandIn, parts_of
from geosurf.sheets.lattice.frame import frame_of_lattice

NEAR = 16  # cells: how far a block of one horizon may go beyond that of the other, at its faults


def pinched_out(sheet: Sheet, nodes: np.ndarray, data: np.ndarray, other: StandIn) -> Sheet:
    """
    Return a sheet that coincides with another one in blocks where it has no data.

    Parameters
    ----------
    sheet : Sheet
        Torn, with heights of the other one at `nodes`.
    nodes : ndarray of int64, shape (n,)
        Nodes of these blocks.
    data : ndarray of bool, shape (n_node,)
        Nodes with data of its own.
    other : StandIn

    Raises
    ------
    GeometryError
        If faults do not close these blocks off.
    """
    # Parts of the mesh by vertex; nodes without one have no part.
    number = sheet.lattice.vertex_of_node.ravel()
    own = parts_of(sheet)
    part = np.where(number >= 0, own[np.maximum(number, 0)], -1)
    with_data = np.unique(part[data])
    # Parts without any data are exchanged as a whole.
    mine = np.setdiff1d(part[nodes], with_data)
    theirs = np.unique(other.block[nodes])

    # next to faults that dip, a few of the nodes are on the side of the data at their own height
    open_ = nodes[np.isin(part[nodes], with_data)]
    _refuse_open(sheet, open_[_far_from(np.flatnonzero(data), sheet)[open_]])
    inside = np.flatnonzero(data & np.isin(other.block, theirs))
    _refuse_open(sheet, inside[_far_from(nodes, sheet)[inside]])
    nodes = nodes[np.isin(part[nodes], mine)]

    # the rest of this sheet, and the part of the other one
    surface, second = sheet.surface, other.sheet.surface
    one = surface.triangles[~np.isin(own, mine)[surface.triangles[:, 0]]]
    two = second.triangles[np.isin(other.block_of_vertex, theirs)[second.triangles[:, 0]]]
    # Vertices of both meshes, those of the other one behind; nothing is welded, as faults lie
    # between.
    used = [np.unique(one), np.unique(two)]
    corners = [np.searchsorted(used[0], one), len(used[0]) + np.searchsorted(used[1], two)]
    vertices = np.concatenate([surface.vertices[used[0]], second.vertices[used[1]]])
    marks = {
        key: np.concatenate([surface.vertex_data[key][used[0]], second.vertex_data[key][used[1]]])
        for key in ("ghost", "outer")
    }
    # What comes from the other horizon counts as extrapolated, except for its ghosts.
    ghost = second.vertex_data["ghost"][used[1]]
    marks["extrapolated"] = np.concatenate([_marks(surface)[used[0]], ~ghost])
    triangles = np.concatenate(corners)
    mesh = TriSurface(sheet.name, "horizon", vertices, triangles, vertex_data=marks)
    mesh.crs = sheet.crs

    # the grid for maps and areas
    z = sheet.lattice.elevation.copy()
    # Maps and areas read the grid, so it has to agree with the mesh.
    z.ravel()[nodes] = other.heights[nodes]
    lattice = Lattice(sheet.lattice.easting, sheet.lattice.northing, z, sheet.lattice.rising)
    mark = np.zeros(z.shape, bool) if sheet.extrapolated is None else sheet.extrapolated.copy()
    mark.ravel()[nodes] = True
    report = sheet.report
    if isinstance(report, SheetReport):
        warning = _warning(sheet, nodes, other)
        report = replace(report, warnings=(*report.warnings, warning))
    return replace(sheet, lattice=lattice, extrapolated=mark, report=report, mesh=mesh)


def _marks(surface: TriSurface) -> np.ndarray:
    """Vertices that are marked as extrapolated; none if nothing is."""
    none = np.zeros(surface.n_vertex, dtype=bool)
    found: np.ndarray = surface.vertex_data.get("extrapolated", none)
    return found


def _far_from(nodes: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Nodes farther than `NEAR` cells from some nodes, bool (n_node,)."""
    from scipy.ndimage import distance_transform_edt

    # A distance transform: one pass, however many nodes there are.
    away = np.ones(sheet.lattice.shape, dtype=bool)
    away.ravel()[nodes] = False
    far: np.ndarray = distance_transform_edt(away).ravel() > NEAR
    return far


def _refuse_open(sheet: Sheet, nodes: np.ndarray) -> None:
    """Raise an error if there are nodes where blocks with and without data are connected."""
    if len(nodes):
        frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
        at = frame.node_places(nodes[:1])[0]
        raise GeometryError(
            f"horizon {sheet.name!r} ends near {place(at)}, and no faults close the part without "
            "data off from the rest, so it cannot be pinched out there. Extend the faults until "
            "they cut through, or set fill_empty_blocks=True to continue the horizon.",
            place=(*at, float(np.nanmedian(sheet.lattice.elevation))),
            surfaces=(sheet.name,),
        )


def _warning(sheet: Sheet, nodes: np.ndarray, other: StandIn) -> GeosurfWarning:
    """How large the blocks are in which the horizon is pinched out."""
    frame, _ = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
    # In cells times their area: near enough for a message.
    size = area_text(len(nodes) * float(np.prod(frame.spacing)))
    middle = frame.node_places(nodes).mean(axis=0)
    # A place on the horizon: the middle of a ring of blocks may be outside.
    nearest = nodes[np.hypot(*(frame.node_places(nodes) - middle).T).argmin()]
    at = frame.node_places(np.array([nearest]))[0]
    return GeosurfWarning(
        "pinched out",
        sheet.name,
        f"Horizon {sheet.name!r} has no data over {size}, beyond faults. It coincides with "
        f"{other.sheet.name!r} there, and the zone between the two is absent.",
        "Check it on the map, where it is hatched. fill_empty_blocks=True continues it from its "
        "neighbouring block instead.",
        (*at.tolist(), float(other.heights[nearest])),
    )


__all__ = ["pinched_out"]
