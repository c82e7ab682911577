"""Horizons that the column took away where another surface goes on: names stay right there."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from geosurf import TriSurface, build_contacts, build_walls, carve_units, rebuild_surfaces
from geosurf.carve.certificate import certify
from geosurf.carve.shells import unit_name
from geosurf.model import Units

BOX = (0.0, 3, 0, 3, -1, 3)
FLAT = np.full((5, 5), 1.0)


def horizon(name, z):
    x, y = np.meshgrid(np.arange(-1.0, 4), np.arange(-1.0, 4))
    rows = np.arange(25).reshape(5, 5)
    a, b, c, d = rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    points = np.stack([x, y, np.broadcast_to(z, x.shape)], -1).reshape(-1, 3)
    return TriSurface(name, "horizon", points, faces)


def bump(level):
    """A horizon at 0 that rises to a level, flat over two cells, above a flat one at 1."""
    z = np.zeros((5, 5))
    z[1:4, 1:3] = level
    return z


def carved(surfaces, contacts=None, column=None):
    levels, given = build_contacts(contacts or {}, BOX)
    patches = rebuild_surfaces([*surfaces, *levels, *build_walls(BOX)])
    return patches, carve_units(patches, column, given)


@pytest.mark.parametrize("level", [2.0, 3.0])
@pytest.mark.parametrize("beside", ["nothing", "contact", "fault"])
def test_an_older_horizon_is_taken_away_beside_a_wall_contact_or_fault(level, beside):
    """At 3 it lies on the lid of the box, at 2 on the contact or fault."""
    surfaces = [horizon("Top", FLAT), horizon("Base", bump(level))]
    if beside == "fault":
        plane = [[-1, -1, 2], [4, -1, 2], [4, 4, 2], [-1, 4, 2]]
        surfaces.append(TriSurface("F1", "fault", plane, [[0, 1, 2], [0, 2, 3]]))
    patches, units = carved(surfaces, {"OWC": 2.0} if beside == "contact" else None)
    assert certify(patches, units).ok, str(certify(patches, units))
    above = sum(unit.volume for unit in units.values() if unit.zone == "above Top")
    assert above == pytest.approx(3 * 3 * 2)


def test_wrong_zones_are_still_noticed_there():
    """Each unit in turn is called as if it were in another zone."""
    patches, units = carved([horizon("Top", FLAT), horizon("Base", bump(3.0))])
    zones = ("above Top", "Top/Base", "below Base")
    for unit in list(units.values()):
        for index, zone in enumerate(zones):
            if zone == unit.zone:
                continue
            wrong = copy.copy(unit)
            wrong.__dict__.update(zone=zone, zone_index=index, block="whole #9")
            wrong.__dict__["name"] = unit_name(zone, "whole #9")
            others = [u for u in units.values() if u is not unit]
            failed = [
                c.name
                for c in certify(patches, Units([*others, wrong], units.box)).checks
                if not c.passed
            ]
            assert failed == ["unit names match their bounding surfaces"], (unit.name, zone)
