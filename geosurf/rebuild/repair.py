"""Repair triangles that rounding breaks: move input vertices to a coarser grid, and report it.

Points are constructed exactly and rounded once. Surfaces that are degenerate up to rounding, but
not exactly (a fault through horizon nodes whose coordinates are rounded thirds), leave slivers
thinner than that rounding, and children turn over. Rounding the *output* again can go on
for ever. Rounding the *input* cannot: vertices of the faces concerned move to multiples of a
step far coarser than float64, the exact arrangement is computed again, and what was nearly
degenerate is now either exactly so or thick enough; slivers whose corners come together are shut.
Steps grow until it holds. Inputs on round numbers lie on all steps and do not move; if nothing else
helped, each vertex moves by up to a step more, as its own coordinates show, in several ways one
after the other. The largest move is reported, and if that does not help, the call fails by name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from geosurf.arrangement.arrange import Children, cut_contacts
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.arrangement.threads import map_threads, n_threads
from geosurf.arrangement.tree_pairs import ULP
from geosurf.arrangement.triangles import crossing_pairs
from geosurf.conventions import place
from geosurf.errors import GeosurfError, RoundingError, SurfaceError
from geosurf.kernels.contacts.triangle_contact import on_boundaries, unstable_pairs
from geosurf.kernels.cutting.cut_faces import thin_children
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import inverted_triangles, weld
from geosurf.kernels.search.tree import triangle_boxes
from geosurf.model import Lattice, Patches, TriSurface
from geosurf.model.base import in_crs_of
from geosurf.model.pieces import Pieces
from geosurf.model.surfaces import torn_sheet
from geosurf.model.torn_lattice import TornLattice
from geosurf.rebuild.assemble import assemble, first_of_equals

STEPS = tuple(2.0**-k for k in (28, 24, 20, 16, 13))  # metres; also the largest moves along an axis
SHIFT = 2.0**-15  # metres; with rounding to it, at most half of what the last step moves
_MANY = 20_000  # children; from then on they are checked in another thread
Result = TypeVar("Result")
DRAWS = 5  # of shifts, one after the other


def unsound(contacts: Contacts, children: Children, moved: Sequence[np.ndarray] = ()) -> np.ndarray:
    """Faces whose children turn over or cross another triangle once rounded (exact tests).

    `moved` has vertices of each surface: children of their faces are suspects, however thick.
    """
    if len(children.cut) == 0:
        return np.empty(0, dtype=np.int64)

    # Children that are thin enough for rounding to turn them over.
    rows = children.doubtful
    if len(rows):
        m, w = frame_of(children.x)
        t, parent = children.triangles[rows], children.parent[rows]
        bad = inverted_triangles(children.x, t, contacts.t, parent, m, w)
        if len(bad):
            return parent[bad]
    return crossing_faces(contacts, children, moved)


def cut_soundly(
    contacts: Contacts, then: Callable[[Contacts, Children], Result]
) -> tuple[Contacts, Children, dict[str, float], Result]:
    """Cut all faces; repair the inputs where rounding turns children over.

    Parameters
    ----------
    contacts : Contacts
    then : callable
        What is made of contacts and children. It begins while they are checked, and what it makes
        of some that are not sound is dropped.

    Returns
    -------
    contacts, children
        Of the surfaces as used: ``contacts.surfaces`` has the moved vertices.
    report : dict
        ``moved_vertices`` and ``largest_move`` [m], both 0 where nothing was broken.
    made
        What `then` has made of them.

    Raises
    ------
    RoundingError
        If neither the coarsest step nor a shift helps: names the surface and the place.
    """
    contacts = with_own_contacts(contacts)
    children = cut_contacts(contacts)
    bad, made = _checked(contacts, children, then)
    if len(bad) == 0:
        return contacts, children, {"moved_vertices": 0, "largest_move": 0.0}, made()

    # The steps get coarser; each one begins with the given surfaces, not with those that were
    # moved.
    given = contacts.surfaces
    moved = [np.empty(0, dtype=np.int64) for _ in given]
    first, held = (contacts, bad), _held(given)

    tries: list[tuple[Callable[..., np.ndarray], float]] = [(rounded, step) for step in STEPS]
    tries += [(partial(shifted, draw=draw), SHIFT) for draw in range(DRAWS)]
    for move, step in tries:
        for n_round in range(3):
            # New contacts may need more vertices: up to three rounds for each step.
            n_moved = sum(map(len, moved))
            _mark(contacts, bad, moved)
            if n_round and sum(map(len, moved)) == n_moved:
                break  # the same vertices would move to the same places
            both = zip(given, moved, strict=True)
            surfaces = [moved_surface(s, m, move, step, held) for s, m in both]
            try:
                found = find_contacts(surfaces, **contacts.options)
                contacts = with_own_contacts(found)
            except SurfaceError:
                break  # a face lost its area at this step

            children = cut_contacts(contacts)
            bad = unsound(contacts, children, moved)
            if len(bad) == 0:
                report = _moves(given, surfaces, moved)
                return contacts, children, report, then(contacts, children)
    raise _refusal(*first)


def _checked(
    contacts: Contacts, children: Children, then: Callable[[Contacts, Children], Result]
) -> tuple[np.ndarray, Callable[[], Result]]:
    """Faces that are unsound; and what returns the result of `then`, or raises its error."""
    made = Future[Result]()

    def make() -> None:
        """What counts only if the faces are sound, an error, too."""
        try:
            made.set_result(then(contacts, children))
        except GeosurfError as error:
            made.set_exception(error)

    if n_threads() == 1 or len(children.triangles) <= _MANY:
        return unsound(contacts, children), partial(then, contacts, children)
    # the check goes to another thread: what is made is large, and a thread's own memory new
    tasks: list[tuple[Callable[[], object]]] = [(partial(unsound, contacts, children),), (make,)]
    bad, _ = map_threads(lambda task: task(), tasks)
    return bad, made.result


def with_own_contacts(contacts: Contacts) -> Contacts:
    """The contacts, with those of surfaces with themselves that sharing vertices asks for.

    Two surfaces share the vertices of their curves, and the triangles of an area, only if both are
    cut alike there. Whatever meets one of them there meets the other as well, and cuts both, except
    the sheets of a surface itself: without `self_intersections` these cut only the other one. So a
    surface is searched for contacts with itself if two of its triangles, both of which meet another
    surface, meet each other elsewhere than in common corners and edges.
    """
    # Faces that meet another surface.
    owner, rows = contacts.surface_of_face, contacts.rows[:, :2]
    met = np.zeros(len(contacts.t), dtype=bool)
    met[rows[owner.take(rows[:, 0]) != owner.take(rows[:, 1])]] = True
    searched = {tuple(pair) for pair in contacts.options["pairs"]}
    more = []
    for i, surface in enumerate(contacts.surfaces):
        # A graph over the map cannot meet itself.
        is_graph = surface.lattice is not None and surface.lattice.is_graph
        if is_graph or (i, i) in searched:
            continue
        # A quick exact test of those faces alone: the full search follows only if some cross.
        start, stop = np.searchsorted(owner, (i, i + 1))
        faces = contacts.t[start:stop][met[start:stop]]
        if len(faces) > 1 and len(crossing_pairs(contacts.x, faces, faces[:0])):
            more.append((i, i))

    if not more:
        return contacts
    pairs = [*contacts.options["pairs"], *more]
    return find_contacts(contacts.surfaces, **{**contacts.options, "pairs": pairs})


def _mark(contacts: Contacts, faces: np.ndarray, moved: list[np.ndarray]) -> None:
    """Add the vertices of some faces and of all that they cross, wherever they occur.

    Searches differ in contacts on edges and corners of both triangles: lattices of one survey are
    not asked for what neighbouring cells have in common, nor for a surface's own neighbours. What
    is moved must not depend on that.
    """
    # Contacts inside faces bring their partners; those on boundaries depend on the search.
    faces = np.unique(faces)
    near = np.isin(contacts.rows[:, :2], faces).any(axis=1) & ~on_boundaries(contacts.rows)
    faces = np.union1d(faces, contacts.rows[near, :2])

    ids = np.zeros(contacts.n_vertex, dtype=bool)
    ids[contacts.t[faces]] = True
    for k, (surface, (nodes, vertex_of_node)) in enumerate(
        zip(contacts.surfaces, contacts.nodes, strict=True)
    ):
        # The model box does not move.
        if surface.role == "wall":
            continue
        vertices = nodes[ids[vertex_of_node]]
        if len(vertices) == 0:
            continue
        if surface.lattice is not None:
            vertices = surface.lattice.vertex_of_node.ravel()[vertices]

        # All copies of a vertex move together.
        first = first_of_equals(surface)
        if first is not None:
            vertices = first[vertices]
        moved[k] = np.union1d(moved[k], vertices)


def _held(surfaces: Sequence[TriSurface]) -> list[np.ndarray]:
    """Coordinates on each axis that stay: the model box is the user's, and what lies on it, too."""
    walls = [surface.vertices for surface in surfaces if surface.role == "wall"]
    return [
        np.unique(np.concatenate([w[:, axis] for w in walls] or [np.empty(0)])) for axis in range(3)
    ]


