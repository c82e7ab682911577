"""Two faults that cross closer to a horizon than their throws leave two wedges without it."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import OpenUnitError

BOX = (0.0, 3000.0, 0.0, 2000.0, -1950.0, -1500.0)


def fault(name, cotangent):
    """A plane that strikes north through (1500, -1720), down to 2000 m and up to 1400 m."""
    corners = [
        (1500.0 + (-1720.0 - z) * cotangent, y, z)
        for y, z in ((-900, -2000), (2900, -2000), (2900, -1400), (-900, -1400))
    ]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [0, 2, 3]])


def scene(throws):
    x, y = np.arange(-200.0, 3201.0, 100.0), np.arange(-200.0, 2201.0, 100.0)
    flat = xr.DataArray(
        np.full((len(y), len(x)), -1680.0),
        {"northing": y, "easting": x}, ("northing", "easting"), attrs={"positive": "up"},
    )  # fmt: skip
    faults = {"F1": fault("F1", 0.6), "F2": fault("F2", -0.6)}
    sheet = gs.throw_horizon(
        flat.assign_attrs(units="m"), faults, dict(zip(faults, throws, strict=True)), name="Top",
        hanging_wall=0.5,
    )  # fmt: skip
    return gs.Scene({"Top": sheet}, {f.name: f for f in sheet.faults}, BOX)


def test_the_remedy_of_a_crossing_near_a_horizon_works():
    """The wedge moves by 50 m, and the crossing is 40 m below; with half the throws it has room."""
    with pytest.raises(OpenUnitError, match="no room for it: reduce the throws, or move a fault"):
        scene((60.0, 40.0)).units  # noqa: B018
    near = scene((30.0, 20.0))
    assert len(near.units) >= 6
    assert near.check().ok
