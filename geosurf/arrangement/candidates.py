"""Find the pairs of triangles that may meet, as keys, for each pair of surfaces."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.arrangement import tree
from geosurf.arrangement.threads import TooManyPairs, check_pairs, map_threads, refusal
from geosurf.arrangement.torn_trees import candidate_pairs as candidate_pairs_of
from geosurf.arrangement.torn_trees import tree_for
from geosurf.arrangement.tree import needed, of_one_map, pairs_of_grids, pairs_of_one_map
from geosurf.errors import InputError
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import number_keys
from geosurf.kernels.search.tree import faces_in_box, fill_voxels, voxel_pairs
from geosurf.kernels.sheets.torn_links import are_over_nodes, edges_over_ghosts, overlap_in_map
from geosurf.model import TriSurface
from geosurf.model.base import any_of

# ---- known pairs ----------------------------------------
# Contacts of two surfaces, stored for the next search of the same two.
#
# A search decides each candidate pair of triangles alone: how two triangles meet depends on their
# coordinates and the origin. So what one search found of two surfaces holds for every other
# search of both, whatever other surfaces there are. Which contacts rounding could change is
# judged by the largest coordinate of all candidates; with another one, the pairs are decided
# again.


MOST = 1 << 20  # candidates of two surfaces; more are searched again


@dataclass(frozen=True)
class Known:
    """The candidates of two surfaces, and how they meet.

    Attributes
    ----------
    rows : ndarray of int64, shape (n, 2)
        Keys of both surfaces.
    spent : dict of str to int
        What the search cost.
    slip : float
        By how much coordinates could move by rounding [m].
    codes : ndarray of int64, shape (n,)
        How each pair meets: see `geosurf.kernels.contacts.triangle_contact.settled`.
    """

    rows: np.ndarray
    spent: dict[str, int]
    slip: float
    codes: np.ndarray


@dataclass(frozen=True)
class KnownPairs:
    """Where pairs are stored, by the rows of their surfaces.

    Attributes
    ----------
    get : callable
        Key -> what was stored, or None.
    put : callable
        Key and what is to be stored -> None.
    keys : list of hashable
        One of each surface, which stands for its triangles.
    """

    get: Callable[[Hashable], Any]
    put: Callable[[Hashable, Any], None]
    keys: list[Hashable]

    def of(self, i: int, j: int, *options: Hashable) -> Known | None:
        """What is known of two surfaces; None if they have not been searched."""
        found: Known | None = self.get(("pair", self.keys[i], self.keys[j], *options))
        return found

    def add(self, i: int, j: int, found: Known, *options: Hashable) -> None:
        """Store what a search found, unless that is too much."""
        if len(found.rows) <= MOST:
            self.put(("pair", self.keys[i], self.keys[j], *options), found)


# ---- broad ----------------------------------------
# Find candidate pairs with equal voxels in a common box, after Lo & Wang (2004).
#
# The global box is cut to where the two surfaces can meet, and cut again to the faces
# that reach it; voxels are sized to those faces. Only faces whose boxes reach one voxel
# together become candidates, each pair once. The voxel size changes the speed, never the result.


_FACES_PER_VOXEL = 0.5  # of the larger surface; flat between 0.2 and 2 on horizons and faults
_MOST_VOXELS = 8_000_000


@dataclass(frozen=True)
class VoxelGrid:
    """Equal voxels of edge `size` over a box, and the candidate faces of both surfaces."""

    bounds: np.ndarray
    size: float
    shape: np.ndarray
    rows_a: np.ndarray
    rows_b: np.ndarray

    @property
    def n_voxel(self) -> int:
        """Number of voxels."""
        return int(np.prod(self.shape))


def shared_box(
    boxes_a: np.ndarray, boxes_b: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """The box where two sets of boxes can meet, and the rows that reach it.

    Cut three times: faces that reach the box shrink what the others can meet. None where
    the surfaces are apart.
    """
    rows_a, rows_b = np.arange(len(boxes_a)), np.arange(len(boxes_b))
    if boxes_a is boxes_b and len(boxes_a):  # they meet everywhere
        return _bounds_of(boxes_a), rows_a, rows_a
    bounds: np.ndarray | None = None
    for _ in range(3):
        if len(rows_a) == 0 or len(rows_b) == 0:
            return None
        one = _bounds_of(boxes_a.take(rows_a, axis=0))
        two = _bounds_of(boxes_b.take(rows_b, axis=0))
        # Lower corners of the meet in the first three columns, upper ones in the last three [m].
        cut = np.concatenate([np.maximum(one[:3], two[:3]), np.minimum(one[3:], two[3:])])
        if (cut[:3] > cut[3:]).any():
            return None

        if bounds is not None and np.array_equal(cut, bounds):
            break
        bounds = cut
        rows_a = faces_in_box(boxes_a, bounds)
        rows_b = faces_in_box(boxes_b, bounds)

    if bounds is None or len(rows_a) == 0 or len(rows_b) == 0:
        return None
    return bounds, rows_a, rows_b


def fit_voxels(
    boxes_a: np.ndarray, boxes_b: np.ndarray, size: float | None = None
) -> VoxelGrid | None:
    """Voxels for two sets of boxes, or None where they are apart.

    Parameters
    ----------
    boxes_a, boxes_b : ndarray of float64, shape (n, 6)
        Lower and upper corners of the triangles' boxes.
    size : float, optional
        Edge of the voxels [m]. Default: fitted, so that the larger surface has
        about one face for two voxels, and no voxel is much smaller than a face.

    Returns
    -------
    VoxelGrid or None
    """
    found = shared_box(boxes_a, boxes_b)
    if found is None:
        return None
    bounds, rows_a, rows_b = found
    extent = bounds[3:] - bounds[:3]
    # As many voxels as faces of the larger surface, but none smaller than its usual face.
    if size is None:
        of, rows = (boxes_a, rows_a) if len(rows_a) >= len(rows_b) else (boxes_b, rows_b)
        sides = of.take(rows, axis=0)
        face = float(np.median((sides[:, 3:] - sides[:, :3]).max(axis=1)))
        wanted = max(len(rows) / _FACES_PER_VOXEL, 1.0)

        # the limit is for sizes that users choose; rounding up an axis may double the number
        wanted = min(wanted, 0.45 * _MOST_VOXELS)
        size = max(face, _size_for(extent, wanted))
    size = float(size)

    # Boxes that meet in a point have no extent.
    if size <= 0.0:
        size = max(float(extent.max()), 1.0)

    with np.errstate(over="ignore"):  # more than can be counted is more than there may be
        shape = np.maximum(np.ceil(extent / size), 1.0)
        n_voxel = np.prod(shape)
    if n_voxel > _MOST_VOXELS:
        raise InputError(
            f"voxel_size = {size:g} m gives {n_voxel:.3g} voxels; the limit is "
            f"{_MOST_VOXELS}. Choose a larger voxel_size, or leave it out."
        )
    return VoxelGrid(bounds, size, shape.astype(np.int64), rows_a, rows_b)


def _size_for(extent: np.ndarray, n_voxel: float) -> float:
    """Edge of cubes, about `n_voxel` of which fill a box that may be flat."""
    sides = np.sort(extent)[::-1]
    for n_axis in (3, 2, 1):
        # A flat box is filled with squares, a line with intervals: no axis gets less than one
        # voxel.
        used = sides[:n_axis]
        if used[-1] > 0:
            size = (np.prod(used) / n_voxel) ** (1.0 / n_axis)
            if n_axis == 1 or size <= used[-1]:
                return float(size)
    return 0.0


def candidate_pairs(
    boxes_a: np.ndarray, boxes_b: np.ndarray, *, size: float | None = None, same: bool = False
) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles whose boxes meet.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 2)
        Rows of `boxes_a` and of `boxes_b`. With `same`, the lower row first.
    cost : dict
        Numbers of voxels, of candidate faces and of candidate pairs.
    """
    grid = fit_voxels(boxes_a, boxes_b, size)
    if grid is None:
        return np.empty((0, 2), dtype=np.int64), {"voxels": 0, "pairs": 0}

    # Voxels hold the faces of the second surface; those of the first are looked up in them.
    offsets, filled = fill_voxels(boxes_b, grid.rows_b, grid.bounds, grid.size, grid.shape)
    pairs = np.empty((4 * (len(grid.rows_a) + len(grid.rows_b)) + 64, 2), dtype=np.int64)
    while True:
        n = voxel_pairs(
            boxes_a, grid.rows_a, boxes_b, grid.bounds, grid.size, grid.shape, offsets, filled,
            same, pairs,
        )  # fmt: skip
        if n <= len(pairs):
            break
        check_pairs(n)
        pairs = np.empty((n, 2), dtype=np.int64)

    cost = {"voxels": grid.n_voxel, "pairs": n}
    return pairs[:n].copy(), cost


