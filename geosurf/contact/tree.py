"""Broad phase by trees of boxes: built once for a surface, walked for every pair.

A tree costs about as much as the voxels of one pair, but it stays on the surface and serves all its
pairs and all later calls in the same frame; and planes are tested against boxes, so that huge
flat faces reach only what they can cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geosurf.kernels import tree
from geosurf.kernels.voxels import triangle_boxes
from geosurf.model import TriSurface


@dataclass(frozen=True)
class BoxTree:
    """Local vertices, triangles and the tree over them; see `geosurf.kernels.tree`."""

    x: np.ndarray
    triangles: np.ndarray
    boxes: np.ndarray
    order: np.ndarray
    nodes: np.ndarray
    levels: np.ndarray


def tree_of(surface: TriSurface, origin: np.ndarray) -> BoxTree:
    """The tree of a surface in a frame, remembered on the surface for one frame at a time."""
    kept = surface.__dict__.get("_tree")
    if kept is not None and np.array_equal(kept[0], origin):
        return kept[1]
    x = surface.vertices - origin
    boxes = triangle_boxes(x, surface.triangles)
    order = tree.morton_order(boxes)
    nodes, levels = tree.build_tree(boxes, order)
    built = BoxTree(x, surface.triangles, boxes, order, nodes, levels)
    surface.__dict__["_tree"] = (origin.copy(), built)
    return built


def candidate_pairs(one: BoxTree, two: BoxTree, *, same: bool = False):
    """Pairs of triangles that may meet, and what the search cost.

    Returns
    -------
    pairs : ndarray of int64, shape (n_pair, 2)
        Rows of both surfaces. With `same`, the lower row first.
    cost : dict
        Numbers of tree nodes visited, of candidate faces and of candidate pairs.
    """
    pairs = np.empty((4096, 2), dtype=np.int64)
    while True:
        n, visited = tree.tree_pairs(
            one.x, one.triangles, one.boxes, one.order, one.nodes, one.levels,
            two.x, two.triangles, two.boxes, two.order, two.nodes, two.levels, same, pairs,
        )  # fmt: skip
        if n <= len(pairs):
            break
        pairs = np.empty((n, 2), dtype=np.int64)
    pairs = pairs[:n].copy()
    faces = len(np.unique(pairs[:, 0])) + (0 if same else len(np.unique(pairs[:, 1])))
    return pairs, {"voxels": 0, "nodes": visited, "candidate_faces": faces, "pairs": n}
