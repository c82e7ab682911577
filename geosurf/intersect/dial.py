"""Compute smooth curves to a tolerance, pair by pair; lattices that are not smooth stay plain."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from geosurf.arrangement.checked import check_surfaces
from geosurf.arrangement.search import find_contacts
from geosurf.conventions import frame_origin, is_number
from geosurf.errors import InputError
from geosurf.intersect.exact_route import Judgement, exact_curves
from geosurf.intersect.layers import are_apart
from geosurf.intersect.lift import lift_strand
from geosurf.intersect.link import total_cost
from geosurf.intersect.loops import Found, find_lost, pair_keys
from geosurf.intersect.sides import (
    Candidates,
    Side,
    find_candidates,
    has_cubics,
    piece_of,
    sides_of,
)
from geosurf.intersect.strand import Line, strand_of
from geosurf.intersect.walk import walk_curves
from geosurf.kernels.meshes.polylines import weld_lines
from geosurf.model import CurveIssue, Curves, Touch, TriSurface, frozen
from geosurf.model.expected import listed

Linker = Callable[..., Curves]


def check_tolerance(tolerance: float, self_intersections: bool) -> float:
    """Return the tolerance [m], or raise an error."""
    if not (is_number(tolerance) and tolerance >= 0):
        raise InputError(
            f"tolerance is {tolerance!r}; give a length in metres, or 0 for the lines of "
            "the triangles."
        )
    if tolerance > 0 and self_intersections:
        raise InputError(
            "tolerance and self_intersections cannot be combined. Call intersect_surfaces "
            "once with each option."
        )
    return float(tolerance)


def smooth_curves(
    surfaces: Sequence[TriSurface], tolerance: float, linker: Linker, **options: Any
) -> Curves:
    """Curves of all pairs of surfaces, to a tolerance where their lattices are smooth.

    Parameters
    ----------
    surfaces : sequence of TriSurface
    tolerance : float
        [m], above 0.
    linker : callable
        From contacts to plain curves.
    **options
        For `geosurf.arrangement.find_contacts`.

    Returns
    -------
    Curves
    """
    surfaces = listed(surfaces, "intersect_surfaces takes surfaces", "give a list of TriSurface")
    for i, surface in enumerate(surfaces):
        if not isinstance(surface, TriSurface):
            check_surfaces(surfaces[: i + 1])
        if not has_cubics(surface):
            check_surfaces((surface,))
    if len(surfaces) < 2:
        check_surfaces(surfaces, 2)

    origin = frame_origin(*(surface.extent for surface in surfaces))
    found: list[tuple[tuple[int, int], Line]] = []
    places: list[tuple[tuple[int, int], str, np.ndarray, float]] = []
    touches: list[Touch] = []
    costs: list[dict[str, int]] = []

    # One pair after the other; points are relative to `origin` so that floats keep their digits.
    for i in range(len(surfaces)):
        for j in range(i + 1, len(surfaces)):
            pair = (i, j)
            one, two = surfaces[i], surfaces[j]
            lines, more, plain = _pair(one, two, origin, tolerance, linker, options)
            if isinstance(lines, Curves):
                if len(surfaces) == 2:  # nothing to join: they are the answer
                    return lines
                lines = _lines_of(lines)
            found += [(pair, line) for line in lines]
            places += [(pair, *place) for place in more]
            for curves in plain:
                touches += [Touch(t.kind, pair, t.points, t.area) for t in curves.contacts]
                costs.append(curves.cost)

    names = tuple(surface.name for surface in surfaces)
    return _assemble(names, origin, found, places, touches, total_cost(costs))


def _pair(
    one: TriSurface,
    two: TriSurface,
    origin: np.ndarray,
    tolerance: float,
    linker: Linker,
    options: dict[str, Any],
) -> tuple[list[Line] | Curves, list[tuple[str, np.ndarray, float]], list[Curves]]:
    """Lines (or exact curves with their bound), places and plain curves of two surfaces."""
    # Layers on one map are compared node by node.
    if has_cubics(one) and has_cubics(two) and are_apart(one, two):
        return [], [], []

    # A lattice comes first, so that the result does not depend on the order of arguments.
    names = one.name, two.name
    if _second_first(one, two):
        one, two = two, one

    # A curved lattice below the size for cubics has no error estimate: its bound is infinite.
    coarse = [
        ("coarse lattice", points, np.inf)
        for points in map(_bent, (one, two))
        if points is not None
    ]

    if not has_cubics(one):
        plain = linker(find_contacts((one, two), origin=origin, **options))
        bound = np.inf if coarse else 0.0
        return [_plain_line(plain, k, bound) for k in range(plain.n_curve)], coarse, [plain]

    # Where the exact curve costs less, it comes first. It is the answer, or smooth ones along it.
    judged = None if coarse else Judgement(one, two, tolerance)
    given = one, two, origin, tolerance, linker, options, names
    tried = judged is not None and judged.first
    found = exact_curves(*given, judged) if judged is not None and tried else None
    if found is not None and judged is not None and (found[1] is None or judged.shown):
        exact, followed = found
        return exact if followed is None else followed.lines, [], [exact]

    # Curves that triangles miss can only be in cells that the bounds of the cubics leave over.
    sides = sides_of(one, two, origin)
    near = find_candidates(*sides, 0.0 if coarse or found is not None else tolerance)
    if not len(near.pairs):
        return [], coarse, []
    walked = walk_curves(sides, near, tolerance)
    # Both lattices are smooth wherever they may meet: done without triangles.
    if walked is not None:
        return walked, [], []
    if judged is not None and judged.last and not tried:
        found = exact_curves(*given, judged)
    if found is not None and judged is not None:
        exact, followed = found
        if followed is None:
            return exact, [], [exact]
        beside: tuple[list[Line], list[Found]] = [], []
        if not judged.shown:
            beside = find_lost(sides, near, followed.lines, followed.keys, tolerance)
        return followed.lines + beside[0], beside[1], [exact]

    # Otherwise the exact curve of the remaining triangles is moved onto the cubics.
    lines, keys, plain_curves = _lifted(sides, near, origin, tolerance, linker, options)

    # Loops smaller than a cell that no triangle shows.
    lost, places = find_lost(sides, near, lines, keys, tolerance)
    for line in lines:
        line.bound = np.inf if coarse else line.bound
    return lines + lost, coarse + places, plain_curves


def _lifted(
    sides: tuple[Side, Side],
    near: Candidates,
    origin: np.ndarray,
    tolerance: float,
    linker: Linker,
    options: dict[str, Any],
) -> tuple[list[Line], np.ndarray, list[Curves]]:
    """Exact curves of the cells that are near, moved onto the cubics; keys of cells; and these."""
    none = np.empty(0, dtype=np.int64)
    first, second = (piece_of(side, cells) for side, cells in zip(sides, near.cells, strict=True))
    if first is None or second is None:
        return [], none, []
    contacts = find_contacts((first.surface, second.surface), origin=origin, **options)
    plain = linker(contacts)
    if not plain.n_curve:
        return [], none, [plain]
    strand = strand_of(plain, contacts, (first, second), sides)
    lines, w = lift_strand(strand, sides, tolerance)
    # Cells that known curves run through, before and after lifting; -1 in `hold`: no cell.
    rows = strand.hold >= 0
    both = (pair_keys(sides, of[rows], strand.tri[rows]) for of in (strand.w, w))
    return lines, np.concatenate([*both]), [plain]


def _second_first(one: TriSurface, two: TriSurface) -> bool:
    """Whether to exchange two surfaces: a lattice first, else by name, whatever the order given."""
    if has_cubics(one) != has_cubics(two):
        return has_cubics(two)
    return two.name < one.name


def _bent(surface: TriSurface) -> np.ndarray | None:
    """Nodes of a lattice that is too coarse for cubics and not flat, or None."""
    if surface.lattice is None or has_cubics(surface):
        return None

    lattice = surface.lattice
    if max(lattice.shape) < 3:
        return None  # a single cell
    nodes = np.stack([*lattice.horizontal(), lattice.elevation], axis=-1)

    # Second differences of the nodes [m] vanish on a plane.
    bends = [np.abs(np.diff(nodes, 2, axis=axis)) for axis in (0, 1)]
    largest = max((np.nanmax(b, initial=0.0) for b in bends if b.size), default=0.0)
    return nodes[lattice.present] if largest > 1e-6 else None


def _plain_line(plain: Curves, k: int, bound: float) -> Line:
    """A curve of two surfaces without cubics."""
    points = plain.local[plain.curves[k]]
    return Line(points, bool(plain.closed[k]), bound)


def merge_lines(
    names: tuple[str, ...],
    origin: np.ndarray,
    parts: Sequence[tuple[tuple[int, int], Curves]],
    touches: list[Touch],
    cost: dict[str, int],
) -> Curves:
    """`geosurf.intersect.merge_curves` for curves with a tolerance, with bounds and places."""
    found: list[tuple[tuple[int, int], Line]] = []
    places: list[tuple[tuple[int, int], str, np.ndarray, float]] = []
    for pair, part in parts:
        found += [(pair, line) for line in _lines_of(part, origin)]

        # Places without a curve belong to the pair.
        places += [
            (pair, p.reason, p.points - origin, p.error_bound) for p in part.places if p.curve < 0
        ]
    return _assemble(names, origin, found, places, touches, cost)


def _lines_of(part: Curves, origin: np.ndarray | None = None) -> list[Line]:
    """Curves one by one, in the frame of an origin (default: their own)."""
    here = part.origin if origin is None else origin
    shift, lines = part.origin - here, []
    for k, curve in enumerate(part.curves):
        said = [(p.reason, p.points - here, p.error_bound) for p in part.places if p.curve == k]
        bound = 0.0 if part.error_bound is None else float(part.error_bound[k])
        lines.append(Line(part.local[curve] + shift, bool(part.closed[k]), bound, said))
    return lines


def _stacked(lines: list[Line]) -> np.ndarray:
    """Points of all lines."""
    return np.concatenate([np.empty((0, 3)), *(line.points for line in lines)])


def _assemble(
    names: tuple[str, ...],
    origin: np.ndarray,
    found: list[tuple[tuple[int, int], Line]],
    places: list[Any],
    touches: list[Touch],
    cost: dict[str, int],
) -> Curves:
    """Put lines together to `Curves`; points with equal coordinates become one."""
    # A line of one point is no curve; only its places are reported.
    lines = [line for _, line in found if len(line.points) > 1]
    owners = [pair for pair, line in found if len(line.points) > 1]
    stacked = lines[0].points if len(lines) == 1 else _stacked(lines)
    stops = list(accumulate(len(line.points) for line in lines))
    pairs = np.array(owners, dtype=np.int64).reshape(-1, 2)

    # `stops`: offsets of the lines in `stacked`; `number`: the welded point of each row.
    local, number, segments, owned = weld_lines(stacked, np.array(stops, dtype=np.int64), pairs)
    curves = [number[a:b] for a, b in pairwise([0, *stops])]

    # Places of a pair (curve -1) first, then those of single curves.
    said = [(why, pair, x, size, -1) for pair, why, x, size in places]
    for k, (pair, line) in enumerate(zip(owners, lines, strict=True)):
        said += [(why, pair, x, size, k) for why, x, size in line.places]
    return Curves(
        names=names,
        local=frozen(local, np.float64),
        origin=frozen(origin, np.float64),
        segments=frozen(segments, np.int64),
        surfaces_of_segment=frozen(owned, np.int64),
        curves=tuple(frozen(curve, np.int64) for curve in curves),
        surfaces_of_curve=frozen(pairs, np.int64),
        closed=frozen([curve[0] == curve[-1] for curve in curves], np.bool_),
        contacts=tuple(touches),
        cost=cost,
        error_bound=frozen([line.bound for line in lines], np.float64),
        places=tuple(
            CurveIssue(why, pair, frozen(x + origin, np.float64), size, k)
            for why, pair, x, size, k in said
        ),
    )
