"""A few of the cases of `spoiled`, and those in which it found something."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import geosurf as gs
from tests.field_data import spoiled

# part of the field, or some faults, are left out on purpose; the warnings have tests of their own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")

FOUND = {
    584: "a box of 1e300 m made products overflow",
    823: "so did a fault",
    1723: "the strike of a fault 1e-310 m high underflowed",
    402800: "squares of sticks 1e308 m long overflowed",
    409307: "the corner of a triangle was no number of 64 bits",
    949237: "points of a .vtp did not come in threes",
}


@pytest.mark.parametrize("seed", [*range(40), *FOUND])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # h5netcdf closes
def test_spoiled_inputs_are_refused_by_name_or_used_rightly(seed):
    word, why = spoiled.what_becomes_of(seed)
    assert word in ("right", "refused"), f"{why}; {FOUND.get(seed, '')}"


def assert_written_is_read(name, found):
    """A file that was written holds what was written, to the digits that its format keeps."""
    top, f1 = spoiled.horizon(), spoiled.fault()
    if name.startswith("written_horizon"):
        np.testing.assert_allclose(found.values, top.values, atol=1e-4)
        np.testing.assert_array_equal(found.easting, top.easting)
        np.testing.assert_array_equal(found.northing, top.northing)
    elif name == "written_fault.nc":
        for part in ("easting", "northing", "elevation"):
            np.testing.assert_array_equal(found[part].values, f1[part].values)
    elif name.startswith("written_fault"):
        want = gs.triangulate_fault(f1, name="F1")
        np.testing.assert_array_equal(corners(found), corners(want))
    elif isinstance(found, gs.TriSurface):  # the plane of `spoiled.texts`
        assert (found.n_triangle, found.bounds) == (2, (2.0, 4.0, -1.0, 7.0, -9.0, 9.0))


def corners(surface):
    """Corners of all triangles, sorted: whatever the order in which a format keeps them."""
    return np.sort(surface.vertices[surface.triangles].reshape(-1, 9), axis=0)


def test_whole_inputs_are_right(tmp_path, monkeypatch):
    """Nothing that is not spoiled is refused: each file, the scenario, the objects."""
    for path in spoiled.whole_files(tmp_path):
        found = spoiled.read(path)
        assert_written_is_read(path.name, found)
        spoiled.use(found)
    monkeypatch.setattr(spoiled, "VALUES", ())

    class Never:
        """Chooses nothing."""

        def integers(self, low, high=None):
            return 0

        def random(self):
            return 1.0

        def choice(self, some, n=1):
            return ["nothing"] * n

    with warnings.catch_warnings(action="error"):
        spoiled.spoiled_scenario(Never(), tmp_path)
        monkeypatch.setattr(spoiled, "DAMAGES", {"nothing": lambda a: a})
        Never.random = lambda self: 0.0
        spoiled.spoiled_object(Never(), tmp_path)