def _moves(
    given: Sequence[TriSurface], surfaces: Sequence[TriSurface], moved: Sequence[np.ndarray]
) -> dict[str, float]:
    """Number of moved vertices and the largest move [m]."""
    moves = [
        np.linalg.norm(places_of(new, rows) - places_of(old, rows), axis=1)
        for old, new, rows in zip(given, surfaces, moved, strict=True)
        if len(rows)
    ]
    far = np.concatenate(moves)
    return {"moved_vertices": int((far > 0).sum()), "largest_move": float(far.max(initial=0.0))}


def _refusal(contacts: Contacts, bad: np.ndarray) -> RoundingError:
    """Say where the surfaces cannot be held in float64."""
    face = bad[0]
    name = contacts.surfaces[contacts.surface_of_face[face]].name
    where = contacts.x[contacts.t[face, 0]] + contacts.origin

    # The surfaces that meet the face, to name them in the error.
    near = (contacts.rows[:, :2] == face).any(axis=1)
    met = np.unique(contacts.surface_of_face[contacts.rows[near, :2]])
    others = [contacts.surfaces[i].name for i in met.tolist()]
    return RoundingError(
        f"float64 cannot represent the pieces of {len(np.unique(bad))} triangles, the "
        f"first of surface {name!r} at {place(where)}; moving vertices by up to "
        f"{STEPS[-1]:.0e} m does not help. Surfaces almost touch there. Move one of "
        "them slightly.",
        place=where,
        surfaces=dict.fromkeys([name, *others]),
    )


