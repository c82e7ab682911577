"""Join edges of triangles to lines and rings, and store lists of lines as one dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.kernels.lattices.sets import distinct
from geosurf.kernels.meshes.chains import link_segments

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


def chains_of(edges: np.ndarray, x: np.ndarray) -> list[np.ndarray]:
    """
    Link edges to lines.

    Parameters
    ----------
    edges : ndarray of int64, shape (n, 2)
        Rows of `x`, each edge once.
    x : ndarray of float64, shape (n_vertex, 3)

    Returns
    -------
    list of ndarray of int64
        Rows of `x` along each line; closed ones repeat the first. Lines end where other than two
        edges meet. Numbers of vertices do not matter: lines start at the end that lies farther
        west (south, down), closed ones at the westernmost vertex, and are sorted by that.

    Examples
    --------
    >>> chains_of(np.array([[2, 1], [0, 1]]), np.eye(3))[0].tolist()
    [2, 1, 0]
    """
    if len(edges) == 0:
        return []

    # vertices are numbered by place (x, then y, then z), so that neither the order of edges nor the
    # numbers of vertices decide where a line starts
    used = distinct(edges)
    used = used[np.lexsort(x[used].T[::-1])]  # numbered by place
    rank = np.empty(len(x), dtype=np.int64)
    rank[used] = np.arange(len(used))

    # sorted: each edge from its lower to its higher end, edges in rising order
    segments = np.sort(rank[edges], axis=1)
    segments = segments[np.lexsort(segments.T[::-1])]
    nodes, offsets, _ = link_segments(segments, np.array([0, len(segments)]), len(used))
    lines = [nodes[a:b] for a, b in pairwise(offsets.tolist())]

    # open lines start at the lower of their two ends
    lines = [line[::-1] if line[-1] < line[0] else line for line in lines]
    return [used[line] for line in sorted(lines, key=lambda line: line.tolist())]


def rings_of(triangles: np.ndarray, x: np.ndarray) -> list[np.ndarray]:
    """
    Rim of some triangles: closed rings, counter-clockwise around them, clockwise around holes.

    Parameters
    ----------
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`; neighbours face the same way.
    x : ndarray of float64, shape (n_vertex, 3)

    Returns
    -------
    list of ndarray of int64
        Rows of `x`; the first is not repeated. They start at their westernmost vertex.

    Examples
    --------
    >>> x = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> rings_of(np.array([[0, 1, 2], [0, 2, 3]]), x)[0].tolist()
    [0, 1, 2, 3]
    """
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    n = len(x)

    # an edge of two triangles that face alike occurs once in each direction; on the rim its reverse
    # is missing
    rim = ~np.isin(start * n + end, end * n + start)
    start, end = start[rim], end[rim]
    # numbered by place, so that where rings touch the way on does not depend on numbers
    used = distinct(start)
    used = used[np.lexsort(x[used].T[::-1])]
    rank = np.empty(n, dtype=np.int64)
    rank[used] = np.arange(len(used))

    # from each rim vertex to the next (several where rings touch in a vertex); lists are filled in
    # falling order, so pop gives the lowest
    onward: dict[int, list[int]] = {}
    for a, b in sorted(zip(rank[start].tolist(), rank[end].tolist(), strict=True), reverse=True):
        onward.setdefault(a, []).append(b)
    rings = []

    # each ring starts at its lowest vertex: lower ones have been used up by then
    for first in range(len(used)):
        while onward.get(first):
            ring, at = [first], onward[first].pop()
            while at != first:
                ring.append(at)
                at = onward[at].pop()
            rings.append(used[ring])
    return rings


def ragged(
    lines: Sequence[np.ndarray],
    columns: Mapping[str, tuple[str, str]],
    labels: Mapping[str, tuple[Sequence[Any], dict[str, str]]],
    attrs: Mapping[str, Any],
) -> xarray.Dataset:
    """
    Lines of any length as one dataset: points one after the other (CF: contiguous ragged array).

    Parameters
    ----------
    lines : sequence of ndarray of float64, each (n, n_column)
    columns : mapping of str to (units, long_name)
    labels : mapping of str to (values, attrs)
        One value for each line.
    attrs : mapping

    Returns
    -------
    xarray.Dataset
        Columns over ``point``; labels and ``count`` over ``line``; ``line_of_point``.
    """
    import xarray as xr

    count = np.array([len(line) for line in lines], dtype=np.int64)

    # the empty block gives a table with all columns even when there is no line
    table = np.concatenate([*lines, np.empty((0, len(columns)))])
    data: dict[str, Any] = {
        name: ("point", table[:, k], {"units": units, "long_name": words})
        for k, (name, (units, words)) in enumerate(columns.items())
    }
    data["line_of_point"] = (
        "point", np.repeat(np.arange(len(count)), count), {"long_name": "line of each point"},
    )  # fmt: skip
    data["count"] = (
        "line",
        count,
        {"long_name": "points of each line", "sample_dimension": "point"},
    )
    for name, (values, more) in labels.items():
        data[name] = ("line", np.array(values, dtype=None if len(values) else object), more)
    return xr.Dataset(data, attrs=dict(attrs))
