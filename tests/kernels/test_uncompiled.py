"""The same kernels as plain Python: warnings are errors, bytes are the same."""

from __future__ import annotations

import hashlib
import sys

import numpy as np
import pytest

from geosurf import TriSurface, build_walls, carve_units, intersect_surfaces, rebuild_surfaces
from tests.kernels.families import FAMILIES, PREDICATES, kernel_signs, true_signs, tuples
from tests.processes import told_by
from tests.strategies import grid, sheet

pytestmark = pytest.mark.long  # of the compile machinery: an edit of kernels, not of the model


def short_form() -> str:
    """A hash over predicates, and two surfaces from curves to units."""
    digest = hashlib.sha256()
    for name, size in PREDICATES.items():
        for family in FAMILIES:
            points = tuples(family, 12, *size, seed=3)
            signs = kernel_signs(name, points)
            np.testing.assert_array_equal(signs, true_signs(name, points))
            digest.update(signs)
    surfaces = [
        grid("Top", [[0, 1, 0], [1, 2, 0], [0, 0, 1]], spacing=3.0, corner=(-1.0, -1.0)),
        sheet("F1", [(1, -1, -5), (1, 5, -5), (3, 5, 9), (3, -1, 9)]),
    ]
    curves = intersect_surfaces(surfaces)
    for array in (curves.local, curves.segments, *curves.curves):
        digest.update(array)
    patches = rebuild_surfaces([*surfaces, *build_walls((0, 4, 0, 4, -4, 8))])
    for array in (patches.local, patches.triangles, patches.patch_of_triangle):
        digest.update(array)
    units = carve_units(patches)
    assert len(units) == 4
    for name, unit in units.items():
        digest.update(f"{name} {unit.volume.hex()}".encode())
        digest.update(unit.triangles)
    return digest.hexdigest()


def test_plain_python_gives_the_same_bytes():
    assert isinstance(TriSurface, type)
    plain = {"NUMBA_DISABLE_JIT": "1", "PYTHONWARNINGS": "error"}
    assert told_by("-m", "tests.kernels.test_uncompiled", **plain).split() == ["True", short_form()]


if __name__ == "__main__":
    from numba.core import config

    sys.stdout.write(f"{bool(config.DISABLE_JIT)} {short_form()}\n")