# ---- find triangles that could cross after rounding; only those need an exact test -------
#
# Constructed points move by half a unit in the last place, e; nothing else moves. Two pieces of
# faces that meet at an angle can cross away from what they share only within about e / sin of
# their common line; so one of them, or a neighbour, is thinner than that. Pieces of faces that do
# not meet can cross only if the signs that keep them apart could change by such a move, and those
# pairs were noted when the signs were taken (`Contacts.near`). Which signs are taken depends on
# how candidates are searched and contacts are found; so the pairs that were noted are judged again
# by their corners alone (`kernels.sure`). What remains is the same for any search, and so is what
# a repair moves. Thin pieces and near pairs are few (none in most scenes) and are compared with
# all around them.


_SAFETY = 1024.0


def crossing_faces(
    contacts: Contacts, children: Children, moved: Sequence[np.ndarray] = ()
) -> np.ndarray:
    """Faces (rows of `Contacts.t`) with pieces that cross another triangle once rounded."""
    thin, near = _suspects(contacts, children)
    if moved:  # to a grid: then corners lie in planes but for its step, far more than rounding
        at_moved = _has_moved(contacts, moved)[children.parent]
        thin = np.union1d(thin, np.flatnonzero(at_moved))
    if len(thin) == 0 and len(near) == 0:
        return thin

    t, parent = children.triangles, children.parent
    if children.collisions:  # distinct points in one place are one vertex of the result
        number, _ = weld(children.x)
        t = np.unique(number, return_index=True)[1][number][t]

    # Children, then the faces that were not cut: all triangles of the result that matter.
    uncut = np.ones(len(contacts.t), dtype=bool)
    uncut[children.cut] = False
    uncut = np.flatnonzero(uncut)
    pieces = np.concatenate([t, contacts.t[uncut]])
    face = np.concatenate([parent, uncut])

    # Only triangles that are thin, or near others, can cross after rounding.
    suspect = _of_near_pairs(contacts, near, children.x, pieces, face)
    suspect[thin] = True
    if not suspect.any():
        return thin

    # Neighbours of suspects share their moved points.
    touched = np.zeros(len(children.x), dtype=bool)
    touched[pieces[suspect]] = True
    suspect[: len(t)] |= touched[t].any(axis=1)

    # Twins of an overlap would cross in their whole area: each triangle once.
    once = _once(pieces, suspect)
    mine, others = once[suspect[once]], once[~suspect[once]]
    pairs = crossing_pairs(children.x, pieces[mine], pieces[others])
    return face[np.concatenate([mine, others])[pairs.ravel()]]


