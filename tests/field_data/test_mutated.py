"""A few of the files of `mutated`, and those in which it found something."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest

from geosurf.errors import FormatError
from tests.field_data import mutated, mutations
from tests.messages import refused

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is measured on Linux")


@pytest.fixture(scope="module")
def files():
    """Good files of all formats, read once."""
    with tempfile.TemporaryDirectory() as name:
        found = mutations.whole_files(Path(name))
        mutated.load_all(found, Path(name))
    return found


@pytest.mark.parametrize("seed", range(24))
def test_mutated_files_are_refused_by_name_or_read(tmp_path, files, seed):
    name, data = mutations.case_of(seed, files)
    (tmp_path / name).write_bytes(data)
    word, why, _ = mutated.read_apart(tmp_path / name)
    assert word in ("right", "refused") or " in " in word, why


BOMBS = {
    # so many nodes stay in the file, which has to have them
    "shape of HDF5": ("horizon.nc", mutations.hdf5_bomb, (0,), "only 0 of its 40000 chunks"),
    "chunk of HDF5": ("horizon.nc", mutations.hdf5_bomb, (1,), "needs"),
    "linked HDF5": ("horizon.nc", mutations.hdf5_bomb, (2,), "another file"),
    "virtual HDF5": ("horizon.nc", mutations.hdf5_bomb, (4,), "in other files"),
    "packed chunk": ("horizon.nc", mutations.packed_chunk_bomb, (), "unpacks to more"),
    "entities": ("a.vtp", mutations.xml_bomb, (0,), "declares a document"),
    "one array often": ("a.vtp", mutations.xml_bomb, (2,), "needs"),
}


class Large:
    """Chooses the largest; first, if one is given, the kind of a bomb."""

    def __init__(self, *kinds: int) -> None:
        self.kinds = list(kinds)

    def integers(self, low, high=None):
        return self.kinds.pop() if self.kinds else (low if high is None else high) - 1

    def choice(self, some):
        return max(some)


@pytest.mark.parametrize("name", BOMBS)
def test_what_announces_too_much_is_refused_with_its_reason(tmp_path, name):
    file, make, kinds, reason = BOMBS[name]
    path = tmp_path / file
    path.write_bytes(make(Large(*kinds)))
    refused(FormatError, reason, mutations.read, path)


def test_a_block_that_unpacks_to_more_than_it_announces_is_refused(tmp_path):
    path = tmp_path / "a.vtp"
    good = mutations.packed_vtp(np.zeros(12), 2)
    path.write_bytes(good)
    assert mutations.read(path).n_vertex == 4
    for around, zeros in ((2, 0), (1, 1 << 20)):
        path.write_bytes(mutations.packed_vtp(np.zeros(12), 2, zeros, around))
        refused(FormatError, r"a\.vtp", mutations.read, path)


def test_the_limit_can_be_raised(tmp_path, monkeypatch):
    path = tmp_path / "horizon.nc"
    with h5py.File(path, "w") as file:
        for key in ("northing", "easting"):
            file[key] = np.arange(3000.0)
            file[key].make_scale(key)
        data = file.create_dataset("elevation", (3000, 3000), "f4", chunks=(500, 500), fillvalue=1)
        mutations.declared(file, data)
    refused(FormatError, r"3000 x 3000 values needs 343 MB.*READ_MEMORY=1GB", mutations.read, path)
    monkeypatch.setenv("GEOSURF_READ_MEMORY", "1GB")
    assert mutations.read(path).shape == (3000, 3000)
