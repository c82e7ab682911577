"""Records are grouped by face, each segment and point once, as sorting with a set does."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from geosurf.kernels.cutting.cut_faces import group_records


def oracle(records):
    """The same by a dictionary: the lowest plane of each face, first and second point."""
    lowest = {}
    for face, one, two, plane in records.tolist():
        key = face, one, two
        lowest[key] = min(lowest.get(key, plane), plane)
    ends = {(face, p) for face, one, two in lowest if two >= 0 for p in (one, two)}
    return [
        (*key, plane) for key, plane in sorted(lowest.items())
        if key[2] >= 0 or key[:2] not in ends
    ]  # fmt: skip


@pytest.mark.parametrize("n_face", [3, 40])  # some hundred records of a face, and a dozen
@pytest.mark.parametrize("seed", range(4))
def test_groups_as_a_dictionary_does(seed, n_face):
    rng = np.random.default_rng(seed)
    records = rng.integers(0, (n_face, 60, 60, 3), (500, 4))
    records[:, 1:3].sort(axis=1)
    alone = rng.random(500) < 0.3
    records[alone, 1], records[alone, 2] = rng.integers(0, 90, alone.sum()), -1
    records[:, 3] -= 1
    found, offsets = group_records(records, 0, n_face + 2, 90)
    assert [tuple(row) for row in found.tolist()] == oracle(records)
    assert (offsets[0], offsets[-1]) == (0, len(found))
    faces = found[:, 0]
    assert [faces[a:b].tolist() for a, b in pairwise(offsets)] == [
        [face] * int((faces == face).sum()) for face in np.unique(faces)
    ]
    parts = [group_records(records, *row, 90)[0] for row in ((0, 2), (2, 2), (2, n_face + 2))]
    assert np.concatenate(parts).tolist() == found.tolist()


def test_no_records():
    found, offsets = group_records(np.empty((0, 4), dtype=np.int64), 0, 3, 5)
    assert len(found) == 0
    assert offsets.tolist() == [0]
