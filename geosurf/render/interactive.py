"""Choose what an interactive view shows, with few enough triangles; nothing is drawn here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from geosurf.conventions import counted, palette, volume_text
from geosurf.conventions.palette import unit_colours
from geosurf.errors import InputError
from geosurf.kernels.lattices.sets import rim_edges
from geosurf.kernels.meshes.mesh import first_seen, number_keys
from geosurf.model import (
    Curves,
    FaultNetwork,
    FaultSticks,
    Patches,
    Sheet,
    TetMesh,
    TriSurface,
    Unit,
    Units,
)
from geosurf.model.protocols import Body, View3D
from geosurf.render.surface_layers import (
    UnitMesh,
    explosion,
    mesh_to_draw,
    outline,
    shells_to_draw,
    thinned,
)
from geosurf.render.views import bounds_of, choose_exaggeration

# ---- bodies ----------------------------------------
# What an interactive view shows of curves, fault sticks, fault networks and tetrahedra.


CROSS = 0.015  # arms of a mark, as a fraction of the extent in the map; twice that upwards
KINDS = {"contact": "Contacts", "near miss": "Near misses", "dangling end": "Dangling ends"}


def curve_bodies(curves: Curves) -> list[Body]:
    """Return a body of lines for each pair of surfaces that meet."""
    bodies = []
    curve_surfaces, segment_surfaces = (
        np.sort(curves.surfaces_of_curve),
        np.sort(curves.surfaces_of_segment),
    )
    for a, b in np.unique(curve_surfaces, axis=0).tolist():
        between = (curve_surfaces == (a, b)).all(axis=1)
        first, second = curves.names[a], curves.names[b]
        name = f"{first} and {second}" if a != b else f"{first} with itself"
        length = float(curves.length_of_curve[between].sum())
        facts = (("Curves", str(int(between.sum()))), ("Length", f"{length:.6g} m"))
        segments = curves.segments[(segment_surfaces == (a, b)).all(axis=1)]
        bodies.append(_lines(name, "Curves", palette.ACCENT, curves.points, segments, facts))
    return bodies


def stick_body(sticks: FaultSticks, number: int) -> Body:
    """Return the picked lines of a fault."""
    sizes = [len(stick) for stick in sticks.sticks]
    last = np.cumsum(sizes) - 1
    rows = np.setdiff1d(np.arange(sum(sizes)), last)  # the last point of a stick starts no line
    facts = (("Role", "fault sticks"), ("Size", f"{len(sizes)} sticks, {sum(sizes)} points"))
    lines, points = np.stack([rows, rows + 1], axis=1), np.concatenate(sticks.sticks)
    return _lines(sticks.name, "Fault sticks", palette.fault(number), points, lines, facts)


def _lines(
    name: str,
    group: str,
    colour: palette.RGB,
    points: np.ndarray,
    lines: np.ndarray,
    facts: tuple[tuple[str, str], ...],
) -> Body:
    """A body of lines."""
    used, rows = np.unique(lines, return_inverse=True)
    none = np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    return Body(name, group, colour, points[used], *none, rows.reshape(-1, 2), facts, closed=False)


def tet_bodies(mesh: TetMesh) -> list[Body]:
    """Return the skin of the tetrahedra of each unit, with the edges of the mesh."""
    bodies = []
    for row, name in enumerate(mesh.unit_names):
        # a face is seen from its front, so its unit in front has it the other way round
        front, behind = (mesh.face_sides[:, side] == row for side in (0, 1))
        faces = np.concatenate([mesh.faces[front][:, ::-1], mesh.faces[behind]])
        used, corners = np.unique(faces, return_inverse=True)
        triangles = corners.reshape(-1, 3)
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))
        size = f"{int((mesh.region == row).sum())} tetrahedra"
        bodies.append(
            Body(
                name,
                "Tetrahedra",
                palette.stratum(row),
                mesh.vertices[used],
                triangles,
                np.concatenate([mesh.surface_of_face[front], mesh.surface_of_face[behind]]),
                np.unique(edges, axis=0),
                (("Size", size), ("Volume", volume_text(float(mesh.volumes[row])))),
            )
        )
    return bodies


def network_bodies(network: FaultNetwork) -> list[Body]:
    """Return a cross for each row of a fault network, with its proposal as numbers."""
    places = np.array([row.place for row in network.rows]).reshape(-1, 3)
    corners = [fault.vertices for fault in network.faults if len(fault.vertices)]
    extent = np.ptp(np.concatenate([places, *corners]), axis=0) if len(places) else np.zeros(3)
    east, north, up = extent.tolist()
    arm = CROSS * np.array([max(east, north) or 1.0] * 2 + [2.0 * up or 1.0])
    lines = np.array([[0, 1], [2, 3], [4, 5]])
    arms = np.repeat(np.diag(arm), 2, axis=0) * np.array([[1], [-1]] * 3)
    bodies = []
    for number, (row, at) in enumerate(zip(network.rows, places, strict=True)):
        meets = f" and {row.other}" if row.other else ""
        facts = [("Proposal", row.proposal)]
        facts += [("Keep", row.keep)] if row.keep else []
        facts += [("Length", f"{row.length:.6g} m")] if row.length else []
        facts += [("Distance", f"{row.distance:.6g} m")] if row.distance else []
        facts.append(("Reason", row.reason))
        name = f"row {number}: {row.fault}{meets}"
        group = KINDS[row.kind]
        bodies.append(_lines(name, group, palette.ACCENT, at + arms, lines, tuple(facts)))
    return bodies


# ---- cluster ----------------------------------------
# Shells with fewer triangles: points of the same surfaces that are close together become one.
#
# A point belongs to the set of surfaces that meet in it: points inside a surface become one with
# each other, points of a line where two surfaces meet with others of that line. So a unit stays
# closed, units that share a surface go on sharing it, and the ends of lines stay where they are.
# On a plane the volume of a shell does not change. Lines stay as they are unless their triangles
# alone take more than half of what may be drawn.
#
# Source: vertex clustering after Rossignac & Borrel (1993), "Multi-resolution 3D approximations for
# rendering complex scenes", in cells of the map; unlike them we never merge points of two surfaces.


STEP, TRIES = 1.25, 16  # by how much cells grow at least in each attempt
LARGEST = 1 << 62  # number of a cell


def clustered(mesh: UnitMesh, max_triangle: int, exaggeration: float = 1.0) -> UnitMesh:
    """Return a mesh whose shells have about `max_triangle` triangles in all.

    Parameters
    ----------
    mesh : UnitMesh
    max_triangle : int
    exaggeration : float
        Vertical exaggeration of the picture: cells are lower by that.

    Returns
    -------
    UnitMesh
    """
    n = mesh.n_drawn
    if n <= max_triangle:
        return mesh
    points, triangles = mesh.points, mesh.triangles
    drawn = mesh.sides >= 0  # column by column: along rows of two or three numpy is slow
    sides = drawn[:, 0].astype(np.int64) + drawn[:, 1]  # how many shells draw each triangle
    meeting, several = surfaces_at(len(points), triangles, mesh.surface)

    # an edge on a line stays, whatever happens around it
    a, b, c = (several.take(triangles[:, k]) for k in range(3))
    rigid = a & b | b & c | c & a
    moves = ~several if 2 * sides[rigid].sum() <= max_triangle else np.ones(len(points), dtype=bool)

    # the first size is right for a regular mesh
    x, y = (
        points[:, k].take(triangles[:, 0]) - points[:, k].take(triangles[:, 1]) for k in range(2)
    )
    size = float(np.median(np.hypot(x, y))) * math.sqrt(n / max_triangle) or 1.0
    for _ in range(TRIES):
        cluster = _clusters(points, meeting, moves, size, exaggeration)
        corners = cluster.take(triangles)
        kept = _distinct(corners)
        n = int(sides[kept].sum())
        if n <= max_triangle:
            break
        size *= max(STEP, math.sqrt(n / max_triangle))
    means = _means(points, cluster)
    return replace(
        mesh,
        points=means,
        triangles=corners[kept],
        sides=mesh.sides[kept],
        surface=mesh.surface[kept],
    )


def surfaces_at(
    n_point: int, triangles: np.ndarray, surface: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return a number for the set of surfaces at each point, and whether there are several.

    Examples
    --------
    >>> triangles = np.array([[0, 1, 2], [1, 2, 3], [3, 2, 4]])
    >>> meeting, several = surfaces_at(5, triangles, np.array([7, 7, 8]))
    >>> meeting.tolist(), several.tolist()
    ([0, 0, 2, 2, 1], [False, False, True, True, False])
    """
    # of triangles at a point, those of the lowest and of the highest surface
    meeting, lowest = np.full((2, n_point), -1)
    order = np.argsort(surface, kind="stable")
    for found, rows in ((meeting, order), (lowest, order[::-1])):
        found[triangles[rows].ravel()] = np.repeat(surface[rows], 3)
    several = meeting != lowest

    # the surfaces of a point join its set one after the other, each set with a number of its own
    n_surface = int(surface.max(initial=0)) + 2
    codes = triangles * n_surface + surface[:, None]
    pairs = np.sort(first_seen(codes[several[triangles]])[0])
    point, other = np.divmod(pairs, n_surface)
    first = np.flatnonzero(np.append(True, point[1:] != point[:-1]))[: len(pairs)]
    place = np.arange(len(pairs)) - np.repeat(first, np.diff(np.append(first, len(pairs))))
    joined = np.full(n_point, -1)
    for k in range(int(place.max(initial=-1)) + 1):
        now = place == k
        joined[point[now]] = (joined[point[now]] + 1) * n_surface + other[now]
        joined[several] = number_keys(joined[several])[1]
    meeting[several] = n_surface + joined[several]
    return number_keys(meeting)[1], several


