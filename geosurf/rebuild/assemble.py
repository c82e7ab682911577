"""Assemble pieces and patches from cut faces, faces in contact and untouched faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geosurf.arrangement.arrange import Children
from geosurf.arrangement.search import Contacts
from geosurf.arrangement.threads import map_threads
from geosurf.errors import InvariantError
from geosurf.kernels.contacts.triangle_contact import in_plane, n_corners
from geosurf.kernels.lattices.sets import distinct, first_rows
from geosurf.kernels.lattices.strips import find_runs, join_runs, link_runs, lowest_keys
from geosurf.kernels.meshes.linking import merge_by_face, number_patches
from geosurf.kernels.meshes.mesh import edges, join_patches, weld
from geosurf.model import TriSurface
from geosurf.model.pieces import FREE, PAIRED, Pieces, Strips
from geosurf.model.torn_lattice import TornLattice

# ---- equal vertices ----------------------------------------
# Find vertices of one surface in the same place; most surfaces have none.


def has_strips(surface: TriSurface) -> bool:
    """Whether a surface is a lattice no two nodes of which are one point."""
    if surface.lattice is None:
        return False
    return surface.lattice.is_graph or first_of_equals(surface) is None


def first_of_equals(surface: TriSurface) -> np.ndarray | None:
    """For each vertex the first one in the same place; None if all differ. Remembered.

    Meshes in parts (GOCAD TFACE) repeat the vertices on their seams, and so does a lattice
    that closes in a ring.
    """
    if "_first_of_equals" not in surface.__dict__:
        first = None
        if _some_may_be_equal(surface):
            # The first vertex in each place: later rows are overwritten by earlier ones.
            number, count = weld(surface.vertices)
            first = first_rows(number, count)[number] if count < surface.n_vertex else None
        surface.__dict__["_first_of_equals"] = first
    return surface.__dict__["_first_of_equals"]


def _some_may_be_equal(surface: TriSurface) -> bool:
    """Whether points may be equal: if not, one sum of their coordinates tells them all apart.

    A sort of numbers takes a fifth of the time of a table of points.
    """
    lattice = surface.lattice
    if lattice is None:
        if surface.torn is not None and surface.torn.nodes_lie_apart:
            over = surface.torn.node_of_ghost
            if over is not None:
                return _ghosts_meet(surface.torn, over)
        x, y, z = surface.vertices.T
    else:
        x, y = lattice.horizontal()
        z = lattice.elevation
        if _rows_are_apart(x, y, z):
            return False

    # Coefficients of the plastic number: sums of grid coordinates do not repeat by chance.
    keys = (x + 0.7548776662466927 * y + 0.5698402909980532 * z).ravel()
    keys = np.sort(keys[np.isfinite(keys)])
    return bool((keys[1:] == keys[:-1]).any())


def _ghosts_meet(torn: TornLattice, over: np.ndarray) -> bool:
    """Whether a ghost has the height of its node, or of another ghost `over` the same node."""
    z = torn.ghosts[:, 2]
    if (z == torn.elevation.ravel()[over]).any():
        return True
    order = np.lexsort((z, over))
    over, z = over[order], z[order]
    return bool(((over[1:] == over[:-1]) & (z[1:] == z[:-1])).any())


def _rows_are_apart(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> bool:
    """Whether each row of nodes lies above or below the row before, and runs one way in the map.

    So do the rows of a fault that is extruded along its strike: 0.1 ms instead of 1.4 for a sort.
    """
    low, high = z.min(axis=1), z.max(axis=1)
    if not ((low[:-1] > high[1:]).all() or (high[:-1] < low[1:]).all()):
        return False

    steps = x[:, 1:] - x[:, :-1], y[:, 1:] - y[:, :-1]
    return any(bool((step > 0).all() or (step < 0).all()) for step in steps)


_NO_KEYS = np.empty(0, dtype=np.int64)
_MANY = 50_000  # triangles; from then on surfaces are listed in threads


def assemble(contacts: Contacts, children: Children) -> tuple[Pieces, np.ndarray, int]:
    """The pieces of all surfaces; the last half-edges of the edges between patches, rising; and how
    many triangles are parts of faces that were cut.
    """
    # Faces in contact become triangles one by one; the others of a lattice stay in strips.
    touched = np.zeros(len(contacts.t), dtype=bool)
    touched[contacts.rows[:, :2]] = True
    (x, t, surface, key, face, number), others = _triangles(contacts, children, touched)

    # Drop points that no triangle uses; `number` maps ids of the children to the new rows.
    in_use = np.zeros(len(x), dtype=bool)
    in_use[t] = True
    if not in_use.all():
        # `take` is many times as fast as an index in brackets where rows are short
        new = np.where(in_use, np.cumsum(in_use) - 1, -1)
        x, number, t = x.take(np.flatnonzero(in_use), axis=0), new.take(number), new.take(t)

    # Runs of triangles of each lattice that nothing touches.
    rows = np.flatnonzero(touched)
    cut = np.searchsorted(contacts.surface_of_face, np.arange(len(contacts.surfaces) + 1))
    cut = np.searchsorted(rows, cut)
    own = [(contacts, i, rows[j:k], number, others[i]) for i, (j, k) in enumerate(pairwise(cut))]
    strips = map_threads(_strips, own, worth=len(t) > _MANY)
    first_run = np.cumsum([0] + [0 if s is None else len(s.runs) for s in strips])

    # `ring`: the next half-edge around each edge; `link`: the run behind a free half-edge.
    ring, _ = edges(t, len(x))
    link = np.where(ring == np.arange(len(ring)), FREE, PAIRED)
    labels = t, surface, key, face
    linked = _add_links(ring, link, contacts, *labels, strips, first_run, number)

    # Patches end at rings of more than two half-edges: that is where curves are.
    twin, owners = _twins(contacts, t, surface, face)
    part, rim = join_patches(surface, owners, ring, twin)
    patch = _numbered_patches(surface, key, part, linked, strips, first_run)

    pieces = Pieces(
        contacts.surfaces, contacts.origin, x, t, surface, key, twin, ring, link,
        strips, first_run, patch,
    )  # fmt: skip
    n_uncut = int(np.count_nonzero(touched)) - len(children.cut)
    return pieces, rim, len(t) - sum(other.n for other in others) - n_uncut


def _triangles(
    contacts: Contacts, children: Children, touched: np.ndarray
) -> tuple[tuple[np.ndarray, ...], list[Others]]:
    """Points; corners, surface, key and face (-1: in no contact) of the triangles, in order;
    and the point of each id, first those of the children. And what nothing meets of each surface.
    """
    # Faces that a curve touches but does not cut stay as one triangle each.
    uncut = touched.copy()
    uncut[children.cut] = False
    uncut = np.flatnonzero(uncut)

    n = len(children.x)
    # faces that are only near one another depend on how candidates are searched: passed over
    met = np.zeros(contacts.n_vertex, dtype=bool)
    met[contacts.t[touched]] = True
    # Lattices wait in strips; lists bring all their other triangles.
    places, others = [children.x], []
    for i, source in enumerate(contacts.surfaces):
        other = NO_OTHERS
        if isinstance(source.lattice, TornLattice):
            other = beside_gaps(contacts, i, touched, met, n)
        elif not has_strips(source):
            other = untouched(contacts, i, touched, met, n)
        n += len(other.places)
        places.append(other.places)
        others.append(other)
    x = np.concatenate(places)

    # By surface and key, as in the input; pieces of one triangle stay in their order.
    cut = np.searchsorted(contacts.surface_of_face, np.arange(len(contacts.surfaces) + 1))
    first = [np.searchsorted(faces, cut) for faces in (children.parent, uncut)]
    counts = [other.n for other in others] + np.diff(first[0]) + np.diff(first[1])
    row = np.concatenate([[0], np.cumsum(counts)])
    t = np.empty((row[-1], 3), dtype=np.int64)
    surface, key, face = np.empty((3, row[-1]), dtype=np.int64)  # at once: large pages
    columns = contacts.t, contacts.surface_of_face, contacts.key_of_face
    rows = [
        (
            children.triangles, children.parent, uncut, *columns,
            other.triangles, other.taken, other.number, other.keys,
            i, first[0][i], first[1][i], row[i], row[i + 1], t, surface, key, face,
        )
        for i, other in enumerate(others)
    ]  # fmt: skip
    map_threads(merge_by_face, rows, worth=len(t) > _MANY)

    number = np.arange(len(x))
    if children.collisions:  # distinct points in one place become one vertex
        number, count = weld(x)
        welded = np.empty((count, 3))
        welded[number[::-1]] = x[::-1]
        x, t = welded, number[t]
    return (x, t, surface, key, face, number), others


def _strips(
    contacts: Contacts, i: int, touched: np.ndarray, number: np.ndarray, other: Others
) -> Strips | None:
    """What no curve touches of a lattice, given its touched faces."""
    source = contacts.surfaces[i]
    if not has_strips(source):
        return None
    lattice = source.lattice
    assert lattice is not None  # only lattices have strips
    a = lattice.places

    # Keys of the triangles that are listed one by one, and gaps where some do not exist.
    taken = contacts.key_of_face.take(touched)
    absent = lattice.gaps
    nodes, ids = contacts.nodes[i]
    if isinstance(lattice, TornLattice):  # triangles next to gaps are listed, too
        taken = distinct(taken[taken < lattice.n_key], lattice.beside_gaps)
        nodes = np.flatnonzero(other.number[: lattice.n_node] >= 0)
        ids = other.number[nodes]

    # Each row of cells has one run and one more for each triangle taken out of it; a second call if
    # that is too little.
    runs = np.empty((2 * lattice.shape[0] + 3 * len(taken) + 64, 4), dtype=np.int64)
    start, n = find_runs(a, taken, absent, runs)
    if n > len(runs):
        runs = np.empty((n, 4), dtype=np.int64)
        start, n = find_runs(a, taken, absent, runs)
    runs = runs[:n].copy()

    points = number.take(ids)
    used = np.flatnonzero(points >= 0)
    joined = join_runs(a, runs, start)
    return Strips(a, absent, runs, start, joined, nodes.take(used), points.take(used))


def _add_links(
    ring: np.ndarray,
    link: np.ndarray,
    contacts: Contacts,
    t: np.ndarray,
    surface: np.ndarray,
    key: np.ndarray,
    face: np.ndarray,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
    number: np.ndarray,
) -> np.ndarray:
    """Write the run behind each half-edge that is alone in its ring.

    Returns those that have one, and which: int64 (n, 2).
    """
    # A half-edge that is alone in its ring lies on a rim, or next to a strip.
    cut = 3 * np.searchsorted(surface, np.arange(len(strips) + 1))
    rows = []
    for i, strip in enumerate(strips):
        if strip is None:
            continue
        lattice = contacts.surfaces[i].lattice
        assert lattice is not None  # only lattices have strips
        rows.append((
            t, key, face, ring, cut[i], cut[i + 1], contacts.t, number, strip.places,
            strip.absent, bool(lattice.turned), strip.runs, strip.start, first_run[i], link,
        ))  # fmt: skip
    links = [np.empty((0, 2), dtype=np.int64)]
    for torn, linked in map_threads(link_runs, rows, worth=len(t) > _MANY):
        if torn >= 0:
            _raise_torn(contacts, torn, face)
        links.append(linked)
    return np.concatenate(links)


def _raise_torn(contacts: Contacts, triangle: int, face: np.ndarray) -> None:
    """Raise the error for a piece of which an edge inside the surface has no neighbour."""
    torn_face = face[triangle]
    name = contacts.surfaces[contacts.surface_of_face[torn_face]].name
    raise InvariantError(
        f"surface {name!r} came apart at triangle {contacts.row_of(torn_face)}; please report this "
        "with the surfaces."
    )


def _twins(
    contacts: Contacts, t: np.ndarray, surface: np.ndarray, face: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where surfaces coincide: first triangle with the same corners, and a number for the set
    of surfaces that own it (a surface's own row where there is only one). Else no triangles, and
    the surfaces themselves: as many numbers would be read for nothing.
    """
    rows = contacts.rows
    area = rows[in_plane(rows) & (n_corners(rows) >= 3), :2]
    if len(area) == 0:
        return _NO_KEYS, surface
    twin, owners = np.arange(len(t)), surface.copy()

    # Only faces in overlaps can have twins.
    marked = np.zeros(len(contacts.t) + 1, dtype=bool)  # the last one for face -1
    marked[area] = True
    candidates = np.flatnonzero(marked[face])

    # Triangles with the same sorted corners: the first one stands for all.
    corners = np.sort(t[candidates], axis=1)
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.ravel()
    twin[candidates] = candidates[first[inverse]]

    # Sets of surfaces that share a triangle, one row of booleans per distinct triangle.
    n_surface = len(contacts.surfaces)
    listed = np.zeros((len(first), n_surface), dtype=bool)
    listed[inverse, surface[candidates]] = True

    several = np.flatnonzero(listed.sum(axis=1) > 1)
    _, number = np.unique(listed[several], axis=0, return_inverse=True)
    set_number = np.full(len(first), -1, dtype=np.int64)
    set_number[several] = n_surface + number.ravel()

    shared = set_number[inverse] >= 0
    owners[candidates[shared]] = set_number[inverse[shared]]
    return twin, owners