def _suspects(contacts: Contacts, children: Children) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the thin children, and near pairs of faces."""
    # Rounding scales with the largest coordinate. Constructed points lie in faces that are cut, so
    # it is that of those; which others are kept depends on the search.
    largest = float(np.abs(contacts.x[contacts.t[children.cut]]).max(initial=0.0))
    faces = contacts.x, contacts.t, contacts.m.copy(), contacts.w, contacts.rows
    of = children.x, children.triangles, children.parent
    # thinner than what rounding can do, given the flattest contact
    return thin_children(*faces, *of, _SAFETY * ULP * largest), near_pairs(contacts)


def near_pairs(contacts: Contacts) -> np.ndarray:
    """Near pairs (n, 2) of faces that rounding could change: the same for any search."""
    if len(contacts.near) == 0:
        return contacts.near

    keys = np.unique(_keys_of(contacts, contacts.near))
    pairs = np.stack(np.divmod(keys, len(contacts.t)), axis=1)

    # contacts are far more than near pairs: each is looked up among these
    met = _keys_of(contacts, contacts.rows)
    at = np.minimum(np.searchsorted(keys, met), len(keys) - 1)
    meet = np.zeros(len(keys), dtype=bool)
    meet[at[keys[at] == met]] = True

    # Pairs that meet stay in contact; only the relation of the others can change.
    m, w = contacts.m.copy(), contacts.w
    return pairs[unstable_pairs(contacts.x, contacts.t, m, w, pairs, meet, ULP)]


def _keys_of(contacts: Contacts, pairs: np.ndarray) -> np.ndarray:
    """One number for each pair of faces, the lower face first: numbers rise as pairs do."""
    one, two = pairs[:, 0], pairs[:, 1]
    return np.minimum(one, two) * len(contacts.t) + np.maximum(one, two)


def _of_near_pairs(
    contacts: Contacts, pairs: np.ndarray, x: np.ndarray, pieces: np.ndarray, face: np.ndarray
) -> np.ndarray:
    """Whether pieces are of faces in near pairs, and their boxes reach the other face."""
    suspect = np.zeros(len(pieces), dtype=bool)
    if len(pairs) == 0:
        return suspect

    # Rows of `pieces` by face, with offsets.
    order = np.argsort(face, kind="stable")
    start = np.searchsorted(face[order], np.arange(len(contacts.t) + 1))
    first_face, second_face = np.concatenate([pairs, pairs[:, ::-1]]).T

    # All pieces of one face against the other face of the pair.
    count = start[first_face + 1] - start[first_face]
    first = np.cumsum(count) - count
    piece = order[np.repeat(start[first_face] - first, count) + np.arange(count.sum())]

    # A piece away from the other face cannot cross it.
    boxes = triangle_boxes(x, pieces)[piece]
    reach = np.repeat(triangle_boxes(contacts.x, contacts.t)[second_face], count, axis=0)
    meets = (boxes[:, :3] <= reach[:, 3:]) & (reach[:, :3] <= boxes[:, 3:])
    suspect[piece[meets.all(axis=1)]] = True
    return suspect


def _once(triangles: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Rows with each set of corners once; rows in `first` are preferred."""
    corners = np.sort(triangles, axis=1)
    n = int(corners.max(initial=0)) + 1
    order = np.argsort(~first, kind="stable")
    if n < 2_000_000:  # three numbers in one key
        key = (corners[:, 0] * n + corners[:, 1]) * n + corners[:, 2]
        return order[np.unique(key[order], return_index=True)[1]]
    return order[np.unique(corners[order], axis=0, return_index=True)[1]]


