"""A fault that stops inside the model box -> a fault that leaves it.

Strike comes first, then up and down, so that the new corners are filled. Nothing that was given
moves: the new triangles start at the old rim. Where dip lines converge (the inside of a
bend) they cross sooner or later; that is found by exact signs, and refused with its place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from geosurf.arrangement.crossing import crossing_pairs
from geosurf.conventions import place
from geosurf.errors import GeometryError, SurfaceError
from geosurf.faults.box_exits import exits, rim_in_box, segments_meet_box
from geosurf.faults.lines import Guides, directions, guides_of
from geosurf.faults.notches import filled_lengths, strip, without_notches
from geosurf.faults.rim import Rim, find_rim, normals_of
from geosurf.faults.rules import ALL_SIDES, read_sides
from geosurf.kernels.exact.predicates import flat_triangles, frame_of
from geosurf.model import TriSurface
from geosurf.model.expected import box_of_sides, expect
from geosurf.model.faults import ExtendedFault, Extension

_MARGIN = 0.01  # of the diagonal of the box: how far beyond it an extension ends
_TRIALS = 12  # each half as long again, where a new rim cuts across an edge of the box


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
    averaged along the rim, as far as the lines go on. Sides that lie outside the box already are
    left alone.

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
        as their neighbours do. The list of extensions has their distances; they end a hundredth
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
    [('up', 732), ('down', 590)]
    >>> longer.n_given, longer.surface.n_triangle
    (2, 6)
    """
    expect(surface, TriSurface, "extend_fault takes a TriSurface", "triangulate_fault makes one")
    wanted = read_sides(sides, f"extend_fault of {surface.name!r}")
    limits = box_of_sides(box)
    return _extended(surface, limits[::2], limits[1::2], wanted, until)


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

    def reach(start: np.ndarray, way: np.ndarray) -> np.ndarray:
        out = _lengths(start, way, low, high, surface.name, side, main.name)
        return np.minimum(out, longest)

    longer, _, extension = continue_side(surface, rim, guides, side, reach, main.name)
    return ExtendedFault(longer, surface.n_triangle, (extension,))


def _extended(
    surface: TriSurface, low: np.ndarray, high: np.ndarray, wanted: Sequence[str], until: str
) -> ExtendedFault:
    """All sides in turn, each from what the others have made.

    A side that is but a point (of a triangular fault) waits until its neighbours make it a line.
    """
    longer, guides, found = surface, guides_of(surface), []
    axes = find_rim(surface).axes  # as it was given: a long extension could turn the mean
    waiting = list(wanted)
    while waiting:
        rim = find_rim(longer, axes)
        side = next((s for s in waiting if len(rim.arcs[s]) > 1), waiting[0])
        waiting.remove(side)

        # a side outside the box already needs no extension
        if rim_in_box(rim, longer.vertices, side, low, high):

            def reach(start: np.ndarray, way: np.ndarray, side: str = side) -> np.ndarray:
                return _lengths(start, way, low, high, surface.name, side, until)

            longer, guides, extension = continue_side(longer, rim, guides, side, reach, until)
            found.append(extension)
    return ExtendedFault(longer, surface.n_triangle, tuple(found))


