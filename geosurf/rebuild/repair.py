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

from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import Future
from functools import partial
from typing import TypeVar

import numpy as np

from geosurf.arrangement.arrange import Children, cut_contacts
from geosurf.arrangement.crossing import crossing_pairs
from geosurf.arrangement.known_pairs import Known, KnownPairs
from geosurf.arrangement.search import Contacts, find_contacts
from geosurf.arrangement.threads import map_threads, n_threads
from geosurf.conventions import place
from geosurf.errors import GeosurfError, RoundingError, SurfaceError
from geosurf.kernels.contacts.packed_contact import on_boundaries
from geosurf.kernels.exact.predicates import frame_of
from geosurf.kernels.meshes.mesh import inverted_triangles
from geosurf.model import TriSurface
from geosurf.rebuild.equal_vertices import first_of_equals
from geosurf.rebuild.moved_vertices import moved_surface, places_of, rounded, shifted
from geosurf.rebuild.soundness import crossing_faces

STEPS = tuple(2.0**-k for k in (28, 24, 20, 16, 13))  # metres; also the largest moves along an axis
SHIFT = 2.0**-15  # metres; with rounding to it, at most half of what the last step moves
_MANY = 20_000  # children; from then on they are checked in another thread
Result = TypeVar("Result")
DRAWS = 5  # of shifts, one after the other


def unsound(contacts: Contacts, children: Children) -> np.ndarray:
    """Faces whose children turn over or cross another triangle once rounded (exact tests)."""
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
    return crossing_faces(contacts, children)


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
    given, searched = contacts.surfaces, contacts.searched
    moved = [np.empty(0, dtype=np.int64) for _ in given]
    first, held = (contacts, bad), _held(given)

    tries: list[tuple[Callable[..., np.ndarray], float]] = [(rounded, step) for step in STEPS]
    tries += [(partial(shifted, draw=draw), SHIFT) for draw in range(DRAWS)]
    for move, step in tries:
        for _ in range(3):
            # New contacts may need more vertices: up to three rounds for each step.
            _mark(contacts, bad, moved)
            both = zip(given, moved, strict=True)
            surfaces = [moved_surface(s, m, move, step, held) for s, m in both]
            unmoved = _of_unmoved(searched, moved)
            try:
                found = find_contacts(surfaces, **contacts.options, known=unmoved)
                contacts = with_own_contacts(found)
            except SurfaceError:
                break  # a face lost its area at this step

            children = cut_contacts(contacts)
            bad = unsound(contacts, children)
            if len(bad) == 0:
                report = _moves(given, surfaces, moved)
                return contacts, children, report, then(contacts, children)
    raise _refusal(*first)


def _of_unmoved(
    searched: Mapping[tuple[int, int], Known], moved: Sequence[np.ndarray]
) -> KnownPairs:
    """What a search found of pairs of surfaces that stay: it is not searched again."""

    def get(key: Hashable) -> Known | None:
        """The pair of two surfaces, by their numbers."""
        assert isinstance(key, tuple)
        _, i, j, *_ = key
        return None if len(moved[i]) or len(moved[j]) else searched.get((i, j))

    return KnownPairs(get, lambda key, one: None, list(range(len(moved))))


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
    of, rows = contacts.surface_of_face, contacts.rows[:, :2]
    met = np.zeros(len(contacts.t), dtype=bool)
    met[rows[of.take(rows[:, 0]) != of.take(rows[:, 1])]] = True
    searched = {tuple(pair) for pair in contacts.options["pairs"]}
    more = []
    for i, surface in enumerate(contacts.surfaces):
        # A graph over the map cannot meet itself.
        is_graph = surface.lattice is not None and surface.lattice.is_graph
        if is_graph or (i, i) in searched:
            continue
        # A quick exact test of those faces alone: the full search follows only if some cross.
        start, stop = np.searchsorted(of, (i, i + 1))
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
    for k, (surface, (nodes, of_node)) in enumerate(
        zip(contacts.surfaces, contacts.nodes, strict=True)
    ):
        # The model box does not move.
        if surface.role == "wall":
            continue
        vertices = nodes[ids[of_node]]
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
