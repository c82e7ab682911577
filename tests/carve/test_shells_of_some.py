"""Shells of a few units are those of all units, byte by byte, and list nothing else."""

import numpy as np

import geosurf as gs
from geosurf.synthetic.world import make_fault, make_horizon


def model():
    """Three horizons, two faults and a contact."""
    box = (0.0, 1000.0, 0.0, 1000.0, -900.0, -100.0)

    def level(k):
        return lambda x, y: -300.0 - 150.0 * k + 40.0 * np.sin(x / 210.0 + k) * np.cos(y / 170.0)

    whole, shift = (-50.0, 1050.0, -50.0, 1050.0), (0.0, 0.0, 0.0)
    horizons = {f"H{k}": make_horizon(f"H{k}", whole, 41, level(k), shift) for k in range(3)}
    z, y = np.meshgrid(np.linspace(-1000.0, 0.0, 9), np.linspace(-100.0, 1100.0, 13))
    faults = {
        name: make_fault(name, x + 0.3 * z + 20.0 * np.sin(y / 200.0), y, z, (0.0, 0.0, 0.0))
        for name, x in (("F1", 400.0), ("F2", 800.0))
    }
    return gs.Scene(horizons, faults, box, contacts={"OWC": -420.0})


def test_shells_of_some_units_are_those_of_all():
    units = model().units
    shells = next(iter(units.values()))._shell[0]
    n = len(shells.volumes)
    some = np.arange(n)[::3]
    found = [*shells.triangles_of(some)]
    assert "in_full" not in shells.cells.__dict__  # nothing else was listed
    for u, (x, triangles) in zip(some.tolist(), found, strict=True):
        whole = shells.triangles(u)
        assert x.tobytes() == whole[0].tobytes()
        assert triangles.tobytes() == whole[1].tobytes()
