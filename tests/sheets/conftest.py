"""Truth worlds, torn once for all tests."""

from __future__ import annotations

from functools import cache

import pytest

import geosurf as gs


@pytest.fixture(scope="session")
def torn_world():
    """Function of a kind of world: (world, sheet); grids, or points where sheets overlap."""

    @cache
    def make(kind: str, points: bool = False, **options):
        chosen = dict(options)
        trim = chosen.pop("trim", 2.25)
        world = gs.synthetic.torn(kind, **chosen)
        data = world.truth["points"] if points else world.horizons["Top"]
        return world, gs.tear_horizon(data, world.faults, name="Top", trim=trim, positive="up")

    return make
