"""What geosurf wants to reach, row by row: our work, the other one, the ratio that is asked.

`reached` measures them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.starts import IMPORTS
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError

FULL_SIZE = 2e7


@dataclass(frozen=True)
class Target:
    """One row.

    Attributes
    ----------
    name : str
        By which it is asked for.
    what : str
        What is timed, for people.
    ours : (str, str, float)
        Task, scene and size.
    theirs : (str, str, str)
        Peer (empty: geosurf itself), task and, for people, what it does. Same scene and size.
    asked : float or None
        The ratio that is wanted; None while none is.
    kind : str
        ``"faster"``: their time over ours, at least; ``"slower"``: our time over theirs, at
        most; ``"alone"``: our time only; ``"exponent"``: of our time over two decades, at
        most; ``"per edge"``: our microseconds for each edge, at most; ``"start"``: a
        process, of an installed wheel where one can be built; ``"memory"``: the inputs and the
        peak beyond them over the inputs, at most.
    within : float or None
        The time that ours may take [s], where that is what is asked.
    part : str
        The part of ours whose processor time that is; empty: the whole, by the clock.
    """

    name: str
    what: str
    ours: tuple[str, str, float]
    theirs: tuple[str, str, str] = ("", "", "")
    asked: float | None = None
    kind: str = "faster"
    within: float | None = None
    part: str = ""


_CGAL = ("compas_cgal", "curve", "CGAL, curve of two meshes")
_COREFINE = ("loop_cgal", "split", "CGAL, corefinement")
_TRUE = ("trueform", "split", "trueform, arrangement")
_REMESH = ("libigl", "split", "remesh_self_intersections")

TARGETS = (
    Target(
        "curve 2e6",
        "Curve of S1, 2e6 triangles, from two grids",
        ("curve", "S1", 2e6),
        _CGAL,
        asked=300.0,
    ),
    Target(
        "curve 2e7",
        "Curve of S1, 2e7 triangles, from two grids",
        ("curve", "S1", 2e7),
        _CGAL,
        asked=600.0,
    ),
    Target(
        "curve floor",
        "The same, against reading the grids once",
        ("curve", "S1", 2e7),
        ("", "floor", "smallest and largest of all values, numpy"),
        kind="slower",
        asked=3.0,
    ),
    Target(
        "20 faults",
        "Horizon of 2237 x 2237, 20 faults of 317 x 317: all curves",
        ("curve", "20 faults", 1.39936e7),
        _CGAL,
        within=0.06,
    ),
    Target(
        "shuffled",
        "Curve of S1 as arbitrary triangulations, 2e6",
        ("curve", "S1 shuffled", 2e6),
        _CGAL,
        asked=8.0,
    ),
    Target("split", "Split of S1, 2e6, to patches", ("split", "S1", 2e6), _COREFINE, asked=100.0),
    Target(
        "split shuffled",
        "Split of S1 as arbitrary triangulations, 2e6",
        ("split", "S1 shuffled", 2e6),
        _TRUE,
        asked=1.0,
    ),
    Target(
        "split full",
        "Split of S1, 2e6, to full arrays",
        ("split, full arrays", "S1", 2e6),
        _COREFINE,
        asked=25.0,
    ),
    Target(
        "split S2",
        "Split of S2, 2e6: a fault of two triangles",
        ("split", "S2", 2e6),
        _COREFINE,
        asked=50.0,
    ),
    Target(
        "split S2 arrays",
        "Split of S2, 1000 x 1000 cells, arrays to patches",
        ("split, from arrays", "S2", 2e6),
        _REMESH,
        within=0.03,
    ),
    Target(
        "drogon",
        "Drogon, 4 horizons and 6 faults, arrays to patches",
        ("split, from arrays", "drogon", 3.8e5),
        _REMESH,
        within=0.15,
    ),
    Target(
        "parallel chords",
        "10 000 parallel chords in one face",
        ("split, from arrays", "parallel chords", 1e4),
        _COREFINE,
        within=0.05,
    ),
    Target(
        "crossing chords",
        "100 x 100 crossing chords in one face",
        ("split, from arrays", "crossing chords", 200),
        _REMESH,
        within=0.2,
    ),
    Target(
        "units",
        "Two horizons of 401 x 401, a fault, a box: units and volumes",
        ("units", "block", 7.2e5),
        ("manifold3d", "units", "Booleans of solids"),
        asked=50.0,
    ),
    Target(
        "cells",
        "Cells and radial order of the same, for each edge",
        ("carve", "block", 7.2e5),
        ("libigl", "carve", "extract_cells"),
        kind="per edge",
        asked=1.0,
    ),
    Target(
        "exponent",
        "Growth of the curve, 2e5 to 2e7, search built",
        ("curve", "S1", 2e7),
        kind="exponent",
        asked=1.1,
    ),
    Target(
        "exponent kept",
        "Growth of the curve, 2e5 to 2e7, search kept",
        ("curve, kept search", "S1", 2e7),
        kind="exponent",
        asked=0.65,
    ),
    Target(
        "memory",
        "Peak of memory of the same curve of 2e7 triangles, inputs included",
        ("curve", "S1", 2e7),
        kind="memory",
        asked=1.5,
    ),
    Target(
        "five horizons",
        "Five horizons of 401 x 401, three faults that cross, a box: units and volumes",
        ("units", "five horizons", 1.6e6),
        kind="alone",
        within=5.0,
    ),
    Target(
        "sheets",
        "Sheets of a horizon of 2237 x 2237 nodes, torn at 6 faults",
        ("sheets", "torn", 1e7),
        kind="alone",
        within=1.5,
    ),
    Target(
        "drogon sheets",
        "Drogon, points and sticks: sheets of 4 horizons at 6 faults",
        ("sheets", "drogon field", 1e3),
        kind="alone",
    ),
    Target(
        "drogon model",
        "The same to units, volumes and certificate",
        ("model", "drogon field", 1e3),
        kind="alone",
        within=10.0,
    ),
    Target(
        "start",
        "Start of Python to end: curve of two triangles",
        ("start", "S1", 2e3),
        ("compas_cgal", "start", "the same with CGAL"),
        kind="start",
        within=0.4,
    ),
    Target(
        "first start",
        "The same for the first time: no bytecode of geosurf, no kept kernels",
        ("start", "S1", 2e3),
        ("compas_cgal", "start", "the same with CGAL, not for the first time"),
        kind="start",
        within=0.6,
    ),
    Target(
        "start from files",
        "Start of Python to end: two grid files to a file with their curve",
        ("start from files", "S1", 2e3),
        kind="start",
        within=1.5,
    ),
    Target(
        "start of a run",
        "Start of Python to end: a scenario of two grids and a fault, all results but pictures",
        ("start of a run", "S1", 2e3),
        kind="start",
        within=0.5,
        part=IMPORTS,
    ),
    Target(
        "first start from files",
        "The same for the first time: no bytecode of geosurf, no kept kernels",
        ("start from files", "S1", 2e3),
        kind="start",
        within=2.0,
    ),
)
UNSCALED = ("drogon", "drogon sheets", "drogon model")  # and starts


def select(names: Sequence[str] | None) -> list[Target]:
    """Return targets by name, all without names.

    Examples
    --------
    >>> [target.ours for target in select(["start"])]
    [('start', 'S1', 2000.0)]
    """
    known = [target.name for target in TARGETS]
    for name in names or ():
        if name not in known:
            raise InputError(
                f"no target is called {name!r}; there are {known}.{did_you_mean(name, known)}"
            )
    return [target for target in TARGETS if not names or target.name in names]