def _bounds_of(boxes: np.ndarray) -> np.ndarray:
    """Common box of some boxes."""
    low = boxes[:, :3].min(axis=0, initial=np.inf)
    return np.concatenate([low, boxes[:, 3:].max(axis=0, initial=-np.inf)])


def find_candidates(
    surfaces: Sequence[TriSurface],
    pairs: Sequence[tuple[int, int]],
    voxels: bool,
    voxel_size: float | None,
    origin: np.ndarray,
    known: Mapping[tuple[int, int], Known],
) -> tuple[
    list[tuple[int, int, np.ndarray]], dict[tuple[int, int], dict[str, int]], dict[str, int]
]:
    """Candidate pairs of keys for each pair of surfaces, and what they cost, each and in all.

    What `known` has is not searched.
    """
    found = []
    costs = {}
    cost = {"voxels": 0, "nodes": 0, "candidate_faces": 0, "pairs_tested": 0}

    # a graph has one elevation for each place in the map: it cannot meet itself
    wanted = [(i, j) for i, j in pairs if i != j or not _is_graph(surfaces[i])]
    if voxels:
        boxes = [tree.boxes_of(s) for s in surfaces]
    else:
        trees = [tree_for(s) for s in surfaces]
        asked = [pair for pair in wanted if pair not in known]
        near = {*known, *near_surfaces(surfaces, asked)}
        cost["nodes"] += len(wanted) - len(near)
        wanted = [pair for pair in wanted if pair in near]

    def search(i: int, j: int) -> tuple[np.ndarray, dict[str, int]]:
        """Candidates of one pair of surfaces, and what finding them cost."""
        # a torn sheet has its own search: neighbours by the thousand are near one another
        if i == j and not voxels and is_torn(surfaces[i]):
            return pairs_with_itself(surfaces[i], origin)
        one_map = i != j and of_one_map(surfaces[i], surfaces[j])
        if not voxels:
            if i == j:
                return tree.candidate_pairs(*[tree.tree_of(surfaces[i])] * 2, same=True)
            both: Any = (surfaces[i], surfaces[j]), (trees[i], trees[j])
            return _pairs_of_two(one_map, origin, *both)

        # both surfaces have one where they share a map
        lattices: Any = surfaces[i].lattice, surfaces[j].lattice
        rows, spent = candidate_pairs(boxes[i], boxes[j], size=voxel_size, same=i == j)
        keys = [_keys_of_rows(surfaces[s], rows[:, k]) for k, s in enumerate((i, j))]
        rows = np.stack(keys, axis=1)
        if i == j and is_torn(surfaces[i]):
            rows = rows[over_itself(surfaces[i], rows, origin)]
        return (rows[needed(lattices[0], lattices[1], rows)] if one_map else rows), spent

    def searched(i: int, j: int) -> tuple[np.ndarray, dict[str, int]]:
        """`search`, with the names of the surfaces where there is no room for their pairs."""
        try:
            return search(i, j)
        except TooManyPairs as error:
            raise refusal(error.n, [surfaces[i].name, surfaces[j].name]) from error

    # Results come in the order of the pairs, whatever thread found them first.
    asked = [pair for pair in wanted if pair not in known]
    searches = dict(zip(asked, map_threads(searched, asked), strict=True))
    for i, j in wanted:
        one = known.get((i, j))
        rows, spent = searches[i, j] if one is None else (one.rows, one.spent)
        costs[i, j] = spent
        for key, value in spent.items():
            cost["pairs_tested" if key == "pairs" else key] += value
        found.append((i, j, rows))
    return found, costs, cost


