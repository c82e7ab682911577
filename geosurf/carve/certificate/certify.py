"""Certify a model: recompute each property from the result, with exact tests where signs matter."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from geosurf.arrangement.memory_limit import gigabytes, lack_of_room
from geosurf.arrangement.threads import spare_threads
from geosurf.carve.certificate.by_runs import checks_by_runs, same_runs
from geosurf.carve.certificate.by_triangles import checks_by_triangles
from geosurf.carve.certificate.lines import MANY
from geosurf.errors import InputError
from geosurf.model import Certificate, Check, Patches, Units

if TYPE_CHECKING:
    from concurrent.futures import Executor

ROOM_OF_RUN = 1000  # bytes of a second run and of checks, per triangle that curves touch
ROOM = 610  # bytes per triangle: 13.9 GB for 21 million (docs/validation/results.md)
SAME = "two runs give the same bytes"
_EQUAL = "{} arrays equal, byte by byte"
WAYS = ("runs", "triangles")


def certify(
    patches: Patches, units: Units | None = None, *, by: Literal["runs", "triangles"] = "runs"
) -> Certificate:
    """
    Check the properties of a rebuilt mesh and of the units carved from it.

    Parameters
    ----------
    patches : Patches
    units : Units, optional
        Default: only the mesh is checked.
    by : {"runs", "triangles"}
        Triangles of grids that no curve touches are checked row by row, or one by one as they are
        written to files. All of them are checked one by one where the rows do not show that a
        property holds.

    Returns
    -------
    Certificate
        One check per property. Units are closed and oriented. Volumes add up to the box. Units
        and surfaces share their vertices. Each triangle inside the box has one unit on each side.
        The zone, block and contact of each unit match its bounding surfaces. Merged slivers are
        parts of their neighbours, and their volumes are in them. Surfaces meet only in shared edges
        and vertices (exact, on the rounded mesh). Each triangle lies on its input triangle and
        keeps its orientation (exact). Areas add up.

    Raises
    ------
    InputError
        If `by` is unknown. If a check of all triangles needs more memory than is free: about 0.6 GB
        per million triangles.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> wall = TriSurface("F1", "fault", [[3, -9, -5], [3, 9, -5], [3, 4, 9]], [[0, 1, 2]])
    >>> certify(rebuild_surfaces([flat, wall])).ok
    True
    """
    if by not in WAYS:
        raise InputError(f"by is {by!r}; expected one of {WAYS}.")
    with spare_threads(patches.n_triangle > MANY) as spare:
        return Certificate(tuple(_checks(patches, units, by, spare)))


def _checks(
    patches: Patches, units: Units | None, by: str = "runs", spare: Executor | None = None
) -> list[Check]:
    """The checks of `certify`; threads of `spare` take a part of them."""
    if by == "runs":
        checks = checks_by_runs(patches, units, spare)

        # what is wrong where is a matter of single triangles, if they fit in memory
        if checks is not None and all(check.passed for check in checks):
            return checks
    _refuse_if_too_large(patches.n_triangle)
    return checks_by_triangles(patches, units, spare)


def certify_repeated(patches: Patches, units: Units, rebuild: Callable[[], Patches]) -> Certificate:
    """
    Check a model, and that a second run of its rebuild gives the same bytes.

    Parameters
    ----------
    patches : Patches
    units : Units
    rebuild : callable
        Splits the surfaces of the patches again, from nothing. In large models it shares the cores
        with the checks, where the memory that is free holds both.

    Returns
    -------
    Certificate
        The lines of `certify`, then that of the second run.

    Raises
    ------
    InputError
        As `certify`.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes()
    >>> one, two = (gs.Scene(world.horizons, world.faults, world.box) for _ in range(2))
    >>> certify_repeated(one.patches, one.units, lambda: two.patches).ok
    True
    """
    pieces = patches.__dict__.get("pieces")
    n_listed = patches.n_triangle if pieces is None else len(pieces.triangles)
    with spare_threads(patches.n_triangle > MANY) as spare:
        # side by side only where the memory holds both; else the second run is after the checks
        if spare is None or lack_of_room(n_listed * ROOM_OF_RUN) is not None:
            checks = _checks(patches, units, spare=spare)
            return Certificate((*checks, same_bytes(patches, rebuild())))
        repeated = spare.submit(lambda: same_bytes(patches, rebuild()))
        checks = _checks(patches, units, spare=spare)
        return Certificate((*checks, repeated.result()))


def _refuse_if_too_large(n_triangle: int) -> None:
    """Raise an error with numbers, before the system has to end the process."""
    needed = n_triangle * ROOM
    free = lack_of_room(needed)
    if free is not None:
        raise InputError(
            f"a certificate of {n_triangle / 1e6:.3g} million triangles needs {gigabytes(needed)} "
            f"of memory, and {gigabytes(free)} are free. Check a smaller part of the model "
            "(aoi=...), simplify horizons (triangulate_horizon(..., tolerance=...)), or use a "
            "larger machine."
        )


def same_bytes(one: Patches, two: Patches) -> Check:
    """Check that two runs gave the same bytes.

    Examples
    --------
    >>> from geosurf import TriSurface, rebuild_surfaces
    >>> flat = TriSurface("Top", "horizon", [[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    >>> same_bytes(rebuild_surfaces([flat]), rebuild_surfaces([flat])).passed
    True
    """
    names = (
        "local", "triangles", "surface_of_triangle", "parent_of_triangle", "patch_of_triangle",
        "curve_edges",
    )  # fmt: skip
    if same_runs(one, two):
        return Check(SAME, True, 0.0, _EQUAL.format(len(names)))
    differ = [n for n in names if getattr(one, n).tobytes() != getattr(two, n).tobytes()]
    detail = f"{', '.join(differ)} differ" if differ else _EQUAL.format(len(names))
    return Check(SAME, not differ, float(len(differ)), detail)
