"""Two faults that cross closer to a horizon than their throws leave two wedges without it."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import geosurf as gs
from geosurf.errors import OpenUnitError

BOX = (0.0, 3000.0, 0.0, 2000.0, -1950.0, -1500.0)


def fault(name, cotangent, east):
    """A plane that strikes north through (east, -1720), down to 2000 m and up to 1400 m."""
    corners = [
        (east + (-1720.0 - z) * cotangent, y, z)
        for y, z in ((-900, -2000), (2900, -2000), (2900, -1400), (-900, -1400))
    ]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [0, 2, 3]])


def scene(throws, east=1500.0, box=BOX):
    """Two faults; `east`: of the second one at the depth at which the first is at 1500."""
    x, y = np.arange(-200.0, 3201.0, 100.0), np.arange(-200.0, 2201.0, 100.0)
    flat = xr.DataArray(
        np.full((len(y), len(x)), -1680.0),
        {"northing": y, "easting": x}, ("northing", "easting"), attrs={"positive": "up"},
    )  # fmt: skip
    faults = {"F1": fault("F1", 0.6, 1500.0), "F2": fault("F2", -0.6, east)}
    sheet = gs.throw_horizon(
        flat.assign_attrs(units="m"), faults, dict(zip(faults, throws, strict=True)), name="Top",
        hanging_wall=0.5,
    )  # fmt: skip
    return gs.Scene({"Top": sheet}, {f.name: f for f in sheet.faults}, box)


def test_a_crossing_near_a_horizon_is_refused():
    """The wedge moves by 50 m, and the crossing is 40 m below."""
    with pytest.raises(OpenUnitError, match="no room for it: reduce the throws, or move a fault"):
        scene((60.0, 40.0)).units  # noqa: B018


@pytest.mark.parametrize(
    ("throws", "changes", "n_unit"),
    [
        ((30.0, 20.0), {}, 6),  # half the throws have room
        ((60.0, 40.0), {"east": 1620.0}, 6),  # the crossing is 100 m deeper
        ((60.0, 40.0), {"box": (1580.0, *BOX[1:])}, 4),  # east of the crossing
    ],
)
def test_the_remedies_of_a_crossing_near_a_horizon_work(throws, changes, n_unit):
    near = scene(throws, **changes)
    assert len(near.units) >= n_unit
    assert near.check().ok