def _clusters(
    points: np.ndarray, meeting: np.ndarray, moves: np.ndarray, size: float, exaggeration: float
) -> np.ndarray:
    """The cluster of each point: a cell of one set of surfaces, or the point itself."""
    low = [points[:, k].min() for k in range(3)]
    steps = (size, size, size / exaggeration)
    code = meeting.copy()
    for k in range(3):
        cell = ((points[:, k] - low[k]) / steps[k]).astype(np.int64)
        n_cell = int(cell.max()) + 1
        if (int(code.max()) + 1) * n_cell > LARGEST:
            code = number_keys(code)[1]
        code = code * n_cell + cell
    code[~moves] = -1 - np.flatnonzero(~moves)
    return number_keys(code)[1]


def _distinct(triangles: np.ndarray) -> np.ndarray:
    """Whether each triangle still has three corners."""
    a, b, c = triangles.T
    made: np.ndarray = (a != b) & (b != c) & (c != a)
    return made


def _means(points: np.ndarray, cluster: np.ndarray) -> np.ndarray:
    """Mean (n_cluster, 3) of the points of each cluster."""
    count = np.bincount(cluster)
    start = points[0]
    sums = [np.bincount(cluster, (points[:, k] - start[k])) for k in range(3)]
    made: np.ndarray = np.column_stack(sums) / count[:, None] + start
    return made


