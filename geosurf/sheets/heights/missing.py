"""Blocks next to a fault in which a horizon has no data.

A horizon whose data end before a fault has no wall on it: no trace, and nothing to tear. Where its
lattice goes on beyond the fault, a block of the model would silently lack the horizon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeometryError
from geosurf.kernels.lattices.sets import distinct
from geosurf.sheets.faults.fault_distance import mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.grid_solver import FILL
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.drape import around, draped
from geosurf.sheets.lattice.picks import Picks

REMEDY = (
    "Add data there, set fill_empty_blocks=True to continue the horizon across the fault, or leave "
    "the fault out."
)


@dataclass(frozen=True, eq=False)
class Missing:
    """A side of a fault on which a horizon has no data, though it ends near that fault.

    Attributes
    ----------
    fault : str
    side : str
        Of the fault: ``"F1+"`` is its hanging wall.
    far : float
        From the data to the fault, at their own height [m].
    place : ndarray (3,)
        The nearest datum [m].
    nodes : ndarray of int64
        Absent nodes next to the fault on that side.
    """

    fault: str
    side: str
    far: float
    place: np.ndarray
    nodes: np.ndarray


def missing_blocks(picks: Picks, state: Heights, meshes: Sequence[FaultMesh]) -> list[Missing]:
    """Sides of faults without a trace on which data are missing within 16 cells.

    Raises
    ------
    GeometryError
        If data lie on both sides of such a fault, in a gap too wide to find the trace in.
    """
    if not picks.on_nodes:
        return []

    # a fault with a trace has both walls, or is refused as a block without data
    met = {trace.fault for trace in state.network.traces}
    met |= {fault for fault, _ in state.network.dropped}
    absent = np.isnan(picks.means)
    found = []
    for number, mesh in enumerate(meshes):
        if number in met or not absent.any():
            continue
        blocks = mesh_blocks(mesh, FILL)

        # picks near the fault, with their side of it at their own height
        uv = picks.columns(np.arange(len(picks.z))) * picks.frame.stretch
        rows, _ = blocks.of(uv)
        points = np.column_stack([uv[rows], picks.z[rows]])
        far, side = side_at_own_height(mesh, blocks, points, FILL)
        rows, far, side = rows[side != 0], far[side != 0], side[side != 0]
        if not len(rows):
            continue

        # absent nodes near these picks, at their median height, on the other side of the fault:
        # there the lattice goes on without data
        nearest = int(far.argmin())
        nodes = around(picks.nodes_of(rows), picks.frame.shape, int(FILL))
        nodes = nodes[absent[nodes]]
        level = np.full(len(nodes), np.median(picks.z[rows]))
        there = np.column_stack([picks.frame.cells_of_node(nodes), level])
        beyond, of = side_at_own_height(mesh, blocks, there, FILL)
        nodes = nodes[(of == -side[nearest]) & (beyond < FILL)]
        at = picks.places(rows[nearest : nearest + 1])[0]

        # data on one side only can be continued; data on both sides, with a wide gap, cannot be
        # torn
        if len(nodes) and (side == side[nearest]).all():
            name = f"{mesh.name}{'-' if side[nearest] > 0 else '+'}"
            found.append(Missing(mesh.name, name, far[nearest] * picks.frame.cell, at, nodes))
        elif len(nodes):
            raise GeometryError(
                f"horizon {picks.name!r} has data on both sides of fault {mesh.name!r}, near "
                f"{place(at)}, with a gap of more than {FILL:g} cells between them. Interpolate "
                "the horizon across the fault, as a mapping package does, then tear it.",
                place=at,
                surfaces=(picks.name, mesh.name),
            )
    return found


def refuse_missing(picks: Picks, missing: Sequence[Missing]) -> None:
    """Name the blocks without data."""
    if missing:
        sides = ", ".join(repr(one.side) for one in missing)
        first = missing[0]
        raise GeometryError(
            f"horizon {picks.name!r} has no data in the block {sides}: its data end "
            f"{first.far:.0f} m before fault {first.fault!r}, at {place(first.place)}. {REMEDY}",
            place=first.place,
            surfaces=(picks.name, *(one.fault for one in missing)),
        )


def continued(picks: Picks, missing: Sequence[Missing]) -> tuple[Picks, list[dict]]:
    """The data with the absent parts beyond their faults filled by a membrane; what was filled."""
    from scipy.ndimage import label

    shape = picks.frame.shape

    # each absent part as a whole, as far as it reaches, once it is next to the fault
    part, _ = label(np.isnan(picks.means).reshape(shape), np.ones((3, 3)))
    part = part.ravel()
    heights = picks.means.copy()
    notes, filled = [], []
    for one in missing:
        fill = np.flatnonzero(np.isin(part, distinct(part[one.nodes])) & np.isnan(heights))
        if not len(fill):
            continue
        heights[fill] = draped(heights, fill, shape, picks.frame.stretch)
        filled.append(fill)
        at = [float(c) for c in one.place[:2]]
        notes.append({"nodes": len(fill), "over": one.fault, "place": at})
    fill = distinct(*filled)
    fill = fill[np.isfinite(heights[fill])]

    # filled nodes become picks like all others, in the order of nodes
    node = np.concatenate([picks.node, fill])
    z = np.concatenate([picks.z, heights[fill]])
    order = np.argsort(node, kind="stable")
    return replace(picks, given_node=node[order], z=z[order]), notes
