"""What an interactive view shows of curves, fault sticks, fault networks and tetrahedra."""

from __future__ import annotations

import numpy as np

from geosurf.conventions import volume_text
from geosurf.model import Curves, FaultNetwork, FaultSticks, TetMesh
from geosurf.model.view3d import Body
from geosurf.render import palette

CROSS = 0.015  # arms of a mark, as a fraction of the extent in the map; twice that upwards
KINDS = {"contact": "Contacts", "near miss": "Near misses", "dangling end": "Dangling ends"}


def curve_bodies(curves: Curves) -> list[Body]:
    """Return a body of lines for each pair of surfaces that meet."""
    bodies = []
    of_curve, of_segment = np.sort(curves.surfaces_of_curve), np.sort(curves.surfaces_of_segment)
    for a, b in np.unique(of_curve, axis=0).tolist():
        mine = (of_curve == (a, b)).all(axis=1)
        first, second = curves.names[a], curves.names[b]
        name = f"{first} and {second}" if a != b else f"{first} with itself"
        length = float(curves.length_of_curve[mine].sum())
        facts = (("Curves", str(int(mine.sum()))), ("Length", f"{length:.6g} m"))
        segments = curves.segments[(of_segment == (a, b)).all(axis=1)]
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


__all__ = ["curve_bodies", "network_bodies", "stick_body", "tet_bodies"]
