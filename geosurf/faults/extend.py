"""A fault that stops inside the model box -> a fault that leaves it.

Strike comes first, then up and down, so that the new corners are filled. Nothing that was given
moves: the new triangles start at the old rim. The first row of triangles is the same however far a
fault goes; one that is lengthened goes on in whole rows, each as long as all before it, so that
less is a part of more. To a box each line goes on from there only as far as it has to. Where dip
lines converge (the inside of a bend) they cross sooner or later, which exact signs find: then
there is no whole row, and what crosses even so is refused with its place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

from geosurf.arrangement.triangles import crossing_pairs
from geosurf.conventions import is_number, place
from geosurf.errors import GeometryError, InputError, SurfaceError
from geosurf.faults.rim import (
    Axes,
    Guides,
    Rim,
    directions,
    exits,
    find_rim,
    guides_of,
    normals_of,
    rim_in_box,
    segments_meet_box,
    total,
)
from geosurf.faults.rules import ALL_SIDES, read_names, read_sides
from geosurf.kernels.exact.predicates import flat_triangles, frame_of
from geosurf.model import TriSurface
from geosurf.model.expected import box_of_sides, expect
from geosurf.model.network import SIDES, ExtendedFault, Extension
from geosurf.model.surfaces import cutoffs_kept

# ---- notches ----------------------------------------
# Strips of triangles along a rim: notches filled, lengths smoothed, lines joined.


LEADS = 0.05  # of a side: steps at its ends that lead on by less are left to its neighbours


def without_notches(
    x: np.ndarray, arc: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """An arc with filled notches, as seen along its mean direction, the triangles in them, and the
    part of it that leads on.

    The upper hull of the arc (Andrew 1979): of three vertices in turn the middle one is left
    behind if it lies short of the line that joins the others. No vertex is new. Whether the
    triangles may stay is decided later, exactly.
    """
    ahead = total(direction)
    ahead /= max(float(np.linalg.norm(ahead)), np.finfo(float).tiny)

    # the arc in a plane: how far along the side, and how far ahead
    along = x[arc[-1]] - x[arc[0]]
    along = along - (along @ ahead) * ahead
    plane = x[arc] @ np.stack([along, ahead], axis=1)
    reach = float(along @ along)

    # three in turn: the middle one goes, and leaves a triangle, where it lies behind
    chain: list[int] = []
    filled = []
    for c in range(len(arc)):
        while len(chain) > 1:
            a, b = chain[-2:]
            (s, h), (u, v) = plane[b] - plane[a], plane[c] - plane[a]
            if s * v - h * u <= 1e-9 * (abs(s * v) + abs(h * u)):  # on the line: no notch
                break
            filled.append((arc[a], arc[c], arc[chain.pop()]))
        chain.append(c)
    # steps at the ends that do not lead on belong to the sides next to this one
    whole = arc[chain]
    while len(chain) > 1 and plane[chain[1], 0] <= plane[chain[0], 0] + LEADS * reach:
        chain.pop(0)
    while len(chain) > 1 and plane[chain[-1], 0] <= plane[chain[-2], 0] + LEADS * reach:
        chain.pop()
    return whole, np.array(filled, dtype=np.int64).reshape(-1, 3), arc[chain]


def filled_lengths(length: np.ndarray) -> np.ndarray:
    """Lengths with those that are not known taken from the nearest two, the longer one."""
    # ranks of the nearest known lengths to the left and right of each row, clipped at the ends
    known = np.flatnonzero(np.isfinite(length))
    rows = np.arange(len(length))
    right = np.minimum(np.searchsorted(known, rows), len(known) - 1)
    left = np.maximum(np.searchsorted(known, rows, side="right") - 1, 0)
    both = np.maximum(length[known[left]], length[known[right]])
    return np.where(np.isfinite(length), length, both)


def strip(arc: np.ndarray, n: int, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Two triangles for each step of an arc, facing as the triangles behind it do.

    The vertices beyond it are `far`, n, n + 1, ... in the order of the arc.
    """
    a, b = arc[:-1], arc[1:]
    c, d = n + np.arange(len(arc) - 1), n + np.arange(1, len(arc))
    from_a = _from_first(near, far)
    first = np.where(from_a, np.stack([b, a, d], 1), np.stack([b, a, c], 1))
    second = np.where(from_a, np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return np.stack([first, second], axis=1).reshape(-1, 3)


def _from_first(near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Whether the diagonal of each step of a strip starts at its first vertex, bool (n, 1).

    The shorter diagonal; where both are as long, the one from the lesser corner of the rim.
    """
    # squares of both diagonals; ties are decided by coordinates, not by numbering
    first = ((near[:-1] - far[1:]) ** 2).sum(axis=1)
    second = ((near[1:] - far[:-1]) ** 2).sum(axis=1)
    lesser = np.array([tuple(p) < tuple(q) for p, q in pairwise(near)])
    return ((first < second) | ((first == second) & lesser))[:, None]


def _part_of_strip(
    arc: np.ndarray, n: int, near: np.ndarray, far: np.ndarray, tip: np.ndarray, share: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A strip of which the rest is cut off: vertices (k, 3) beyond the arc, numbers of those that
    its lines lead to, and triangles. `share` of each line stays, up to its `tip`.
    """
    if share == 1.0:
        return tip, n + np.arange(len(arc)), strip(arc, n, near, far)

    # where the cut crosses the diagonal of each step there is a vertex, too
    from_a = _from_first(near, far)
    start, end = np.where(from_a, near[:-1], near[1:]), np.where(from_a, far[1:], far[:-1])
    points = np.empty((2 * len(arc) - 1, 3))
    points[::2], points[1::2] = tip, start + share * (end - start)
    a, b, ends = arc[:-1], arc[1:], n + 2 * np.arange(len(arc))
    c, e, d = ends[:-1], ends[:-1] + 1, ends[1:]
    one = np.stack([b, a, e, b, e, d, a, c, e], 1)
    two = np.stack([b, a, c, b, c, e, b, e, d], 1)
    return points, ends, np.where(from_a, one, two).reshape(-1, 3)


# starts and ways of lines, and how long they are: how far they still have to go (n,) [m]
Reach = Callable[[np.ndarray, np.ndarray, float], np.ndarray]
_MARGIN = 0.003  # of the diagonal of the box: how far beyond it an extension ends
_LINES = "own", "averaged", "filled"  # how lines may go on: the first that has no defect
_PARALLEL = 1e-9  # by which unit vectors of lines differ that are taken to be parallel
_ROW = 0.5  # of the smaller side of a fault: the length of the first row
_DONE = 1.0 - 1e-9  # of a distance: what is missing is its rounding
_ROWS = 32  # each as long as all before: more do not leave a box that so many are in


def extend_fault(
    surface: TriSurface,
    box: Sequence[float],
    *,
    sides: Any = ALL_SIDES,
    until: str = "the model box",
) -> ExtendedFault:
    """Continue a fault along strike and dip until it leaves the model box.

    Dip and strike lines go on by their last step: those of a grid, dip lines of sticks,
    and lines of steepest dip and of strike in the tangent plane at the rim of other meshes.
    On other meshes, and where sticks that are not quite parallel would cross, directions are
    averaged along the rim, as far as the lines go on; those along strike over the whole end, so
    that they are parallel. What a fault is within the first row of triangles, half of its smaller
    side, does not depend on the box. Sides that lie outside the box already are left alone.

    Parameters
    ----------
    surface : TriSurface
        One connected piece.
    box : (west, east, south, north, bottom, top)
        World coordinates [m], elevation positive up.
    sides : str or sequence of str
        Any of ``"strike"`` (both ends), ``"start"``, ``"end"``, ``"up"``, ``"down"``.
    until : str
        What the box stands for, for the list of extensions.

    Returns
    -------
    ExtendedFault
        The vertices and triangles as given, bit for bit, then the new ones, which face
        as their neighbours do. The list of extensions has their distances; they end 0.3 %
        of the diagonal of the box beyond it.

    Raises
    ------
    InputError
        For an unknown side, or a box that is not six numbers in order.
    SurfaceError
        If the fault is in several pieces, or its rim is not one line.
    GeometryError
        If the continuation would cross itself or the fault, or never leaves the box; the message
        has the place.

    Examples
    --------
    A fault that dips 45 degrees east, 100 m wide, in a box of 1 km:

    >>> corners = [[0, 0, 0], [0, 100, 0], [100, 100, -100], [100, 0, -100]]
    >>> fault = TriSurface("F1", "fault", corners, [[0, 2, 1], [0, 3, 2]])
    >>> longer = extend_fault(fault, (-500, 500, -500, 500, -500, 500), sides=("up", "down"))
    >>> [(e.side, round(e.distance)) for e in longer.extensions]
    [('up', 714), ('down', 573)]
    >>> longer.n_given, longer.surface.n_triangle
    (2, 6)
    """
    expect(surface, TriSurface, "extend_fault takes a TriSurface", "triangulate_fault makes one")
    wanted = read_sides(sides, f"extend_fault of {surface.name!r}")
    limits = box_of_sides(box)
    low, high = limits[::2], limits[1::2]

    def reach_of(side: str) -> Reach:
        """How far the lines of a side are from the box."""
        return partial(_reach_of_box, low, high, surface.name, side, until)

    return _in_turn(surface, wanted, until, reach_of, (low, high))


def extend_to(
    surface: TriSurface, main: TriSurface, side: str, longest: float = np.inf
) -> ExtendedFault:
    """Continue one side of a fault until it is past the bounds of another, or has a given length.

    Raises
    ------
    GeometryError
        If no line of that side leads there, or the continuation would cross itself.
    """
    # the bounds of the main fault are the box to leave
    low, high = np.reshape(main.bounds, (3, 2)).T
    rim, guides = find_rim(surface), guides_of(surface)

    def reach(start: np.ndarray, way: np.ndarray, gone: float) -> np.ndarray:
        out = _reach_of_box(low, high, surface.name, side, main.name, start, way, gone)
        return np.minimum(out, longest - gone)

    longer, _, _, extension = continue_side(
        surface, rim, guides, side, reach, main.name, first_row(surface)
    )
    return ExtendedFault(longer, surface.n_triangle, (extension,))


def _in_turn(
    surface: TriSurface,
    wanted: Iterable[str],
    until: str,
    reach_of: Callable[[str], Reach],
    box: tuple[np.ndarray, np.ndarray] | None = None,
) -> ExtendedFault:
    """All sides in turn, each from what the others have made; of a box those that are inside it.

    A side that is but a point (of a triangular fault) waits until its neighbours make it a line.
    """
    longer, guides, extensions = surface, guides_of(surface), []
    first, rim = first_row(surface), find_rim(surface)
    waiting = list(wanted)
    while waiting:
        side = next((s for s in waiting if len(rim.arcs[s]) > 1), waiting[0])
        waiting.remove(side)

        # a side outside the box already needs no extension
        if box is None or rim_in_box(rim, longer.vertices, side, *box):
            reach = reach_of(side)
            longer, rim, guides, extension = continue_side(
                longer, rim, guides, side, reach, until, first, _ROWS if box is None else 1
            )
            extensions.append(extension)
    return ExtendedFault(longer, surface.n_triangle, tuple(extensions))


def first_row(surface: TriSurface) -> float:
    """Length of the first row of triangles beyond a fault [m]: its lines are known best there."""
    x, arcs = surface.vertices, find_rim(surface).arcs
    width, height = (
        max(float(np.linalg.norm(np.diff(x[arcs[one]], axis=0), axis=1).sum()) for one in both)
        for both in (("up", "down"), ("start", "end"))
    )
    return _ROW * (min(width, height) or max(width, height))


def continue_side(
    surface: TriSurface,
    rim: Rim,
    guides: Guides,
    side: str,
    reach: Reach,
    until: str,
    first: float,
    n_whole: int = _ROWS,
) -> tuple[TriSurface, Rim, Guides, Extension]:
    """Return (surface, rim, guides, extension) with one more side, row by row, the first so long.

    `reach` says how far lines still have to go (n,), from where they are, which way they go, and
    how long they are already; in the first rows (`n_whole`) all go as far as the longest, then, and
    where lines that converge would cross before that, each as far as it has to.
    """
    corner = surface.vertices[rim.arcs[side][0]]
    if len(rim.arcs[side]) < 2:
        raise GeometryError(
            f"fault {surface.name!r} cannot be extended to {until}: its side {side!r} is a single "
            f"point, {place(corner)}. Choose another side.",
            place=corner,
            surfaces=(surface.name,),
        )
    rows = partial(_in_rows, surface, rim, guides, side, reach, until, first)
    try:
        return rows(n_whole)
    except (GeometryError, SurfaceError) as refused:
        try:
            return rows(0)
        except (GeometryError, SurfaceError):
            raise refused from None


def _in_rows(
    surface: TriSurface,
    rim: Rim,
    guides: Guides,
    side: str,
    reach: Reach,
    until: str,
    first: float,
    n_whole: int,
) -> tuple[TriSurface, Rim, Guides, Extension]:
    """A side that goes on row by row; after some whole ones each line as far as it has to."""
    n_given = surface.n_triangle
    length, least, most, words = first, 0.0, 0.0, []
    for k in range(_ROWS):
        apart = k >= n_whole
        row = _row(surface, rim.axes, rim.arcs[side], guides, side, reach, length, most, apart)
        if row is None:
            break
        n = surface.n_vertex
        surface, guides, edge, arc, (short, long), lines, is_last = row
        rim = rim.grown(side, edge, arc, np.arange(n, surface.n_vertex))
        least, most, length = least + short, most + long, most + long
        words.append(lines)
        if is_last:
            break
    else:
        raise GeometryError(
            f"fault {surface.name!r} does not leave {until} on its side {side!r}: its lines part, "
            f"the last at {place(surface.vertices[-1])}, so that the box stays between them. "
            "Smooth the fault there.",
            place=surface.vertices[-1],
            surfaces=(surface.name,),
        )
    faces = surface.triangles[n_given:]
    added = math.fsum(0.5 * np.linalg.norm(normals_of(surface.vertices[faces]), axis=1))
    lines = max(words, key=_LINES.index)
    made = Extension(surface.name, side, most, least, added, len(faces), until, lines)
    return surface, rim, guides, made


def _row(
    surface: TriSurface,
    axes: Axes,
    arc: np.ndarray,
    guides: Guides,
    side: str,
    reach: Reach,
    length: float,
    gone: float,
    apart: bool,
) -> tuple[TriSurface, Guides, np.ndarray, np.ndarray, tuple[float, float], str, bool] | None:
    """One row of triangles beyond a side: the surface, its guides, the side with its notches filled
    and the part of it that goes on, the least and largest length of its lines, how these go on, and
    whether far enough.

    None if they are so already. `apart`: each line as far as it has to.

    Lines of a grid go on as they are. Those of sticks, too, unless they would cross; then, and
    where a fault has none, directions are averaged along the rim, as far as the lines go on.
    Where these would cross because the rim has steps, its notches are filled first.
    """
    name, x, t, given = surface.name, surface.vertices, surface.triangles, arc
    lost = np.flatnonzero(~directions(x, t, arc, side, axes, guides).any(axis=1))
    if len(lost):
        raise GeometryError(
            f"fault {name!r} has no tangent plane at {place(x[arc[lost[0]]])}: the triangles "
            f"there are slivers or folded over. Smooth its side {side!r}, or leave it out.",
            place=x[arc[lost[0]]],
            surfaces=(name,),
        )
    # whether every vertex of the side has a guide, so that lines may go on as they are
    has_guides = bool((guides.of(side)[arc] >= 0).all())
    ways = _LINES[:1] if has_guides and guides.exact else _LINES
    defect = None
    # directions are averaged as far along the rim as lines go on; along strike over all of the end
    window = np.inf if side in ("start", "end") else gone + length
    # whole rows first, in each way: how lines go on does not depend on how much of a row is needed
    for is_whole, lines in product((True,) if apart else (True, False), ways):
        edge, filled, arc = given, np.empty((0, 3), dtype=np.int64), given
        if lines == "filled":
            ahead = directions(x, t, arc, side, axes, guides, window)
            edge, filled, arc = without_notches(x, arc, ahead)
            if len(arc) < 2 or len(arc) == len(given):
                continue
        direction = directions(x, t, arc, side, axes, guides, 0.0 if lines == "own" else window)
        missing = reach(x[arc], direction, gone)
        if missing.max() <= 0.0 and arc is given:
            return None
        if apart:
            window = max(window, float(np.median(missing)))
        # tangents of a mesh are as noisy as its triangles: they are averaged before they count
        if not has_guides and lines == "own":
            continue

        # a row of parallel lines is flat, however long each of them is
        is_own = apart or (gone == 0.0 and bool(np.ptp(direction, axis=0).max() <= _PARALLEL))
        for _ in range(_ROWS if is_own else 0):
            if _is_enough(reach, x[arc], direction, missing, gone):
                break
            missing = 1.5 * missing  # the new rim crosses an edge of the box between two lines
        longest = float(missing.max())
        far = missing if is_own else np.full(len(arc), longest)
        is_last = is_own or 0.0 < longest < length
        is_last = is_last and _is_enough(reach, x[arc], direction, far, gone)
        needed = longest / length if is_last and not is_own else 1.0
        tip = x[arc] + (missing[:, None] if is_own else length) * direction
        for share in dict.fromkeys((1.0, needed) if is_whole else (needed,)):
            # by its own length: lines of two faults with one stick end at the same places
            end = tip if share == 1.0 else x[arc] + longest * direction
            beyond, ends, new = _part_of_strip(arc, len(x), x[arc], tip, end, share)
            points, faces = np.concatenate([x, beyond]), np.concatenate([t, filled, new])
            defect = _defect_of(name, side, points, faces, len(filled) + len(new))
            if defect is not None:
                break
        if defect is None:
            longer = TriSurface(
                name, surface.role, points, faces, vertex_data=cutoffs_kept(surface, points)
            )
            gone_on = (float(missing.min()), longest) if is_own else (needed * length,) * 2
            return longer, guides.grown(side, arc, ends), edge, arc, gone_on, lines, is_last
    assert defect is not None
    raise defect


def _is_enough(
    reach: Reach, start: np.ndarray, direction: np.ndarray, far: np.ndarray, gone: float
) -> bool:
    """Whether lines need no more once they have gone on by some lengths (n,)."""
    missing = reach(start + far[:, None] * direction, direction, gone + float(far.max()))
    return not (missing > 0.0).any()


def _reach_of_box(
    low: np.ndarray,
    high: np.ndarray,
    name: str,
    side: str,
    until: str,
    start: np.ndarray,
    direction: np.ndarray,
    gone: float,
) -> np.ndarray:
    """How far lines still have to go until the rim is outside a box: see `Reach`."""
    if gone and not segments_meet_box(start, low, high).any():
        return np.zeros(len(start))
    return _lengths(start, direction, low, high, name, side, until)


def _lengths(
    start: np.ndarray,
    direction: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    name: str,
    side: str,
    until: str,
) -> np.ndarray:
    """How far each line goes on (n,) until it is outside the box."""
    # beyond the box by a margin, so that the rim does not graze a wall
    margin = _MARGIN * float(np.linalg.norm(high - low))

    # NaN for lines that never leave towards this side; `filled_lengths` gives them a neighbour's
    length = exits(start, direction, low - margin, high + margin)
    if not np.isfinite(length).any():  # all pass the box, which lies between them: to its far end
        corners = np.stack(np.meshgrid(*np.stack([low, high]).T), axis=-1).reshape(-1, 3)
        far = ((corners[None] - start[:, None]) * direction[:, None]).sum(axis=2).max(axis=1)
        length = np.where(far > 0, far + margin, np.nan)
    if not np.isfinite(length).any():
        raise GeometryError(
            f"fault {name!r} cannot be extended to {until} from its side {side!r}: none of its "
            f"lines leads there, for one from {place(start[0])}. Choose another side.",
            place=start[0],
            surfaces=(name,),
        )
    return filled_lengths(length)


def _defect_of(name: str, side: str, x: np.ndarray, t: np.ndarray, n_new: int) -> Exception | None:
    """What is wrong with new triangles, exactly: without area, or crossing others; or None."""
    # exact signs decide: neither a flat triangle nor a crossing is ever let through
    new, old = t[-n_new:], t[:-n_new]
    m, w = frame_of(x)
    flat = flat_triangles(x, new, m, w)
    if len(flat):
        return SurfaceError(
            f"fault {name!r}: its rim runs along the direction in which side {side!r} goes on, at "
            f"{place(x[new[flat[0], 0]])}. Smooth the outline there, or leave this side out."
        )
    pairs = crossing_pairs(x, new, old)
    if len(pairs) == 0:
        return None
    where = x[np.concatenate([new, old])[pairs[0, 0]]].mean(axis=0)
    return GeometryError(
        f"fault {name!r} would cross itself if its side {side!r} were extended: {len(pairs)} "
        f"pairs of triangles cross, one near {place(where)}. Extend it less (a smaller box), leave "
        "this side out, or smooth the bend.",
        place=where,
        surfaces=(name,),
    )


# ---- lengthen ----------------------------------------
# A fault that was picked too short -> one that is longer by a given distance, without a box.


UNTIL = "the given distance"
LONGEST = 1e7  # [m], a quarter of the equator: more is a slip
_HOW = "Give a distance in metres above 0 for all sides, or for some, as {'up': 50, 'strike': 200}."


def lengthen_fault(surface: TriSurface, distance: Any) -> ExtendedFault:
    """Continue a fault along strike and dip by a distance.

    Sticks, and the dip and strike lines of grids, go on by their last step; other meshes go on in
    the tangent plane at the rim. See `extend_fault`, which continues a fault to the model box.

    Parameters
    ----------
    surface : TriSurface
        One connected piece; `triangulate_fault` makes one of sticks.
    distance : float, or mapping of str to float
        [m], along the new lines: for all sides, or for some of ``"strike"`` (both ends),
        ``"start"``, ``"end"``, ``"up"``, ``"down"``.

    Returns
    -------
    ExtendedFault
        Strike comes first, then up and down, so that the new corners are filled. Vertices and
        triangles as given come first, bit for bit.

    Raises
    ------
    InputError
        For an unknown side, or a distance that is not a length.
    SurfaceError
        If the fault is in several pieces, or its rim is not one line.
    GeometryError
        If the continuation would cross itself or the fault; the message has the place.

    Examples
    --------
    Two sticks that end 20 m above a horizon at -1620 m:

    >>> from geosurf import FaultSticks, triangulate_fault
    >>> sticks = [[[0, 0, -1500], [60, 0, -1600]], [[0, 200, -1500], [60, 200, -1600]]]
    >>> fault = triangulate_fault(FaultSticks("F1", sticks))
    >>> longer = lengthen_fault(fault, {"down": 50}).surface
    >>> longer.n_vertex, round(longer.bounds[4], 1)
    (6, -1642.9)
    """
    how = "triangulate_fault makes one"
    expect(surface, TriSurface, "lengthen_fault takes a TriSurface", how)
    distances = read_distances(distance, f"lengthen_fault of {surface.name!r}")

    def reach_of(side: str) -> Reach:
        """The distance of a side, for each of its lines."""
        return lambda start, way, gone: np.full(
            len(start), 0.0 if gone > _DONE * distances[side] else distances[side] - gone
        )

    return _in_turn(surface, distances, UNTIL, reach_of)


def read_distances(distance: Any, what: str) -> dict[str, float]:
    """Return the distance [m] of each side that is to be continued, in the order of work.

    Examples
    --------
    >>> read_distances({"down": 50, "strike": 200}, "lengthen of 'F1'")
    {'start': 200.0, 'end': 200.0, 'down': 50.0}
    """
    # one number for all sides, or a mapping that may say "strike" for both ends
    given = distance if isinstance(distance, Mapping) else dict.fromkeys(SIDES, distance)
    if not given:
        raise InputError(f"{what} is {distance!r}. {_HOW}")
    lengths: dict[str, float] = {}
    for word, length in given.items():
        if not (is_number(length) and 0 < length < LONGEST):
            raise InputError(f"{what} is {distance!r}. {_HOW}")
        for side in read_sides((word,), what):
            if side in lengths:
                raise InputError(
                    f"{what} gives side {side!r} twice. Leave out 'strike' or the end."
                )
            lengths[side] = float(length)
    return {side: lengths[side] for side in SIDES if side in lengths}


def read_lengthen(lengthen: Any, faults: Any) -> dict[str, dict[str, float]]:
    """Check which faults are to be lengthened, on which sides, by which distances.

    Parameters
    ----------
    lengthen : float, or mapping of str to distance
        One distance for all faults [m], or for some by name, each as for `lengthen_fault`.
    faults : sequence of str
        Names that exist.

    Returns
    -------
    dict of str to dict of str to float
        In the order of `faults`.

    Raises
    ------
    InputError
        For an unknown name or side, or a distance that is not a length.

    Examples
    --------
    >>> read_lengthen({"F1": {"up": 50}}, ["F1", "F2"])
    {'F1': {'up': 50.0}}
    """
    if lengthen is None:
        return {}
    given = lengthen if isinstance(lengthen, Mapping) else dict.fromkeys(faults, lengthen)
    if not isinstance(lengthen, Mapping):
        read_distances(lengthen, "lengthen")
    read_names(given, "lengthen", faults)
    return {
        name: read_distances(given[name], f"lengthen of {name!r}")
        for name in faults
        if name in given
    }