# of all bodies: about 2.5 MB of a page
MAX_VIEW_TRIANGLE = 120_000
EXPLODED = 0.3  # shift at the end of the slider, as a fraction of the model box
SHORTEST = 1.0 / 3000.0  # lines, as a fraction of the diagonal of the map: less than a pixel
SLIVERS, OUTSIDE = "Slivers", "Above and below the reservoir"
GROUPS = {"horizon": "Horizons", "fault": "Faults", "wall": "Walls", "contact": "Contacts"}


def view_of_units(units: Units, max_triangle: int = MAX_VIEW_TRIANGLE) -> View3D:
    """Return an interactive view of units: one group per zone, slivers in a group of their own.

    Units outside the reservoir are in a group that is not visible at first.

    Parameters
    ----------
    units : Units
    max_triangle : int
        Of all units, about.

    Returns
    -------
    View3D
    """
    labels, solid = units.labels, {unit.name for unit in units.without_slivers}
    shades = unit_colours((labels[u.name], u.zone_index) for u in units.without_slivers)
    stretch = choose_exaggeration(units.box)
    mesh = mesh_to_draw(units, max_triangle)
    few = mesh.n_drawn <= max_triangle
    shells = (
        shells_to_draw(units, max_triangle)
        if few
        else clustered(mesh, max_triangle, stretch).shells
    )
    drawn = zip(units.values(), shells, explosion(units, EXPLODED), strict=True)
    diagonal = float(np.hypot(*np.ptp(np.reshape(units.box[:4], (2, 2)), axis=1)))
    bodies = []
    for unit, shell, (east, north, up) in drawn:
        inside = unit.zone in units.reservoir
        facts = [("Zone", unit.zone), ("Block", unit.block)]
        facts += [("Region", unit.region)] if unit.region else []
        facts += [("Contact", unit.contact)] if unit.contact else []
        facts += [("Volume", volume_text(unit.volume)), ("Bounded by", ", ".join(unit.bounded_by))]
        bodies.append(
            Body(
                unit.name,
                OUTSIDE if not inside else unit.zone if unit.name in solid else SLIVERS,
                shades.get(labels[unit.name], palette.FAINT) if inside else palette.WALL,
                shell.points,
                shell.triangles,
                shell.surface,
                _visible(shell.points, outline(shell, creases=False), diagonal),
                tuple(facts),
                (float(east), float(north), float(up)),
                shown=inside,
            )
        )

    # slivers and what is hidden come last: the group of slivers is folded
    bodies.sort(key=lambda body: (body.group == SLIVERS, body.group == OUTSIDE))
    return View3D(tuple(bodies), units.box, stretch)


