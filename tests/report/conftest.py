"""A small model of which a test may replace what a report asks for."""

from types import SimpleNamespace

import numpy as np
import pytest

import geosurf as gs
from geosurf.model import Unit
from geosurf.model.protocols import ReportedModel

BOX = (0.0, 1000.0, 0.0, 1000.0, -300.0, 0.0)


def unit(zone, zone_index, block, volume):
    return Unit(
        name=f"{zone}, {block}",
        zone=zone,
        zone_index=zone_index,
        block=block,
        local=np.zeros((3, 3)),
        origin=np.zeros(3),
        triangles=np.array([[0, 1, 2]]),
        surface_of_triangle=np.zeros(1, dtype=int),
        surface_names=("Top",),
        volume=volume,
        area=1.0,
    )


def changed(scene, **members):
    """What a report asks of a scene, with some of it replaced; without pictures and a view."""
    asked = (vars(base) for base in ReportedModel.__mro__)
    names = {name for held in asked for name in held if not name.startswith("_")}
    still = {"render_pictures": lambda *_, **__: {}, "view_3d": lambda *_: None}
    return SimpleNamespace(**{name: getattr(scene, name) for name in names} | still | members)


@pytest.fixture
def scene():
    world = gs.synthetic.tilted_planes(n=3)
    horizons = dict(zip(("Top <&>", "Base"), world.horizons.values(), strict=True))
    return changed(gs.Scene(horizons, world.faults, world.box))
