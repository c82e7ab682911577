"""TetGen (Si 2015), the optional extra ``tet``: its options, its process, and what it refuses.

Switches: ``nobisect`` leaves the faces of the model as they are; TetGen splits those few that it
cannot recover otherwise. ``epsilon`` is as small as doubles allow, and vertices are not merged: the
model is exact, and a tolerance would close its thin units. ``steinerleft=-1``: without it TetGen
stops in silence after 100 000 new points. ``minratio`` bounds the shapes that it tries to improve:
next to thin faces, which stay whole, no point can help, and smaller ratios do not end.

Whether TetGen ends depends on the order of the vertices, in models that differ in nothing else: of
five orders of the demo's vertices one did not end within minutes, three took 3 s. So vertices go in
by their places, and in another order if that does not end in a time that suffices for most models.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.errors import DependencyError, GeometryError, InvariantError
from geosurf.tetrahedra.boundary import Boundary

EPSILON = 1e-14
RATIO = 4.0  # radius of the sphere around a tetrahedron over its shortest edge
PATIENCE = 300.0, 0.005  # [s], and for each face and each tetrahedron of the asked size
SHORT = 20.0, 0.0003  # the same of all orders but the last: six times what models at hand take
N_ORDER = 4
PROCESS = Path(__file__).with_name("tetgen_process.py")
LICENCE = (
    "TetGen is licensed under the AGPL 3, or commercially by its author: check that your use is "
    "allowed"
)


def require_extra() -> None:
    """Raise an error that names the extra and its licence, if tetgen is missing."""
    if find_spec("tetgen") is None:
        raise DependencyError(
            "mesh_units needs tetgen, which is not installed. Install the extra: "
            f'pip install "geosurf[tet]". {LICENCE}.'
        )


def fill(
    boundary: Boundary, max_volume: float | None, expected: float = 0.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """
    Fill the boundary with tetrahedra.

    Parameters
    ----------
    boundary : Boundary
    max_volume : float or None
        Of a tetrahedron [m3]; None adds only points that a mesh cannot do without.
    expected : float
        Number of tetrahedra of that volume.

    Returns
    -------
    x : ndarray of float64, shape (n, 3)
        Those of the boundary first, unchanged.
    tetrahedra : ndarray of int64, shape (n_tetrahedron, 4)
        Seen from the fourth corner, the first three run counterclockwise.
    parts : ndarray of int64, shape (n_part, 3)
        Faces of the mesh on faces of the model.
    parents : ndarray of int64, shape (n_part,)
        Face of the model that each is, or is a part of.

    Raises
    ------
    GeometryError
        If TetGen refuses the model, or does not end.
    """
    options: dict[str, Any] = {"quality": False}
    if max_volume is not None:
        options = {
            "quality": True, "fixedvolume": True, "maxvolume": max_volume, "minratio": RATIO
        }  # fmt: skip
    options |= {
        "facesout": True, "nobisect": True, "nomergefacet": True, "nomergevertex": True,
        "epsilon": EPSILON, "steinerleft": -1,
    }  # fmt: skip
    found, order = _first_that_ends(boundary, options, len(boundary.faces) + expected)

    # vertices of the model in their own order again, new ones after them
    n = len(order)
    place = np.arange(len(found["node"]))
    place[:n] = order
    x = np.empty_like(found["node"])
    x[place] = found["node"]
    cells = place[found["elem"].astype(np.int64)]
    if not len(cells) or not np.array_equal(x[:n], boundary.x):
        raise InvariantError("TetGen moved vertices of the model; please report this with it.")

    # 0 marks faces inside of units
    marks = found["markers"].astype(np.int64)
    on = np.flatnonzero(marks > 0)
    return x, cells, place[found["trifaces"].astype(np.int64)[on]], marks[on] - 1


def _first_that_ends(
    boundary: Boundary, options: dict[str, Any], size: float
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What TetGen makes of the first order of the vertices that it ends on, and that order."""
    refusal: GeometryError | None = None
    for k in range(N_ORDER):
        order = np.lexsort(boundary.x.T[::-1])  # by easting, then northing, then elevation
        if k:
            order = np.random.default_rng(k).permutation(order)
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        base, each = SHORT if k < N_ORDER - 1 else PATIENCE
        try:
            given = replace(boundary, x=boundary.x[order], faces=rank[boundary.faces])
            return _run(given, options, base + each * size), order
        except GeometryError as error:
            refusal = error
    assert refusal is not None
    raise refusal


def _run(boundary: Boundary, options: dict[str, Any], patience: float) -> dict[str, np.ndarray]:
    """Run TetGen in a temporary folder, and return its arrays."""
    what = f"TetGen cannot fill the model of {len(boundary.faces)} faces"
    remedy = "Check the model with scene.check(), or move its surfaces slightly."
    with tempfile.TemporaryDirectory(prefix="geosurf-tetgen-") as folder:
        np.savez(
            Path(folder, "boundary.npz"),
            x=boundary.x,
            faces=boundary.faces.astype(np.int32),
            options=json.dumps(options),
        )
        # the process finds what this one finds, but for the folder of its own file
        code = "import runpy, sys; runpy.run_path(sys.argv[1], run_name='__main__')"
        try:
            done = subprocess.run(
                [sys.executable, "-c", code, str(PROCESS)],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=patience,
                check=False,
            )
        except subprocess.TimeoutExpired:
            other = (
                "Give a larger size, or none" if options["quality"]
                else "Give a size, about twice the distance of the nodes of the horizons"
            )  # fmt: skip
            raise GeometryError(
                f"{what}: it did not end within {patience / 60:.0f} minutes, nor before in other "
                f"orders of the vertices. {other}; "
                "or build the model from coarser surfaces."
            ) from None
        except OSError as error:
            raise DependencyError(f"TetGen cannot be started in a process: {error}.") from error

        refused, made = Path(folder, "error.txt"), Path(folder, "mesh.npz")
        if refused.exists():
            reason = refused.read_text(encoding="utf-8").strip().rstrip(".")
            raise GeometryError(f"{what}: {reason}. {remedy}")
        if done.returncode or not made.exists():
            last = (done.stderr.strip().splitlines() or ["it ended without a message"])[-1]
            raise GeometryError(f"{what}: its process ended ({done.returncode}): {last}. {remedy}")
        with np.load(made) as arrays:
            return {name: arrays[name] for name in arrays.files}
