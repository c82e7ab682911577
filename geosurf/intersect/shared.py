"""Read the curves of two rebuilt surfaces from their common edges."""

from __future__ import annotations

import numpy as np

from geosurf.errors import InputError
from geosurf.intersect.link import canonical, link
from geosurf.model import Curves, Patches, TriSurface, frozen


def is_torn(surface: TriSurface) -> bool:
    """Whether a surface is a sheet that was continued beyond its faults to be cut there."""
    return "ghost" in surface.vertex_data


def shared_curves(patches: Patches, first: str, second: str) -> Curves:
    """
    Read the curves of two surfaces off their rebuilt meshes.

    A torn sheet ends on its faults: its curves with them are where it ends, not where the mesh
    that was continued beyond them would cross.

    Parameters
    ----------
    patches : Patches
        Without what lies beyond the faults (`trim_sheets`).
    first, second : str
        Names of two surfaces that differ.

    Returns
    -------
    Curves
        Without touching points and overlap areas.

    Raises
    ------
    InputError
        If both are one.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> shared_curves(rebuild_surfaces([flat, wall]), "Top", "F1").length
    6.0
    """
    if first == second:
        raise InputError(
            f"horizon {first!r} is torn, so it has no intersection lines with itself. Name "
            "a fault or another horizon."
        )

    # edges of the mesh that both surfaces own
    mine, others = (
        patches.curve_edges_by_surface[patches.names.index(name)] for name in (first, second)
    )
    edges = patches.curve_edges[np.intersect1d(mine, others, assume_unique=True)]
    segments = np.unique(np.sort(edges, axis=1), axis=0)
    # ends of these edges are points of the pieces: no node of a lattice is listed
    points, segments, pairs = canonical(
        patches.pieces.x, segments, np.tile([0, 1], (len(segments), 1))
    )
    curves, surfaces_of_curve, closed = link(segments, pairs, len(points))
    return Curves(
        names=(first, second),
        local=frozen(points, np.float64),
        origin=patches.origin,
        segments=frozen(segments, np.int64),
        surfaces_of_segment=frozen(pairs, np.int64),
        curves=tuple(frozen(curve, np.int64) for curve in curves),
        surfaces_of_curve=frozen(surfaces_of_curve, np.int64),
        closed=frozen(closed, np.bool_),
    )
