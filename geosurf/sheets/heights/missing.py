"""Blocks next to a fault in which a horizon has no data.

A horizon whose data end before a fault has no wall on it: no trace, and nothing to tear. Where its
lattice goes on beyond the fault, a block of the model would silently lack the horizon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import label

from geosurf.conventions import place
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.mesh import join_pairs
from geosurf.model import Sheet, TriSurface
from geosurf.sheets.faults.fault_distance import mesh_blocks, side_at_own_height
from geosurf.sheets.faults.traces import FaultMesh
from geosurf.sheets.heights.grid_solver import FILL
from geosurf.sheets.heights.state import Heights
from geosurf.sheets.lattice.picks import Picks, frame_of_lattice
from geosurf.sheets.lattice.solve import around, draped

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
    missing = []
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
            missing.append(Missing(mesh.name, name, far[nearest] * picks.frame.cell, at, nodes))
        elif len(nodes):
            raise GeometryError(
                f"horizon {picks.name!r} has data on both sides of fault {mesh.name!r}, near "
                f"{place(at)}, with a gap of more than {FILL:g} cells between them. Interpolate "
                "the horizon across the fault, as a mapping package does, then tear it.",
                place=at,
                surfaces=(picks.name, mesh.name),
            )
    return missing


def refuse_missing(picks: Picks, missing: Sequence[Missing]) -> None:
    """Name the blocks without data."""
    if missing:
        sides = ", ".join(repr(block.side) for block in missing)
        first = missing[0]
        raise GeometryError(
            f"horizon {picks.name!r} has no data in the block {sides}: its data end "
            f"{first.far:.0f} m before fault {first.fault!r}, at {place(first.place)}. {REMEDY}",
            place=first.place,
            surfaces=(picks.name, *(block.fault for block in missing)),
        )


def continued(picks: Picks, missing: Sequence[Missing]) -> tuple[Picks, list[dict]]:
    """The data with the absent parts beyond their faults filled by a membrane; what was filled."""
    shape = picks.frame.shape

    # each absent part as a whole, as far as it reaches, once it is next to the fault
    part, _ = label(np.isnan(picks.means).reshape(shape), np.ones((3, 3)))
    part = part.ravel()
    heights = picks.means.copy()
    notes, filled = [], []
    for block in missing:
        fill = np.flatnonzero(np.isin(part, distinct(part[block.nodes])) & np.isnan(heights))
        if not len(fill):
            continue
        heights[fill] = draped(heights, fill, shape, picks.frame.stretch)
        filled.append(fill)
        at = [float(c) for c in block.place[:2]]
        notes.append({"nodes": len(fill), "over": block.fault, "place": at})
    fill = distinct(*filled)
    fill = fill[np.isfinite(heights[fill])]

    # filled nodes become picks like all others, in the order of nodes
    node = np.concatenate([picks.node, fill])
    z = np.concatenate([picks.z, heights[fill]])
    order = np.argsort(node, kind="stable")
    return replace(picks, given_node=node[order], z=z[order]), notes


# ---- stand in ----------------------------------------
# Blocks in which a horizon is missing, given the heights of the horizon that it coincides with.
#
# The other horizon is torn already. Its mesh falls apart into blocks where faults cut through, so
# it shows how far the missing part goes.


SHARE = 0.2  # of nodes next to a fault: fewer of one block are on the other side of it


@dataclass(frozen=True, eq=False)
class StandIn:
    """A horizon that another one coincides with where that is missing.

    Attributes
    ----------
    sheet : Sheet
    heights : ndarray of float64, shape (n_node,)
        [m]; NaN where it has no node.
    block_of_vertex : ndarray of int64, shape (n_vertex,)
        Connected part of its mesh that each vertex of ``sheet.surface`` is in.
    block : ndarray of int64, shape (n_node,)
        The same for nodes of the lattice; -1 where there is none.
    """

    sheet: Sheet
    heights: np.ndarray
    block_of_vertex: np.ndarray
    block: np.ndarray

    @classmethod
    def of(cls, sheet: Sheet, picks: Picks) -> StandIn:
        """The stand-in for a horizon on the same lattice.

        Raises
        ------
        InputError
            If the horizon is not a grid, or on another lattice.
        """
        frame, heights = frame_of_lattice(sheet.lattice, f"horizon {sheet.name!r}")
        grid = picks.frame
        same = picks.on_nodes and grid.shape == frame.shape
        if same:
            corners = np.array([0, grid.shape[1] - 1, grid.shape[0] * grid.shape[1] - 1])
            off = np.abs(grid.node_places(corners) - frame.node_places(corners)).max()
            same = bool(off <= 1e-6 * grid.cell)
        if not same:
            raise InputError(
                f"horizon {picks.name!r} cannot be pinched out onto {sheet.name!r}, since the two "
                "are on different grids. Resample one of them to the nodes of the other."
            )
        number = _vertex_of_nodes(sheet)
        block_of_vertex = parts_of(sheet.surface)
        block = np.where(number >= 0, block_of_vertex[np.maximum(number, 0)], -1)
        return cls(sheet, heights.ravel(), block_of_vertex, block)


def _vertex_of_nodes(sheet: Sheet) -> np.ndarray:
    """Vertex of the mesh of a sheet at each node of its lattice, int64 (n_node,); -1 for none."""
    number: np.ndarray = sheet.lattice.vertex_of_node.ravel()
    if sheet.mesh is None:  # vertices are nodes, in order
        return number

    # parts of the mesh are those of another horizon: nodes are found by place, to the last digit
    rows = [np.ascontiguousarray(one + 0.0).view("V24").ravel() for one in (
        sheet.mesh.vertices, sheet.lattice.build_vertices())]  # fmt: skip
    order = np.argsort(rows[0])
    at = np.minimum(np.searchsorted(rows[0], rows[1], sorter=order), len(order) - 1)
    vertex = np.where(rows[0][order[at]] == rows[1], order[at], -1)
    return np.where(number >= 0, vertex[np.maximum(number, 0)], -1)


def parts_of(surface: TriSurface) -> np.ndarray:
    """Connected part of a mesh that each of its vertices is in, int64 (n_vertex,)."""
    t = surface.triangles
    return join_pairs(np.concatenate([t[:, :2], t[:, 1:]]), surface.n_vertex)


def nodes_to_stand_in(
    picks: Picks,
    state: Heights,
    missing: Sequence[Missing],
    meshes: Sequence[FaultMesh],
    other: StandIn,
) -> np.ndarray:
    """
    Absent nodes of the blocks in which a horizon has no data, int64 (n,), rising.

    Parameters
    ----------
    picks : Picks
    state : Heights
        Of a pass without these blocks.
    missing : sequence of Missing
        Sides of faults without data and without a trace.
    meshes : sequence of FaultMesh
    other : StandIn
    """
    absent = np.isnan(picks.means) & np.isfinite(other.heights)
    blocks: set[int] = set()
    for one in missing:
        mesh = next(mesh for mesh in meshes if mesh.name == one.fault)
        nodes = _on_side(one.nodes[absent[one.nodes]], one.side[-1], mesh, picks, other)
        touched, times = np.unique(other.block[nodes], return_counts=True)
        blocks |= set(touched[times >= SHARE * len(nodes)].tolist())

    # parts between traces that no datum reaches; one with ignored data is not without data
    if len(state.stray) and np.isnan(picks.means[state.stray]).all():
        for part in _parts_of_nodes(state.stray, picks.frame.shape):
            touched, times = np.unique(other.block[part], return_counts=True)
            blocks.add(int(touched[times.argmax()]))  # a few nodes are across a dipping fault

    # blocks farther on, of which data have at most a rim: the same faults at other heights
    if blocks:
        listed, number = np.unique(other.block, return_inverse=True)
        share = np.bincount(number, np.isfinite(picks.means)) / np.bincount(number)
        blocks |= set(listed[share < SHARE].tolist())

    # nodes next to faults that data of their own side have given a height keep it
    solved = np.isfinite(state.values).ravel()
    blocks.discard(-1)
    return np.flatnonzero(np.isin(other.block, list(blocks)) & absent & ~solved)


def _on_side(
    nodes: np.ndarray, side: str, mesh: FaultMesh, picks: Picks, other: StandIn
) -> np.ndarray:
    """Those of some nodes that are on a side of a fault at the heights of the other horizon."""
    there = np.column_stack([picks.frame.cells_of_node(nodes), other.heights[nodes]])
    far, of = side_at_own_height(mesh, mesh_blocks(mesh, FILL), there, FILL)
    return nodes[(of == (1 if side == "+" else -1)) & (far < FILL)]


def _parts_of_nodes(nodes: np.ndarray, shape: tuple[int, int]) -> list[np.ndarray]:
    """Connected parts of some nodes of a lattice."""
    mask = np.zeros(shape, dtype=bool)
    mask.ravel()[nodes] = True
    part, n = label(mask, np.ones((3, 3)))
    return [np.flatnonzero(part.ravel() == k) for k in range(1, n + 1)]


def stood_in(picks: Picks, nodes: np.ndarray, other: StandIn) -> Picks:
    """The picks with heights of the other horizon at some nodes that had none."""
    node = np.concatenate([picks.node, nodes])
    z = np.concatenate([picks.z, other.heights[nodes]])
    present = np.isfinite(z)
    order = np.argsort(node[present], kind="stable")
    return replace(picks, given_node=node[present][order], z=z[present][order])
