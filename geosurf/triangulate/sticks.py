"""Fault sticks -> `TriSurface`: orient each stick, order them along strike, join neighbours.

Files do not promise an order, neither of sticks along strike nor of points down a
stick. So nothing here looks at the order: sticks are first put into one canonical
form, and every later step is a function of that form alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.conventions import counted, is_number, place
from geosurf.errors import SurfaceError, warn_of
from geosurf.model import FaultSticks, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.expected import listed, name_of
from geosurf.model.surfaces import points_of_stick
from geosurf.triangulate.mesh import find_zero_area, orient_fault, refuse_far, refuse_zero_area

# A stick that climbs less than this part of its length is level: its ends do not show
# about top and bottom, its neighbours do.
_LEVEL = 0.1


def triangulate_sticks(
    sticks: FaultSticks | Sequence[Any],
    *,
    name: str | None = None,
    strike: float | None = None,
    length: float | None = None,
) -> TriSurface:
    """Join fault sticks to a surface.

    Sticks may come in any order and run up or down. Points that run back and forth are sorted along
    their stick, and of sticks that come twice one is used, each with a warning.

    Sticks are chained along strike by the shortest path from stick to stick: a principal axis would
    fail on strongly curved faults, where its coordinate runs back and forth. Distances are taken
    between whole sticks, not between their midpoints, which jump where a long stick follows a
    short one.

    Parameters
    ----------
    sticks : FaultSticks, or sequence of array_like of float, each (n_point, 3)
        Easting, northing, elevation [m], positive up; two points or more each.
    name : str, optional
        Name of the fault. Default: that of `FaultSticks`; arrays have none.
    strike, length : float, optional
        Of a fault with a single stick: azimuth of its strike [degrees clockwise from north], and
        its length along strike [m], with the stick in the middle. It is refused without them.

    Returns
    -------
    TriSurface
        Role "fault", normals into the hanging wall. Vertices run stick by stick along
        strike, each from top to bottom; points that sticks share are one vertex.
        ``vertex_data["stick"]`` numbers the sticks along strike.

    Raises
    ------
    SurfaceError
        If the fault has no name, there are fewer than two sticks and no strike, a stick is not a
        line, or neighbours cross so that the surface would fold over.

    Examples
    --------
    >>> sticks = [
    ...     [[0, 0, -1500], [300, 0, -2000]],
    ...     [[300, 800, -2000], [0, 800, -1500]],
    ...     [[0, 400, -1500], [150, 400, -1750], [300, 400, -2000]],
    ... ]
    >>> fault = triangulate_sticks(sticks, name="F1")
    >>> fault.n_vertex, fault.n_triangle
    (7, 6)
    """
    if name is None and isinstance(sticks, FaultSticks):
        name = sticks.name
    if name is None:
        raise SurfaceError(
            "the sticks of a fault have no name. Pass it, as in triangulate_sticks(..., name='F1')."
        )
    name = name_of(name, "fault")
    if hasattr(sticks, "columns") or hasattr(sticks, "get_dataframe"):
        raise SurfaceError(
            f"fault {name!r}: a {type(sticks).__name__} does not state whether z is elevation or "
            f"depth. Use gs.triangulate_fault(sticks, name={name!r}, positive='down') or 'up'."
        )
    given, sticks = sticks, sticks.sticks if isinstance(sticks, FaultSticks) else sticks
    sticks = listed(sticks, "triangulate_sticks takes sticks", "give arrays (n_point, 3)")
    lines = _lines_of(sticks, name)

    # a single stick needs a direction; several show their own
    if len(lines) == 1 and (strike is not None or length is not None):
        lines = plane_of_stick(lines[0], strike, length, name)
    elif strike is not None or length is not None:
        raise SurfaceError(
            f"fault {name!r} has {counted(len(lines), 'stick')}, which define its strike. Leave "
            "strike and length out; they are for a single stick."
        )
    if len(lines) < 2:
        raise SurfaceError(
            f"fault {name!r} has {counted(len(lines), 'stick')}, but a surface needs two or "
            "more. Add sticks, or state how the fault goes on to both sides: "
            "gs.triangulate_sticks(sticks, strike=30, length=2000)."
        )
    refuse_far(name, np.concatenate(lines))

    # Sorted by coordinates, so that the result does not depend on the order of the file.
    lines.sort(key=lambda line: line.ravel().tolist())
    chain = _align([lines[i] for i in _chain(_gaps(lines))])

    points = np.concatenate(chain)
    _, first, spot = np.unique(points, axis=0, return_index=True, return_inverse=True)
    # vertices keep the order in which the chain meets them
    order = np.argsort(first)
    number = np.argsort(order)[spot.reshape(-1)]
    vertices = points[first[order]]

    # Rows of `vertices` along each stick, and triangles between neighbours.
    ids = np.split(number, np.cumsum([len(line) for line in chain])[:-1])
    strips = [_strip(a, b, vertices, name) for a, b in pairwise(ids)]
    triangles = np.concatenate(strips)
    refuse_zero_area(name, vertices, triangles, "Remove the collinear point.")

    stick = np.repeat(np.arange(len(chain)), [len(line) for line in chain])[first[order]]
    data = {"stick": stick}
    made = orient_fault(TriSurface(name, "fault", vertices, triangles, vertex_data=data))
    return in_crs_of(made, [given])


def _lines_of(sticks: Sequence[Any], name: str) -> list[np.ndarray]:
    """All sticks from top to bottom, each once; or a SurfaceError."""
    lines, moved = [], []
    for i, stick in enumerate(sticks):
        given = points_of_stick(stick, f"fault {name!r}: stick {i}")
        line, in_order = _checked(given, i, name)
        lines.append(line)
        if not in_order:
            moved.append((i, line))
    warn_of_order(moved, name)
    return without_twins(lines, name)


def _checked(line: np.ndarray, i: int, name: str) -> tuple[np.ndarray, bool]:
    """One stick from top to bottom, without repeated points, and whether its points were in order.

    Raises a SurfaceError if it is not a line.
    """
    line = line[np.r_[True, (np.diff(line, axis=0) != 0).any(axis=1)]]
    if len(line) < 2:
        raise SurfaceError(
            f"fault {name!r}: all points of stick {i} coincide at {place(line[0])}. Leave the "
            "stick out, or add a second point."
        )
    if len(line) > 2 and len(line) % 2 and (line == line[::-1]).all():
        line = line[: len(line) // 2 + 1]  # digitised down and up again
    if len({*map(tuple, line.tolist())}) < len(line):
        _, where, times = np.unique(line, axis=0, return_index=True, return_counts=True)
        raise SurfaceError(
            f"fault {name!r}: stick {i} passes {place(line[where[times > 1][0]])} twice. Split "
            "it there, or remove the loop."
        )
    along = sorted_along(line)
    in_order, line = along is line, along

    # top first; level sticks by their first coordinates, until neighbours decide
    down = (-line[0, 2], *line[0, :2]) < (-line[-1, 2], *line[-1, :2])
    return (line if down else line[::-1]), in_order


def _gaps(lines: list[np.ndarray]) -> np.ndarray:
    """Distance between sticks, (n_stick, n_stick): mean distance of five points of one to
    the other, whichever of the two is less, so that a short stick next to a long one is near.
    """
    # one_way[j, i]: mean distance of five points of stick j from the line of stick i
    samples = np.concatenate([_sample(line) for line in lines])
    one_way = np.empty((len(lines), len(lines)))
    for i, line in enumerate(lines):
        start, along = line[:-1], np.diff(line, axis=0)
        t = np.einsum("psk,sk->ps", samples[:, None] - start, along) / (along**2).sum(axis=1)
        foot = start + np.clip(t, 0.0, 1.0)[..., None] * along
        near = np.linalg.norm(samples[:, None] - foot, axis=2).min(axis=1)
        one_way[:, i] = near.reshape(len(lines), 5).mean(axis=1)
    return np.minimum(one_way, one_way.T)


def _fractions(line: np.ndarray) -> np.ndarray:
    """Arc length of each point of a stick, 0 at the top and 1 at the bottom."""
    length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    return length / length[-1]


def _sample(line: np.ndarray) -> np.ndarray:
    """Five points (5, 3), evenly along a stick."""
    at = _fractions(line)
    share = np.linspace(0.0, 1.0, 5)
    return np.stack([np.interp(share, at, column) for column in line.T], axis=1)


def _chain(gaps: np.ndarray) -> list[int]:
    """Order of the sticks along strike: the shortest path through all of them, nearly.

    From every stick, always on to the nearest that is left; the shortest of these
    paths is kept, and stretches of it are reversed while that makes it shorter.
    """
    n_stick = len(gaps)
    path: list[int] = []
    shortest = np.inf
    for start in range(n_stick):
        # nearest neighbours from every start, given up once longer than the best; then 2-opt
        left = np.ones(n_stick, dtype=bool)
        trial, length = [start], 0.0
        left[start] = False
        while left.any() and length < shortest:
            step = np.where(left, gaps[trial[-1]], np.inf)
            trial.append(int(step.argmin()))
            length += step[trial[-1]]
            left[trial[-1]] = False
        if len(trial) == n_stick and length < shortest:
            path, shortest = trial, length
    path = _uncross(path, gaps)
    return path if path[0] < path[-1] else path[::-1]


def _uncross(path: list[int], gaps: np.ndarray) -> list[int]:
    """Reverse stretches of a path while that makes it shorter (2-opt, open ends)."""
    n, gap = len(path), gaps.tolist()  # numbers of lists are looked up in a fifth of the time
    better = True
    while better:
        better = False

        # reversing i to j exchanges the two gaps at its ends; those inside stay
        for i in range(n - 1):
            for j in range(i + 1, n):
                old = new = 0.0
                if i > 0:
                    old, new = gap[path[i - 1]][path[i]], gap[path[i - 1]][path[j]]
                if j < n - 1:
                    old, new = old + gap[path[j]][path[j + 1]], new + gap[path[i]][path[j + 1]]
                if new < old * (1.0 - 1e-12):
                    path[i : j + 1] = path[i : j + 1][::-1]
                    better = True
    return path


def _align(chain: list[np.ndarray]) -> list[np.ndarray]:
    """Turn level sticks so that they run along with their neighbour, from the steepest outwards."""
    rise = [(line[0, 2] - line[-1, 2]) / np.linalg.norm(line[0] - line[-1]) for line in chain]

    # the steepest stick has a clear top: the others follow it, one after the other
    middle = int(np.argmax(rise))
    out = list(chain)
    for i in [*range(middle + 1, len(chain)), *range(middle - 1, -1, -1)]:
        guide = out[i - 1] if i > middle else out[i + 1]
        same = (guide[-1] - guide[0]) @ (out[i][-1] - out[i][0]) >= 0
        if rise[i] < _LEVEL and not same:
            out[i] = out[i][::-1]
    return out


def _strip(a: np.ndarray, b: np.ndarray, vertices: np.ndarray, name: str) -> np.ndarray:
    """Triangles between two neighbouring sticks, given as rows of `vertices`.

    Both are walked from the top; the next step is taken on the stick whose next
    point comes first, as a fraction of its length. On a tie, the shorter
    diagonal. Steps that make no area (shared or collinear points) make no triangle.
    """
    # a zipper: the next point is that of the stick whose next point comes earlier along it, unless
    # that triangle has no area
    at_a, at_b = _fractions(vertices[a]), _fractions(vertices[b])
    faces: list[tuple[int, int, int]] = []
    i = j = 0
    while i < len(a) - 1 or j < len(b) - 1:
        step_a = (int(a[i]), int(a[min(i + 1, len(a) - 1)]), int(b[j]))
        step_b = (int(a[i]), int(b[min(j + 1, len(b) - 1)]), int(b[j]))
        if j == len(b) - 1:
            on_a = True
        elif i == len(a) - 1:
            on_a = False
        else:
            on_a = _first_on_a(at_a[i + 1], at_b[j + 1], step_a, step_b, vertices)
        faces.append(step_a if on_a else step_b)
        i, j = (i + 1, j) if on_a else (i, j + 1)

    # sticks that share a point leave triangles with two equal corners: those are left out
    strip = np.array([f for f in faces if len(set(f)) == 3], dtype=np.int64).reshape(-1, 3)
    _refuse_folds(strip, vertices, name)
    return strip


def _first_on_a(
    next_a: float,
    next_b: float,
    step_a: tuple[int, int, int],
    step_b: tuple[int, int, int],
    vertices: np.ndarray,
) -> bool:
    """Whether the next step is on the first stick."""
    flat = [len(set(s)) == 3 and len(find_zero_area(vertices[[s]])) > 0 for s in (step_a, step_b)]
    if flat[0] != flat[1]:
        return flat[1]
    if abs(next_a - next_b) > 1e-9:
        return bool(next_a < next_b)
    across_a = np.linalg.norm(vertices[step_a[1]] - vertices[step_a[2]])
    across_b = np.linalg.norm(vertices[step_b[1]] - vertices[step_b[0]])
    return bool(across_a <= across_b)


def _refuse_folds(strip: np.ndarray, vertices: np.ndarray, name: str) -> None:
    """Refuse a strip whose triangles turn over from one to the next: its sticks cross."""
    corners = vertices[strip]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    folds = np.flatnonzero((normal[1:] * normal[:-1]).sum(axis=1) < 0)
    if len(folds):
        raise SurfaceError(
            f"fault {name!r}: two neighbouring sticks cross, so the surface folds over at "
            f"{place(corners[folds[0]].mean(axis=0))}. Remove or correct one of them."
        )


# file order is given up if another order is shorter by this factor: at 1.25, points 0 2 1 3 of a
# line are sorted (5 steps against 3), and a pick that slips back by a tenth of the stick is not
_SHORTER = 1.25


def sorted_along(line: np.ndarray) -> np.ndarray:
    """Points (n, 3) of one stick in order along it; in file order if that goes straight enough.

    A stick that only falls, or only climbs, is in order. Of others, three orders are compared: by
    the principal axis, and from each end on to the nearest point that is left, which follows bends.
    """
    climb = np.diff(line[:, 2])
    if len(line) < 3 or (climb >= 0).all() or (climb <= 0).all():
        return line
    middle = line - line.mean(axis=0)
    axis = np.linalg.svd(middle, full_matrices=False)[2][0]
    along = np.argsort(middle @ axis, kind="stable")
    orders = [along, _nearest_next(line, int(along[0])), _nearest_next(line, int(along[-1]))]
    lengths = [_length(line[order]) for order in orders]
    k = int(np.argmin(lengths))
    return line[orders[k]] if _length(line) > _SHORTER * lengths[k] else line


def _nearest_next(line: np.ndarray, start: int) -> np.ndarray:
    """From one point always on to the nearest that is left."""
    left = np.ones(len(line), dtype=bool)
    order = [start]
    for _ in range(len(line) - 1):
        left[order[-1]] = False
        off = np.linalg.norm(line - line[order[-1]], axis=1)
        order.append(int(np.where(left, off, np.inf).argmin()))
    return np.array(order)


def _length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def warn_of_order(moved: list[tuple[int, np.ndarray]], name: str) -> None:
    """Warn of sticks whose points were sorted: (number, line) each."""
    if moved:
        i, line = moved[0]
        warn_of(
            "sticks",
            name,
            f"Fault {name!r}: the points of {counted(len(moved), 'stick')} run back and forth "
            f"and are sorted along the stick; the first is stick {i} at {place(line[0])}.",
            "If a stick really turns back, split it there.",
            line[0],
        )


def without_twins(lines: list[np.ndarray], name: str) -> list[np.ndarray]:
    """Sticks without those that are there already, of which a warning is issued."""
    seen: dict[bytes, int] = {}
    twins = []
    for i, line in enumerate(lines):
        first = seen.setdefault(line.tobytes(), i)
        if first != i:
            twins.append((first, i))
    if twins:
        first, i = twins[0]
        where = f"from {place(lines[i][0])} to {place(lines[i][-1])}"
        warn_of(
            "sticks",
            name,
            f"Fault {name!r}: {counted(len(twins), 'stick')} of {len(lines)} came twice and "
            f"{'are' if len(twins) > 1 else 'is'} used once; sticks {first} and {i} are the "
            f"same, {where}.",
            "Remove the copies from the file.",
            lines[i][0],
        )
    return [lines[i] for i in seen.values()]


def plane_of_stick(line: np.ndarray, strike: Any, length: Any, name: str) -> list[np.ndarray]:
    """A single stick, and its copies half a length along strike to both sides."""
    for word, value in (("strike", strike), ("length", length)):
        if not is_number(value) or (word == "length" and not 0 < value < np.inf):
            raise SurfaceError(
                f"fault {name!r}: {word} is {value!r}. A single stick needs strike, an azimuth in "
                "degrees clockwise from north, and length, in metres: strike=30, length=2000."
            )
    azimuth = np.radians(float(strike))
    half = 0.5 * float(length) * np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    return [line - half, line, line + half]
