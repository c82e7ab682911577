"""A few of the cases of `spoiled`, and those in which it found something."""

from __future__ import annotations

import faulthandler
import signal
import time
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


def hang():
    time.sleep(60.0)
    return "right", ""


def crash():
    signal.raise_signal(signal.SIGSEGV)  # of this thread: the watch's may not block it yet
    return "right", ""


def foreign():
    raise ZeroDivisionError("one by none")


def test_children_hand_back_what_they_found_and_hangs_are_not_waited_for():
    assert spoiled.in_a_child(lambda: ("refused", "a\nb")) == ("refused", "a\nb")
    assert spoiled.in_a_child(lambda: spoiled.verdict_of(foreign)) == (
        "wrong", "ZeroDivisionError: one by none"
    )  # fmt: skip
    for case, what in ((hang, "hung"), (crash, "crashed")):
        faulthandler.dump_traceback_later(60.0)  # as a run does for its other cases
        word, why = spoiled.in_a_child(case, seconds=0.2)
        assert word == "wrong"
        assert why.startswith(f"{what} at test_spoiled.py:")


def test_what_a_library_did_is_told_from_what_we_did():
    stack = (
        'Thread 0x1 (most recent call first):\n  File "{}", line 7 in open\n  File "b.py", line 8'
    )
    at = stack.format("/venv/lib/python3/site-packages/h5py/_hl/files.py")
    assert spoiled.at_fault(at, "hung") == ("hung in h5py", "hung at files.py:7")
    for ours in ("/venv/site-packages/numpy/lib/x.py", "/h5py.py", "geosurf/read/netcdf.py"):
        assert spoiled.at_fault(stack.format(ours), "hung")[0] == "wrong"
    assert spoiled.at_fault("", "crashed") == ("wrong", "crashed at ")


def test_files_of_hdf5_are_known_by_their_seeds():
    known = {seed for seed in range(60) if spoiled.goes_to_hdf5(seed)}
    assert known
    assert {seed % 5 for seed in known} <= {0, 2}
    read = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(spoiled, "read", lambda path: read.append(path.suffix))
        patch.setattr(spoiled, "use", lambda found: None)
        for seed in range(60):
            if spoiled.KINDS[seed % 5] is spoiled.spoiled_file:
                read.clear()
                spoiled.what_becomes_of(seed)
                assert (read == [".nc"]) == (seed in known)


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