def continue_side(
    surface: TriSurface,
    rim: Rim,
    guides: Guides,
    side: str,
    reach: Callable[[np.ndarray, np.ndarray], np.ndarray],
    until: str,
) -> tuple[TriSurface, Guides, Extension]:
    """Return (surface, guides, extension) with one more side.

    `reach` has the length (n,) of each new line, from where it starts and which way it goes.

    Lines of a grid go on as they are. Those of sticks, too, unless they would cross; then, and
    where a fault has none, directions are averaged along the rim, as far as the lines go on.
    Where these would cross because the rim has steps, its notches are filled first.
    """
    name, x, t, arc = surface.name, surface.vertices, surface.triangles, rim.arcs[side]
    if len(arc) < 2:
        raise GeometryError(
            f"fault {name!r} cannot be extended to {until}: its side {side!r} is a single point, "
            f"{place(x[arc[0]])}. Choose another side.",
            place=x[arc[0]],
            surfaces=(name,),
        )

    # each way in turn, until a surface has no defect; lines of a grid are meant, and only go on
    # whether every vertex of the side has a guide, so that lines may go on as they are
    own = bool((guides.of(side)[arc] >= 0).all())
    window, defect, filled = 0.0, None, np.empty((0, 3), dtype=np.int64)
    whole, way = arc, np.zeros((len(arc), 3))
    for lines in ("own",) if own and guides.exact else ("own", "averaged", "filled"):
        if lines == "filled":
            arc, filled = without_notches(x, whole, way)
            if len(arc) < 2 or len(arc) == len(whole):
                break
        way = directions(x, t, arc, side, rim.axes, guides, window)
        lost = np.flatnonzero(~way.any(axis=1))
        if len(lost):
            raise GeometryError(
                f"fault {name!r} has no tangent plane at {place(x[arc[lost[0]]])}: the triangles "
                f"there are slivers or folded over. Smooth its side {side!r}, or leave it out.",
                place=x[arc[lost[0]]],
                surfaces=(name,),
            )

        # the strip between the rim and the ends of its lines, and what it does to the fault
        length = reach(x[arc], way)
        tip = x[arc] + length[:, None] * way
        new = np.concatenate([filled, strip(arc, len(x), x[arc], tip)])
        points, faces = np.concatenate([x, tip]), np.concatenate([t, new])

        # the next attempt averages as far along the rim as lines are long
        window = float(np.median(length))

        # tangents of a mesh are as noisy as its triangles: they are averaged before they count
        if own or lines != "own":
            defect = _defect_of(name, side, points, faces, len(new))
            if defect is None:
                break
    if defect is not None:
        raise defect

    area = math.fsum(0.5 * np.linalg.norm(normals_of(points[new]), axis=1))
    sizes = float(length.max()), float(length.min()), area
    made = Extension(name, side, *sizes, len(new), until, lines)
    return TriSurface(name, surface.role, points, faces), guides.grown(side, arc), made


def _lengths(
    start: np.ndarray,
    way: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    name: str,
    side: str,
    until: str,
) -> np.ndarray:
    """How far each line goes on (n,), so that the new rim lies outside the box."""
    # beyond the box by a margin, so that the rim does not graze a wall
    margin = _MARGIN * float(np.linalg.norm(high - low))

    # NaN for lines that never leave towards this side; `filled_lengths` gives them a neighbour's
    length = exits(start, way, low - margin, high + margin)
    if not np.isfinite(length).any():  # all pass the box, which lies between them: to its far end
        corners = np.stack(np.meshgrid(*np.stack([low, high]).T), axis=-1).reshape(-1, 3)
        far = ((corners[None] - start[:, None]) * way[:, None]).sum(axis=2).max(axis=1)
        length = np.where(far > 0, far + margin, np.nan)
    if not np.isfinite(length).any():
        raise GeometryError(
            f"fault {name!r} cannot be extended to {until} from its side {side!r}: none of its "
            f"lines leads there, for one from {place(start[0])}. Choose another side.",
            place=start[0],
            surfaces=(name,),
        )
    length = filled_lengths(length)

    # a new rim with both ends outside may still cut across an edge of the box: make its two lines
    # longer until none does
    for _ in range(_TRIALS):
        meets = segments_meet_box(start + length[:, None] * way, low, high)
        if not meets.any():
            return length
        longer = np.r_[meets, False] | np.r_[False, meets]
        length = np.where(longer, 1.5 * length + margin, length)
    i = int(np.flatnonzero(meets)[0])
    raise GeometryError(
        f"fault {name!r} does not leave {until} on its side {side!r}: neighbouring lines part at "
        f"{place(start[i])} so that the box stays between them. Smooth the fault there.",
        place=start[i],
        surfaces=(name,),
    )


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