def _visible(points: np.ndarray, lines: np.ndarray, diagonal: float) -> np.ndarray:
    """Lines without the shortest ones: graphics drivers draw those in front of anything."""
    length = np.linalg.norm(points[lines[:, 0]] - points[lines[:, 1]], axis=1)
    made: np.ndarray = lines[length > SHORTEST * diagonal]
    return made


def view_of_surfaces(
    surfaces: Iterable[TriSurface], max_triangle: int = MAX_VIEW_TRIANGLE
) -> View3D:
    """Return an interactive view of surfaces: one group per role.

    Parameters
    ----------
    surfaces : iterable of TriSurface
        Horizons youngest first: they take the colours of the column.
    max_triangle : int
        Of each gridded surface; other surfaces are shown as they are.

    Returns
    -------
    View3D

    Raises
    ------
    InputError
        If there are no triangles.
    """
    surfaces = tuple(surfaces)
    bodies, count = [], {"fault": 0, "horizon": 0}
    plain = {"wall": palette.WALL, "contact": palette.CONTACT}
    only_walls = all(surface.role == "wall" for surface in surfaces)
    for surface in surfaces:
        role = "fault" if surface.role == "fault" else "horizon"
        if surface.role in plain:
            colour = plain[surface.role]
        else:
            colour = (palette.fault if role == "fault" else palette.stratum)(count[role])
            count[role] += 1
        light = thinned(surface, max_triangle)
        if not light.n_triangle:
            continue
        bodies.append(
            Body(
                surface.name,
                GROUPS.get(surface.role, "Surfaces"),
                colour,
                light.vertices,
                light.triangles,
                np.zeros(light.n_triangle, dtype=np.int64),
                rim_edges(light.triangles),
                (("Role", surface.role), ("Size", counted(surface.n_triangle, "triangle"))),
                closed=False,
                shown=only_walls or surface.role != "wall",  # walls hide all others
            )
        )
    box = bounds_of([body.points for body in bodies])
    return View3D(tuple(bodies), box, choose_exaggeration(box))


def view_of(things: Sequence[object], max_triangle: int = MAX_VIEW_TRIANGLE) -> View3D:
    """Return an interactive view of any nouns together.

    Parameters
    ----------
    things : sequence of objects
        TriSurface, Sheet, Curves, Patches, FaultSticks, FaultNetwork, Unit, Units or TetMesh. A
        sheet brings the faults that tear it, a fault network its faults.
    max_triangle : int
        Of all units, and of each gridded surface, about.

    Returns
    -------
    View3D

    Raises
    ------
    InputError
        If there is nothing to show, or something that has no place in space.
    """
    surfaces: list[TriSurface] = []
    others: list[Body] = []
    for thing in things:
        match thing:
            case TriSurface():
                surfaces.append(thing)
            case Sheet():
                surfaces += [thing.surface, *thing.faults]
            case Patches():
                surfaces += [thing.surface(k) for k in range(len(thing.sources))]
            case Units():
                others += view_of_units(thing, max_triangle).bodies
            case Unit():
                low, high = thing.vertices.min(axis=0), thing.vertices.max(axis=0)
                box = tuple(np.ravel((low, high), order="F").tolist())
                alone = Units([thing], box, {})
                others += view_of_units(alone, max_triangle).bodies
            case Curves():
                others += curve_bodies(thing)
            case FaultSticks():
                others.append(stick_body(thing, len(others)))
            case TetMesh():
                others += tet_bodies(thing)
            case FaultNetwork():
                surfaces += thing.faults
                others += network_bodies(thing)
            case _:
                raise InputError(
                    f"an object of type {type(thing).__name__} cannot be shown in three "
                    "dimensions. Show surfaces, sheets, curves, patches, fault sticks, fault "
                    "networks, units or a scene; triangulate grids first: "
                    "gs.triangulate_horizon(top)."
                )

    # a fault that tears several sheets is shown once
    surfaces = list({id(surface): surface for surface in surfaces if surface.n_triangle}.values())
    bodies = (*view_of_surfaces(surfaces, max_triangle).bodies, *others) if surfaces else others
    if not bodies:
        raise InputError("there is nothing to show: no triangles and no curves.")
    box = bounds_of([body.points for body in bodies])
    return View3D(tuple(bodies), box, choose_exaggeration(box))
