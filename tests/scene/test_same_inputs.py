"""Which inputs count as the same, and which do not."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from geosurf import FaultSticks, Scene, TriSurface
from geosurf.scene.memory import fingerprint
from tests.scene.small import level
from tests.strategies import BOX


@pytest.mark.parametrize("kind", ["units of an axis", "sticks", "vertices", "stick of a vertex"])
def test_inputs_that_differ_in_little_are_not_one(kind):
    """Each of these was once taken for an input that a scene had seen before."""
    quad = np.array([(1.0, -1, 9), (1, -1, -5), (1, 5, 9), (1, 5, -5)])
    faces = [(0, 1, 2), (1, 3, 2)]
    if kind == "units of an axis":
        one = xr.DataArray(
            np.zeros((2, 2)), dims=("northing", "easting"),
            coords={"northing": [0.0, 9.0], "easting": [0.0, 9.0]},
        )  # fmt: skip
        two = one.assign_coords(easting=one.easting.assign_attrs(units="ft"))
    elif kind == "sticks":
        line = np.vstack([quad[:2], quad[:1] + 3.0, quad[2:]])
        one, two = (FaultSticks("F1", (line[:n], line[n:])) for n in (2, 3))
    elif kind == "vertices":
        one, two = (quad, faces), (quad + 1.0, faces)
    else:
        sticks = [{"stick": [0, 0, 1, 1]}, {"stick": [0, 1, 2, 3]}]
        one, two = (TriSurface("F1", "fault", quad, faces, vertex_data=d) for d in sticks)
    assert fingerprint(one) != fingerprint(two)


def test_an_answer_is_never_that_of_another_question():
    """Nothing is told by its identity, which a later object may have; nor by words run together."""
    scene = Scene({"Top": level(3), "Base": level(1)}, {}, BOX)

    class Grid:
        """Has coordinates as a map needs them, and is no xarray object."""

        def __init__(self, *east: float) -> None:
            self.coords = {
                name: xr.DataArray(np.array(at), dims=name)
                for name, at in (("northing", [1.0, 2.0]), ("easting", east))
            }

    def eastings(grid: Grid) -> list[float]:
        return scene.thickness("Top/Base", grid).easting.values.tolist()

    for k in range(20):  # each is gone before the next is made
        assert eastings(Grid(1.0 + k / 8, 3.75)) == [1.0 + k / 8, 3.75]
    grid = Grid(1.0, 2.0)
    assert eastings(grid) == [1.0, 2.0]
    grid.coords["easting"][:] = [2.5, 3.5]
    assert eastings(grid) == [2.5, 3.5]
