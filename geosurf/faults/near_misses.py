"""Ends of faults that stop short of another fault: near misses, each with a proposal."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from geosurf.errors import InputError
from geosurf.faults.bridge import side_gaps
from geosurf.faults.dangling import Fault
from geosurf.faults.distance import Approach, nearest_of
from geosurf.faults.lines import directions, guides_of
from geosurf.faults.rim import Rim, normals_of
from geosurf.faults.truncate import main_side
from geosurf.model.faults import SIDES, NetworkRow

REACH = 0.2  # default reach of near misses, of the square root of the area of the smaller fault
AHEAD = 0.5  # cosine of the angle within which an end must point at the fault that it misses


def near_miss(one: Fault, two: Fault, limit: float) -> NetworkRow | None:
    """The row of two faults that do not meet, if an end of one points at the other."""
    found = []
    for fault, main in ((one, two), (two, one)):
        a, b = np.reshape(fault.surface.bounds, (3, 2)), np.reshape(main.surface.bounds, (3, 2))
        apart = np.maximum(np.maximum(a[:, 0] - b[:, 1], b[:, 0] - a[:, 1]), 0.0)
        if np.linalg.norm(apart) > limit:
            continue
        facing = []
        for rim, side in product(fault.rims, SIDES):
            gap = _facing_gap(fault, main, rim, side, limit)
            if gap is not None:
                line = fault.surface.vertices[rim.arcs[side]]
                corners = main.surface.vertices[main.surface.triangles]
                facing.append((side_gaps(line, corners)[0], side, gap))
        if facing:  # of several sides the one that a bridge would start from
            _, side, gap = min(facing, key=lambda entry: entry[:2])
            found.append((gap.distance, fault.area, fault.name, side, fault, main, gap))
    if not found:
        return None
    distance, _, _, side, fault, main, gap = min(found, key=lambda entry: entry[:4])
    front, angle = _lies_in_front(fault, main, gap)
    reason = f"{distance:.1f} m short of {main.name}, {angle:.0f} degrees apart"
    return NetworkRow(
        "near miss", fault.name, main.name, side, 0.0, distance, tuple(gap.at.tolist()),
        "extend then truncate", side_word(main, front), reason,
    )  # fmt: skip


def _facing_gap(fault: Fault, main: Fault, rim: Rim, side: str, limit: float) -> Approach | None:
    """The closest approach of one side to another fault, if that is near and lies ahead."""
    x, arc = fault.surface.vertices, rim.arcs[side]
    if len(arc) < 2:
        return None
    line = x[arc]
    corners = main.surface.vertices[main.surface.triangles]
    gap = nearest_of(np.stack([line[:-1], line[1:]], axis=1), corners)
    if gap.distance > limit:
        return None
    if gap.distance > 0:
        t, guides = fault.surface.triangles, guides_of(fault.surface)
        nearest = arc[[np.linalg.norm(line - gap.at, axis=1).argmin()]]
        way = directions(x, t, nearest, side, rim.axes, guides)[0]
        if way @ (gap.there - gap.at) < AHEAD * gap.distance:
            return None
    return gap


def _lies_in_front(fault: Fault, main: Fault, gap: Approach) -> tuple[bool, float]:
    """Whether a fault lies in front of another one it nearly meets, and their angle there."""
    corners = main.surface.vertices[main.surface.triangles]
    off = np.linalg.norm(corners.mean(axis=1) - gap.there, axis=1)
    normal = unit_vector(normals_of(corners[[off.argmin()]])[0])
    own = fault.surface.vertices[fault.surface.triangles]
    near = np.linalg.norm(own.mean(axis=1) - gap.at, axis=1).argmin()
    mine = unit_vector(normals_of(own[[near]])[0])
    middle = own.mean(axis=(0, 1))
    angle = math.degrees(math.acos(min(1.0, abs(float(mine @ normal)))))
    return bool((middle - gap.there) @ normal >= 0), angle


def unit_vector(vector: np.ndarray) -> np.ndarray:
    """Return a vector of length one in the same direction."""
    return vector / np.linalg.norm(vector)


def side_word(main: Fault, front: bool) -> str:
    """The word for one side of a main fault."""
    for yes, no in (("hanging wall", "footwall"), ("right", "left")):
        try:
            return yes if (main_side(main.surface, yes) > 0) == front else no
        except InputError:
            continue
    return "+" if front else "-"
