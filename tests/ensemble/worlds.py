"""Small models with known volumes, for ensembles."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

import geosurf as gs
from geosurf.ensemble import ContactLevel, DepthError, DepthShift, Normal, Uniform
from tests.grids import gridded

AREA = 2000.0 * 1500.0  # m2
N = 5  # realisations
UNCERTAIN = [
    DepthShift("Top", Normal(0.0, 10.0)),
    DepthError("Base", sd=5.0, range=900.0),
    ContactLevel("OWC", elevation=Uniform(-1120.0, -1000.0)),
]


def plane(elevation, east=0.0, n=7):
    """A horizon over 2000 m x 1500 m, level or rising to the east [m per m]."""
    x, y = np.linspace(0.0, 2000.0, n), np.linspace(0.0, 1500.0, n)
    return gridded(elevation + east * x[None, :] + 0.0 * y[:, None], x, y)


def layer_cake(**more):
    """Two level horizons, 100 m apart: their volumes are known."""
    horizons = {"Top": plane(-1000.0), "Base": plane(-1100.0)}
    box = more.pop("box", (0, 2000, 0, 1500, -1300, -800))
    return gs.Scene(horizons, more.pop("faults", None), box, **more)


def scene():
    return layer_cake(contacts={"OWC": -1050.0})


def run(n=N, **more):
    """An ensemble of it."""
    asked = {"uncertain": UNCERTAIN, "maps": 500.0, **more}
    return gs.run_ensemble(scene(), n, **asked).data


def fault(x=1000.0, dip=60.0):
    """A plane that strikes north, dips east, and leaves the layer cake on all sides."""
    z = np.array([-2000.0, 0.0])
    east = x - (z + 1000.0) / np.tan(np.radians(dip))
    corners = [[e, y, up] for e, up in zip(east, z, strict=True) for y in (-1000.0, 3000.0)]
    return gs.TriSurface("F1", "fault", corners, [[0, 1, 2], [1, 3, 2]])


def bytes_of(store):
    """A hash of all files of a store."""
    digest = hashlib.sha256()
    for file in sorted(Path(store).rglob("*")):
        if file.is_file():
            digest.update(f"{file.relative_to(store)} ".encode() + file.read_bytes())
    return digest.hexdigest()