def _pairs_of_two(
    one_map: bool,
    origin: np.ndarray,
    surfaces: tuple[TriSurface, TriSurface],
    trees: tuple[Any, Any],
) -> tuple[np.ndarray, dict[str, int]]:
    """Candidates of two surfaces."""
    if one_map:
        lattices: Any = surfaces[0].lattice, surfaces[1].lattice
        return pairs_of_one_map(lattices, trees)
    found = pairs_of_grids(surfaces, trees, origin)
    return candidate_pairs_of(*trees) if found is None else found


def near_surfaces(
    surfaces: Sequence[TriSurface], pairs: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of some pairs of surfaces whose boxes meet."""
    trees: list[Any] = [tree_for(s) for s in surfaces]
    apart = tree.apart(trees).tolist()
    return [(i, j) for i, j in pairs if i == j or not apart[i][j]]


def _is_graph(surface: TriSurface) -> bool:
    return surface.lattice is not None and surface.lattice.is_graph


def _keys_of_rows(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    return rows if surface.lattice is None else surface.lattice.keys_of_rows(rows)


# ---- find self-contacts of torn sheets: where triangles overlap on the map ---------------
#
# A torn sheet is a graph over a lattice, in several copies next to its faults. Two of its
# triangles that are neighbours in the map have nothing but corners and edges of the mesh in
# common, and those without a ghost are a graph, of which none meet. What is left to be asked lies
# over one another, or has edges over one edge of the map.
#
# Where a surface states which node of the lattice each vertex lies over (``vertex_data["node"]``),
# the order of heights there shows which edges cross. Drogon: 10 to 40 pairs of triangles in place
# of 14 000.


GHOST, NODE = "ghost", "node"


def is_torn(surface: TriSurface) -> bool:
    """Whether a surface is a sheet that was continued beyond its faults."""
    return GHOST in surface.vertex_data


def pairs_with_itself(surface: TriSurface, origin: np.ndarray) -> tuple[np.ndarray, dict[str, int]]:
    """Pairs of triangles of a torn sheet that may meet, and what the search cost.

    Returns
    -------
    pairs, cost
        As `tree.candidate_pairs` with ``same=True``.
    """
    if NODE in surface.vertex_data and _are_over_nodes(surface):
        rows = _crossing_over_nodes(surface, float(origin[2]))
        return rows, {"nodes": 0, "pairs": len(rows)}
    whole = tree.tree_of(surface)
    rows, cost = tree.pairs_of_some(surface, whole, _with_ghosts(surface))
    return rows[over_itself(surface, rows, origin)], cost


def _are_over_nodes(surface: TriSurface) -> bool:
    """Whether all vertices over one node are at one place in the map: repairs may move some."""
    if surface.torn is not None and surface.torn.node_of_ghost is not None:
        return True  # ghosts are where their nodes are
    node = surface.vertex_data[NODE]
    return bool(are_over_nodes(node, surface.vertices, int(node.max(initial=-1)) + 1))


def over_itself(surface: TriSurface, pairs: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Which pairs of triangles of a torn sheet, one of them with a ghost, lie over one another."""
    mask: np.ndarray = any_of(_with_ghosts(surface)[pairs])
    some = np.flatnonzero(mask)
    # Only vertices of these triangles are put into the exact frame.
    triangles, number = number_keys(pairs[some].reshape(-1))
    corners = surface.triangles[triangles]
    nodes, corner = number_keys(corners.reshape(-1))

    x = surface.vertices[nodes] - origin
    if len(some):
        of = corner.reshape(-1, 3), number.reshape(-1, 2)
        mask[some] = overlap_in_map(x, *of, *frame_of(x))
    return mask


def _crossing_over_nodes(surface: TriSurface, level: float) -> np.ndarray:
    """Pairs (n, 2) of triangles with edges over two nodes in common that cross or touch there.

    Triangles over three nodes in common that cross have such edges. So have those on both sides
    of the edge: one of them may be where the other sheet ends.
    """
    node, ghost = surface.vertex_data[NODE], surface.vertex_data[GHOST]
    n = int(node.max(initial=-1)) + 1
    if surface.torn is None:
        z = surface.vertices[:, 2]
        rows, one, two = edges_over_ghosts(surface.triangles, node, ghost, n)
    else:  # ghosts are of triangles at faults: only those next to these are looked at
        z, some = surface.torn.heights_of_vertices(), surface.torn.rows_beside_copies
        rows, one, two = edges_over_ghosts(surface.corners_of_keys(some), node, ghost, n)
        rows = some[rows]

    # Half-edges over the same two nodes follow one another in `order`.
    key = node[one] * n + node[two]
    order = np.argsort(key, kind="stable")
    key, rows, one, two = key[order], rows[order], one[order], two[order]

    # as in the frame of the search: two heights that are rounded to one are one there
    z = z - level

    # Compare each half-edge with the next ones over the same nodes, one step further each time.
    found = [np.empty((0, 2), dtype=np.int64)]
    for step in range(1, len(key)):
        a = np.flatnonzero(key[step:] == key[:-step])
        if len(a) == 0:
            break
        b = a + step
        # They cross where one is higher at the first node and lower at the second, and touch where
        # heights are equal in different vertices.
        first, second = np.sign(z[one[b]] - z[one[a]]), np.sign(z[two[b]] - z[two[a]])
        met = first * second < 0
        met |= ((first == 0) & (one[a] != one[b])) | ((second == 0) & (two[a] != two[b]))
        met = np.flatnonzero(met)
        if len(met):
            pairs = np.stack([rows[a[met]], rows[b[met]]], axis=1)
            found.append(np.sort(pairs, axis=1))

    pairs = np.concatenate(found)
    if not len(pairs):
        return pairs
    pairs = np.unique(pairs, axis=0)
    corners = surface.corners_of_keys(pairs.ravel())
    return pairs[any_of(ghost[corners].reshape(-1, 6))]


def _with_ghosts(surface: TriSurface) -> np.ndarray:
    """Which triangles have a ghost."""
    return any_of(surface.vertex_data[GHOST][surface.triangles])
