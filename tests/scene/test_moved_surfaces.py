"""Scenes whose surfaces move: each has the bytes of the scene made afresh."""

from __future__ import annotations

import numpy as np
import pytest

import geosurf as gs
from geosurf.errors import GeosurfError, InvariantError
from geosurf.model import Lattice
from tests.strategies import BOX, grid, sheet

# horizons cross and lie in the wrong order here, on purpose
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

COARSE, FINE = 1 / 8, 1 / 512
ARRAYS = ("x", "triangles", "surface", "key", "twin", "ring", "link", "patch")


def horizon(rng, level, step):
    """A grid of eighths: faults pass through nodes and along edges; horizons cross, and touch.

    Other numbers (step 0) have none of that, and multiples of a fine step little.
    """
    relief = rng.normal(0.0, 0.4, (7, 7))
    if step:
        most = 6 if step == COARSE else 400
        relief = rng.integers(-most, most + 1, (7, 7)) * step
    return grid("H", level + relief, corner=(-1.0, -1.0))


def fault(rng, step):
    """An upright or slanting sheet, which may end inside the model or miss a horizon."""
    off = rng.normal(0.0, 0.1, 2)
    if step:
        off = rng.integers(-60, 61, 2) * step if step == FINE else 0.0
    x, shift = rng.choice(9, 2, replace=False) / 2.0 + off
    low, high = sorted(rng.choice([-5.0, 0.0, 2.0, 4.0, 9.0], 2, replace=False))
    return sheet("F", [(x, -1, low), (x, 5, low), (shift, 5, high), (shift, -1, high)])


def result(scene):
    """Bytes of patches, curves and volumes, or the words of the refusal."""
    try:
        patches = scene.patches
        found = [getattr(patches.pieces, name).tobytes() for name in ARRAYS]
        return (
            *found, patches.curve_edges.tobytes(), str(patches.report),
            str(list(scene.units)), scene.volumes.values.tobytes(),
        )  # fmt: skip
    except InvariantError:
        raise
    except GeosurfError as error:
        return type(error), str(error)


@pytest.mark.parametrize("seed", range(3))
def test_grids_that_are_newly_crossed_are_those_made_afresh(seed):
    """Runs that nothing touched are cut, also amid a patch: a hill rises into a horizon,
    and then a ring around it.
    """
    rng = np.random.default_rng([84, seed])
    axis = np.linspace(-1.0, 5.0, 25)
    away = np.hypot(*np.meshgrid(axis - 2.0, axis - 2.0))
    hill, ring = np.exp(-(away**2) / 0.15), np.exp(-((away - 1.3) ** 2) / 0.03)

    def gridded(level, height, what=hill):
        heights = level + height * what + rng.normal(0.0, 0.02, (25, 25))
        return gs.TriSurface("H", "horizon", lattice=Lattice(axis, axis, heights))

    changes = {"horizons": {"Top": gridded(4.0, 0.0), "Mid": gridded(2.0, 0.5)}}
    changes["horizons"]["Base"] = gridded(0.5, 0.0)
    changes["faults"] = {"F1": fault(rng, 0.0), "F2": fault(rng, 0.0)}
    scene = gs.Scene(**changes, box=BOX)
    _ = result(scene)
    for k in range(6):
        kind = "faults" if k == 3 else "horizons"
        name = ("Mid", "Base", "Mid", "F1", "Base", "Top")[k]
        one = (
            gridded(2.0, 3.0), gridded(0.5, 5.0, ring), gridded(2.0, 2.5), fault(rng, 0.0),
            gridded(0.5, 0.0), gridded(4.0, 0.5),
        )[k]  # fmt: skip
        changes = {**changes, kind: {**changes[kind], name: one}}
        scene = scene.replace(**{kind: {name: one}})
        assert result(scene) == result(gs.Scene(**changes, box=BOX)), k
