"""A few of the cases of `spoiled`, and those in which it found something."""

from __future__ import annotations

import warnings

import pytest

from tests.real import spoiled

FOUND = {
    584: "a box of 1e300 m made products overflow",
    823: "so did a fault",
    1723: "the strike of a fault 1e-310 m high underflowed",
}


@pytest.mark.parametrize("seed", [*range(40), *FOUND])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # h5netcdf closes
def test_spoiled_inputs_are_refused_by_name_or_used_rightly(seed):
    word, why = spoiled.what_becomes_of(seed)
    assert word in ("right", "refused"), f"{why}; {FOUND.get(seed, '')}"


def test_whole_inputs_are_right(tmp_path, monkeypatch):
    """Nothing that is not spoiled is refused: each file, the scenario, the objects."""
    for path in spoiled.whole_files(tmp_path):
        spoiled.use(spoiled.read(path))
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
