"""The lines of a sealed model, where parts of surfaces meet: which parts, and their vertices.

Parts are cut open along lines (`geosurf.write.model3d_parts`), so a vertex of a line occurs once
for each fan of faces around it. Two fans of one part are two sides of a line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geosurf.kernels.meshes.mesh import weld
from geosurf.write.model3d_parts import Parts

Edge = tuple[int, int]  # rows of two points, the smaller first


@dataclass(frozen=True, eq=False)
class Line:
    """A line where the same parts meet from end to end.

    Attributes
    ----------
    parts : tuple of int
        The parts on it, one for each side.
    vertices : ndarray of int64, shape (n_side, n_vertex)
        Rows of `Parts.vertices` along the line, one row of them for each side. A closed line
        repeats its first vertex.
    """

    parts: tuple[int, ...]
    vertices: np.ndarray


def lines_of(parts: Parts) -> list[Line]:
    """
    Return all lines where parts meet, those of faults that end inside a unit among them.

    Lines with one side, where a fault ends and meets nothing, are left out.

    Parameters
    ----------
    parts : Parts
    """
    halves, points = _border(parts)
    sides: dict[Edge, list[tuple[int, int]]] = {}  # half-edges of an edge, in order of its points
    after: dict[tuple[int, int], int] = {}  # vertex and next point -> next vertex of the same side
    for a, b in halves.tolist():
        p, q = int(points[a]), int(points[b])
        sides.setdefault((min(p, q), max(p, q)), []).append((a, b) if p < q else (b, a))
        after[a, q], after[b, p] = b, a

    part_of = np.repeat(np.arange(len(parts.surface)), np.diff(parts.first_vertex))
    kinds = {
        edge: tuple(sorted(int(part_of[a]) for a, _ in found)) for edge, found in sides.items()
    }
    found = []
    for chain in _chains(kinds):
        if len(kinds[_edge(*chain[:2])]) < 2:
            continue
        forward = chain[0] < chain[1]
        rows = []
        for pair in sides[_edge(*chain[:2])]:
            here, there = pair if forward else pair[::-1]
            row = [here, there]
            for point in chain[2:]:
                row.append(after[row[-1], point])
            rows.append(row)
        rows.sort()
        found.append(Line(tuple(int(part_of[row[0]]) for row in rows), np.array(rows)))
    return found


def _edge(p: int, q: int) -> Edge:
    return (p, q) if p < q else (q, p)


def _border(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Half-edges (n, 2) with no neighbour in their part, and the point of each vertex."""
    triangles, n = parts.triangles, len(parts.vertices)
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    alone = ~np.isin(tail * n + head, head * n + tail)
    return np.column_stack([tail[alone], head[alone]]), weld(parts.vertices)[0]


def _chains(kinds: dict[Edge, tuple[int, ...]]) -> Iterator[list[int]]:
    """Points along each line: edges of one kind, up to where others meet them."""
    around: dict[int, list[int]] = {}
    for p, q in sorted(kinds):
        around.setdefault(p, []).append(q)
        around.setdefault(q, []).append(p)
    ends = {
        p
        for p, others in around.items()
        if len(others) != 2 or kinds[_edge(p, others[0])] != kinds[_edge(p, others[1])]
    }

    # lines with ends first; what is left then are closed ones
    left = set(kinds)
    for start in [*sorted(ends), *sorted(around)]:
        for second in around[start]:
            if _edge(start, second) not in left:
                continue
            chain = [start, second]
            left.discard(_edge(start, second))
            while chain[-1] not in ends and chain[-1] != start:
                a, b = around[chain[-1]]
                chain.append(b if a == chain[-2] else a)
                left.discard(_edge(*chain[-2:]))
            yield chain


__all__ = ["Line", "lines_of"]