# ---- move vertices of surfaces to multiples of a step; a grid stays a grid where that is possible
#
# What is a list of triangles is searched, stored and certified triangle by triangle. 30 horizons
# of 301 x 301 nodes, of which 100 nodes move by 3e-9 m, took twice the time when their grids were
# lost.


def rounded(places: np.ndarray, step: float) -> np.ndarray:
    """Multiples of a step (of world coordinates)."""
    return np.rint(places / step) * step + 0.0


def shifted(places: np.ndarray, step: float, draw: int) -> np.ndarray:
    """Multiples of a step, up to one step off on each axis: equal places move alike.

    One draw may move two ends of a line so that it goes through the same place as before.
    """
    # A hash of the bits of all three coordinates; equal places have equal bits.
    bits = np.ascontiguousarray(places + 0.0).view(np.uint64)
    mixed = bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    mixed ^= mixed >> np.uint64(29)
    hashes = mixed.sum(axis=1, dtype=np.uint64) * np.uint64(0xBF58476D1CE4E5B9)

    # Bits of the hash decide between -1, 0 and 1 step on each axis.
    thirds = [
        (hashes >> np.uint64(k)) % np.uint64(3) for k in (17 - 3 * draw, 31 - draw, 45 + draw)
    ]
    return rounded(places, step) + step * (np.stack(thirds, axis=1).astype(np.float64) - 1.0)


def _has_moved(contacts: Contacts, moved: Sequence[np.ndarray]) -> np.ndarray:
    """Whether faces have a vertex that was moved, bool (n_face,)."""
    ids = np.zeros(contacts.n_vertex, dtype=bool)
    for surface, (nodes, vertex_of_node), rows in zip(
        contacts.surfaces, contacts.nodes, moved, strict=True
    ):
        lattice, first = surface.lattice, first_of_equals(surface)
        vertices = nodes if lattice is None else lattice.vertex_of_node.ravel()[nodes]
        known = np.isin(vertices, rows)
        if first is not None:  # of copies, which move together, the first is listed
            known |= np.isin(first[vertices], rows)
        ids[vertex_of_node[known]] = True
    found: np.ndarray = ids[contacts.t].any(axis=1)
    return found


def moved_surface(
    surface: TriSurface,
    rows: np.ndarray,
    move: Callable[..., np.ndarray],
    step: float,
    held: Sequence[np.ndarray],
) -> TriSurface:
    """The surface with some vertices moved to multiples of a step, as `move` does.

    `rows` of vertices are rising. `held` has coordinates of each axis that stay. What lies on them
    stays on them, and what is closer than a step comes to lie on them: the box of the user does not
    move.
    """
    if not len(rows):
        return surface
    before = places_of(surface, rows)
    there = move(before, step)
    for axis, values in enumerate(held):
        if len(values):
            nearest = _nearest(values, before[:, axis])
            near = np.abs(nearest - before[:, axis]) <= step
            there[:, axis] = np.where(near, nearest, there[:, axis])
    torn = surface.torn
    made = _as_grid(surface, rows, there) if torn is None else _as_torn(surface, torn, rows, there)
    if made is None:
        made = _as_list(surface, rows, there)
    made.sectors = surface.sectors
    return in_crs_of(made, [surface])