def _numbered_patches(
    surface: np.ndarray,
    key: np.ndarray,
    part: np.ndarray,
    linked: np.ndarray,
    strips: Sequence[Strips | None],
    first_run: np.ndarray,
) -> np.ndarray:
    """Patch of each element, numbered by the first triangle in the order of surfaces and rows."""
    n_part, n_run = int(part.max(initial=-1)) + 1, int(first_run[-1])
    if n_run == 0:  # triangles are in this order, and so are the numbers of their parts
        return part

    # pairs of runs that share an edge, and the lowest key of each run
    joined, lowest = [np.empty((0, 2), dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    for first, strip in zip(first_run, strips, strict=False):
        if strip is not None:
            joined.append(strip.joined + first)
            lowest.append(lowest_keys(strip.places, strip.runs))
    runs = np.concatenate(joined), np.concatenate(lowest), first_run
    return number_patches(part, n_part, surface, key, linked, *runs)


# ---- the triangles of listed surfaces that nothing meets: they stay where the surface has them ---


@dataclass(frozen=True, eq=False)
class Others:
    """The triangles of a list that nothing meets, where the list has them.

    Attributes
    ----------
    triangles, taken, number, keys : ndarray
        As `merge_by_face` takes them.
    places : ndarray of float64, shape (n, 3)
        Their points that have no number yet, in the frame of the contacts.
    n : int
        How many these triangles are.
    """

    triangles: np.ndarray
    taken: np.ndarray
    number: np.ndarray
    keys: np.ndarray
    places: np.ndarray
    n: int


NO_OTHERS = Others(
    np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=bool), _NO_KEYS, _NO_KEYS,
    np.empty((0, 3)), 0,
)  # fmt: skip


def beside_gaps(contacts: Contacts, i: int, touched: np.ndarray, met: np.ndarray, n: int) -> Others:
    """The triangles of a torn lattice that are listed although nothing meets them.

    Those at faults, which are in no run, and those next to gaps, so that all of these share edges.
    """
    source, lattice = contacts.surfaces[i], contacts.surfaces[i].lattice
    assert isinstance(lattice, TornLattice)
    copies = lattice.n_key + np.arange(len(lattice.copies))
    keys = np.concatenate([lattice.beside_gaps, copies])
    triangles = lattice.corners_of_keys(keys)

    mine = np.flatnonzero(touched & (contacts.surface_of_face == i))
    taken = np.isin(keys, contacts.key_of_face[mine], assume_unique=True)
    nodes, ids = contacts.nodes[i]
    id_of_node = np.full(len(lattice.vertex_of_node), -1, dtype=np.int64)
    id_of_node[nodes[met[ids]]] = ids[met[ids]]
    new, count = _number_points(triangles, taken, id_of_node, n)
    places = source.places_of_nodes(new) - contacts.origin
    return Others(triangles, taken, id_of_node, keys, places, count)


def untouched(contacts: Contacts, i: int, touched: np.ndarray, met: np.ndarray, n: int) -> Others:
    """The triangles of a list that nothing meets; their new points are numbered from `n` on."""
    source = contacts.surfaces[i]
    nodes, ids = contacts.nodes[i]
    nodes, ids = nodes[met[ids]], ids[met[ids]]

    taken = np.zeros(source.n_triangle, dtype=bool)
    low, high = np.searchsorted(contacts.surface_of_face, [i, i + 1])
    mine = low + np.flatnonzero(touched[low:high])
    taken[source.rows_of_keys(contacts.key_of_face[mine])] = True

    # Vertices that contacts use have ids; the others get new ones, from `n` on.
    triangles, vertices = source.triangles, nodes
    if source.lattice is not None:
        vertices = source.lattice.vertex_of_node.ravel()[nodes]
    first = first_of_equals(source)
    if first is not None:
        triangles, vertices = first[triangles], first[vertices]

    id_of_vertex = np.full(source.n_vertex, -1, dtype=np.int64)
    id_of_vertex[vertices] = ids
    new, count = _number_points(triangles, taken, id_of_vertex, n)
    keys = _NO_KEYS
    if source.lattice is not None:
        keys = source.lattice.keys_of_rows(np.arange(len(triangles)))
    places = source.vertices.take(new, axis=0) - contacts.origin
    return Others(triangles, taken, id_of_vertex, keys, places, count)


def _number_points(
    t: np.ndarray, taken: np.ndarray, number: np.ndarray, first: int
) -> tuple[np.ndarray, int]:
    """Number the points of the triangles that are not taken, and count these triangles.

    `number` has the number of each point, or -1: these points get numbers from `first` on, in
    their order, and come back. They are written to `number`, too.
    """
    rows = np.flatnonzero(~taken)
    new = np.zeros(len(number), dtype=bool)
    new[t[rows]] = True
    points = np.flatnonzero(new & (number < 0))
    number[points] = first + np.arange(len(points))
    return points, len(rows)
