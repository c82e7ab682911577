"""Files of grids, meshes and packages of surfaces: horizons, faults and fluid contacts."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.faults import split_fault
from geosurf.read import read_fault, read_horizon, read_tsurf
from geosurf.read.resqml.representations import LINES, MESH, POINTS
from geosurf.read.resqml.surfaces import surfaces_of
from geosurf.scenario.new.found import OUT, Found, name_from
from geosurf.scenario.new.reading import DOWN, MOST_POINTS, UP, are_equal, surface_of_file
from geosurf.scenario.new.shape import mean_dip
from geosurf.scenario.new.tables import sticks_of

STEEP = 30.0  # dip [degrees] from which a surface is taken for a fault
MOST_PIECES = 12  # of a mesh that are faults of their own; more are a mesh that is torn apart
FAULT_NAME = re.compile(r"fault|(?:^|[^a-z])f\d+(?:$|[^a-z0-9])", re.IGNORECASE)
HORIZON_NAME = re.compile(r"horizon|top|base|surface", re.IGNORECASE)
CONTACT_NAME = re.compile(r"(?:^|[^a-z])(owc|goc|gwc|fwl|fwc)(?:$|[^a-z])", re.IGNORECASE)


def grid(path: Path) -> Found:
    """A horizon, or a level fluid contact."""
    one = surface_of_file(path, read_horizon, "grid", "horizon", "")
    z = one.points[:, 2]
    if not len(z):
        return Found(path, OUT, "grid", "all nodes are undefined")
    one.note = f"{len(z)} nodes" if len(z) < MOST_POINTS else f"{one.note} nodes"
    named = CONTACT_NAME.search(path.stem)
    # Fluid contacts are level, or named as such.
    if named or np.ptp(z) == 0:
        why = f"is named {named[1]!r}" if named else f"is level, z = {z[0]:g}"
        one.kind, one.note = "contact", f"the grid {why}"
    return one


def tsurfs(path: Path) -> list[Found]:
    """Every surface of a GOCAD file."""
    surfaces = read_tsurf(path, **UP)
    names = [surface.name for surface in surfaces]
    # Surfaces are read by name later, so names have to differ.
    if len(set(names)) < len(names):
        reason = f"{len(names)} surfaces share the name {names[0]!r}; rename them in the file"
        return [Found(path, OUT, "mesh", reason)]
    many = len(surfaces) > 1

    # A function of its own binds k for each surface.
    def reader(k: int) -> Any:
        return lambda words: read_tsurf(path, **words)[k]

    found = []
    for k, name in enumerate(names):
        found += pieces(mesh(path, name, reader(k), name if many else ""), name if many else "")
    return found


def pieces(whole: Found, in_file: str = "") -> list[Found]:
    """A fault of a few pieces as one fault for each: only so it can be extended."""
    whole.in_file = in_file
    parts = split_fault(whole.data) if whole.kind == "fault" else {}
    if not 1 < len(parts) <= MOST_PIECES:
        return [whole]
    name = whole.name or name_from(whole.path)
    return [
        replace(
            whole, name=f"{name} ({k})", piece=k, data=part, points=np.asarray(part.vertices),
            note=f"piece {k} of {len(parts)}, {part.n_triangle} triangles",
        )
        for k, part in enumerate(parts.values(), start=1)
    ]  # fmt: skip


def resqml(path: Path) -> list[Found]:
    """Every object of a package; the package states what it is, else its shape shows it."""
    found = []
    for surface in surfaces_of(path):
        name, role = surface.title, surface.role
        if surface.kind == MESH and not role:
            one = mesh(path, name, partial(_named, read_horizon, path, name), name)
        elif surface.kind == POINTS:
            note = (
                f"{name!r} is a set of points. A file that [tear] takes: geosurf convert "
                f"{shlex.quote(path.name)} points.poi --name {shlex.quote(name)}"
            )
            one = Found(path, OUT, "points", note, name)
        elif surface.kind in LINES and role != "fault":
            note = (
                f"{name!r} has lines, and the package does not state a fault. If they are sticks, "
                f"add [[faults]] with this file and name = {name!r}"
            )
            one = Found(path, OUT, "lines", note, name)
        elif surface.kind in LINES:
            one = sticks_of(path, name)
        else:
            read = read_fault if role == "fault" else read_horizon
            kind = role or "horizon"
            one = surface_of_file(
                path, partial(read, name=name), "RESQML", kind, f"{kind} of RESQML"
            )
            one.name = name
        one.states_direction = one.states_unit = True
        one.in_file = name
        found += pieces(one, name) if surface.kind == MESH else [one]
    return found


def _named(read: Any, path: Path, name: str, words: dict[str, Any]) -> Any:
    return read(path, name=name, **words)


def mesh(path: Path, known_as: str, read: Any, name: str = "") -> Found:
    """A horizon if it is gently dipping, a fault if it is steep."""
    surface = read(UP)
    dip = mean_dip(surface.vertices, surface.triangles)
    kind = "fault" if dip >= STEEP else "horizon"
    note = f"{surface.n_triangle} triangles, mean dip {dip:.0f} degrees"
    words = f"{path.stem} {known_as}"
    # Between gentle and steep the shape does not decide.
    if STEEP / 2 < dip < 1.5 * STEEP or not dip:  # the name decides
        if FAULT_NAME.search(words):
            kind = "fault"
        elif HORIZON_NAME.search(words):
            kind = "horizon"
    one = Found(path, kind, "mesh", note, name, np.asarray(surface.vertices), data=surface)
    one.states_direction = are_equal(one.points, np.asarray(read(DOWN).vertices))
    one.states_unit = True  # files of meshes state it, or it is that of x and y
    return one


__all__ = ["grid", "mesh", "pieces", "resqml", "tsurfs"]
