"""A few of the cases of `damages`: each damage of a lattice twice."""

from __future__ import annotations

import numpy as np
import pytest

from geosurf.errors import GeosurfError, InvariantError
from tests.real.damages import LATTICE_DAMAGES, damaged_lattice, meets
from tests.real.test_fuzz import whole

HARMLESS = ("nothing", "falling axes", "a node undefined", "masked", "negative zeros", "float32")


@pytest.mark.parametrize("damage", LATTICE_DAMAGES)
def test_damaged_lattices_are_refused_by_name_or_rebuilt_rightly(damage):
    for seed in range(2):
        rng = np.random.default_rng([seed, len(damage)])
        try:
            answer = meets(damaged_lattice(damage, rng), whole(3, rng))
        except InvariantError:
            raise
        except GeosurfError:
            assert damage not in HARMLESS
            continue
        assert answer.ok, str(answer)