def _nearest(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The nearest of some rising values to each place."""
    above = np.minimum(np.searchsorted(values, places), len(values) - 1)
    low, high = values[np.maximum(above - 1, 0)], values[above]
    return np.where(np.abs(places - low) < np.abs(high - places), low, high)


def _nodes(lattice: Lattice, rows: np.ndarray) -> np.ndarray:
    """Nodes of some vertices, row by row, absent ones counted."""
    return rows if lattice.whole else np.flatnonzero(lattice.present.ravel())[rows]


def places_of(surface: TriSurface, rows: np.ndarray) -> np.ndarray:
    """World coordinates (n, 3) of some vertices, given as for `moved_surface`."""
    lattice = surface.lattice
    if type(lattice) is not Lattice or "vertices" in surface.__dict__:
        return surface.vertices[rows]
    return lattice.places_of_nodes(_nodes(lattice, rows))


def _as_grid(surface: TriSurface, rows: np.ndarray, there: np.ndarray) -> TriSurface | None:
    """The grid with moved nodes; None if some nodes are in one place, or a triangle shuts."""
    lattice = surface.lattice
    if type(lattice) is not Lattice or first_of_equals(surface) is not None:
        return None
    nodes = _nodes(lattice, rows)
    grid = _with_nodes(lattice, nodes, there)
    if _shuts(grid, nodes):
        return None
    marks = dict(surface.vertex_data)
    return TriSurface(surface.name, surface.role, lattice=grid, vertex_data=marks or None)


def _as_torn(
    surface: TriSurface, torn: TornLattice, rows: np.ndarray, there: np.ndarray
) -> TriSurface | None:
    """The torn sheet with moved nodes and ghosts; None as for a grid."""
    if first_of_equals(surface) is not None:
        return None
    nodes = torn.node_of_vertex[rows]
    is_ghost = nodes >= torn.n_node
    grid = _with_nodes(torn, nodes[~is_ghost], there[~is_ghost])
    if _shuts(grid, nodes[~is_ghost]):
        return None
    ghosts = torn.ghosts.copy()
    ghosts[nodes[is_ghost] - torn.n_node] = there[is_ghost]
    moved = TornLattice.of(grid, torn.gone, torn.copies, ghosts)
    return torn_sheet(surface.name, moved, surface.vertex_data, surface.role)


def _with_nodes(lattice: Lattice, nodes: np.ndarray, there: np.ndarray) -> Lattice:
    """A grid with moved nodes; each has coordinates of its own."""
    x, y, z = (np.array(part) for part in (*lattice.horizontal(), lattice.elevation))
    for values, new in zip((x, y, z), there.T, strict=True):
        values.flat[nodes] = new
    return Lattice(x, y, z, rising=lattice.rising, reverse=lattice.turned)


def _shuts(lattice: Lattice, nodes: np.ndarray) -> bool:
    """Whether a triangle at some nodes has two corners in one place."""
    cells = _cells_around(nodes, lattice.shape)
    corners = lattice.corners_of_keys(np.concatenate([2 * cells, 2 * cells + 1]))
    near = corners[np.isin(corners, nodes).any(axis=1)]
    places = lattice.places_of_nodes(near.ravel()).reshape(-1, 3, 3)  # absent nodes equal none
    return bool((places == np.roll(places, 1, axis=1)).all(axis=2).any())


def _cells_around(nodes: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """
    Return all cells of a grid that have one of some nodes as a corner, rising.

    Examples
    --------
    >>> _cells_around(np.array([0, 5]), (3, 3)).tolist()
    [0, 1, 3]
    """
    n_row, n_col = shape
    row, col = np.divmod(nodes, n_col)
    cells = []
    for i in (-1, 0):
        for j in (-1, 0):
            r, c = row + i, col + j
            some = (r >= 0) & (c >= 0) & (r < n_row - 1) & (c < n_col - 1)
            cells.append(r[some] * (n_col - 1) + c[some])
    return np.unique(np.concatenate(cells))


def _as_list(surface: TriSurface, rows: np.ndarray, there: np.ndarray) -> TriSurface:
    """The triangles of a surface, with moved vertices."""
    vertices = surface.vertices.copy()
    vertices[rows] = there
    marks, triangles = dict(surface.vertex_data), _triangles(surface)
    if not marks:  # torn sheets know their triangles by row
        triangles = _without_shut(vertices, triangles)
    return TriSurface(surface.name, surface.role, vertices, triangles, vertex_data=marks)


def _without_shut(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles but for those with two corners in one place, whose neighbours then meet there."""
    # Each corner against the next one.
    corners = vertices[triangles]
    shut = (corners == np.roll(corners, 1, axis=1)).all(axis=2).any(axis=1)
    return triangles if shut.all() else triangles[~shut]


def _triangles(surface: TriSurface) -> np.ndarray:
    """Triangles over the first of equal vertices, so that equals stay together."""
    first = first_of_equals(surface)
    return surface.triangles if first is None else first[surface.triangles]


# ---- patches ----------------------------------------
# Rebuild surfaces as patches that share one vertex per point along all curves.


def rebuild_surfaces(
    surfaces: Sequence[TriSurface],
    *,
    method: str = "auto",
    voxel_size: float | None = None,
    self_intersections: bool = False,
) -> Patches:
    """
    Split surfaces along their common curves, into one welded mesh.

    Only the triangles that a curve touches are triangulated again, with the curve as
    constraint. Surfaces that meet share one vertex for each point, and where they coincide
    over an area they share the triangles. Each triangle remembers the one it came from.

    Parameters
    ----------
    surfaces : sequence of TriSurface
        Any number. Vertices in metres.
    method, voxel_size, self_intersections
        As for `intersect_surfaces`.

    Returns
    -------
    Patches
        `Patches.surface` takes the mesh apart by surface, `Patches.patch` by patch. A surface
        that crosses itself is split there only with `self_intersections`, or if triangles do so
        that meet another surface, which shares their vertices then. Inputs that are
        degenerate up to rounding are moved to a coarser step where they break;
        ``report["largest_move"]`` says how far [m], 0 mostly, and `Patches.sources` are the
        surfaces as used, without slivers that a move shuts.

    Raises
    ------
    SurfaceError
        If a surface is empty or has triangles without area.
    RoundingError
        If the exact result cannot be held in float64: names the place.

    Notes
    -----
    Each cut face gets the constrained Delaunay triangulation of its points and segments, all
    decisions exact on points that are known by what makes them (Attene 2020, Levy 2024).
    Ties are broken by the points themselves, so that faces which overlap agree.

    Examples
    --------
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> patches = rebuild_surfaces([flat, wall])
    >>> patches.n_patch, len(patches.curve_edges), patches.surface("Top").n_triangle
    (3, 1, 3)
    """
    contacts = find_contacts(
        surfaces, method=method, voxel_size=voxel_size, self_intersections=self_intersections
    )
    return patches_from(contacts)


def patches_from(contacts: Contacts) -> Patches:
    """Cut the faces of known contacts and weld everything into patches."""
    contacts, children, moves, (pieces, rim, n_child) = cut_soundly(contacts, _assembled)
    report = {
        "cut_triangles": len(children.cut),
        "children": n_child,
        "constructed_points": len(children.d),
        "rounding_collisions": children.collisions,
        **moves,
    }
    return Patches.of_pieces(pieces, None, report, rim=rim)


def _assembled(contacts: Contacts, children: Children) -> tuple[Pieces, np.ndarray, int]:
    return assemble(with_torn_lattices(contacts), children)


# ---- torn sheets as lattices with gaps: what follows the contacts passes over runs, not triangles
#
# Contacts are found between the triangles of the list that a torn sheet is. From then on it is a
# `TornLattice`, so that only triangles at faults, curves and gaps are listed.


def with_torn_lattices(contacts: Contacts) -> Contacts:
    """Return contacts with torn sheets as lattices where they are, and their keys."""
    surfaces = tuple(as_lattice(surface) for surface in contacts.surfaces)
    changed = [k for k, one in enumerate(surfaces) if one is not contacts.surfaces[k]]
    if not changed:
        return contacts

    # faces are sorted by surface; keys rise with rows, so that they stay sorted
    keys, nodes = contacts.key_of_face.copy(), list(contacts.nodes)
    for k in changed:
        lattice = surfaces[k].lattice
        assert isinstance(lattice, TornLattice)
        mine = slice(*np.searchsorted(contacts.surface_of_face, (k, k + 1)))
        keys[mine] = lattice.keys_of_rows(keys[mine])
        vertices, ids = nodes[k]
        nodes[k] = lattice.node_of_vertex[vertices], ids
    return replace(contacts, surfaces=surfaces, key_of_face=keys, nodes=nodes)


def as_lattice(surface: TriSurface) -> TriSurface:
    """The same surface as a torn lattice, if it is one; remembered on it."""
    torn = surface.torn
    # vertices in one place are joined in lists only
    if torn is None or first_of_equals(surface) is not None:
        return surface
    made: TriSurface | None = surface.__dict__.get("_in_lattice")
    # a renamed twin has the same arrays, but not the same name
    if made is None or made.name != surface.name or made.role != surface.role:
        made = surface.renamed(surface.name, surface.role)
        made.__dict__.pop("_in_lattice", None)
        made.lattice = torn
        surface.__dict__["_in_lattice"] = made
    return made
