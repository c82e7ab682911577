"""No crossing that rounding makes is missed by the shortlist, and none is left after the repair."""

from __future__ import annotations

import pytest

from geosurf import build_walls, rebuild_surfaces
from geosurf.errors import RoundingError
from geosurf.rebuild import repair
from tests.carve.plane_worlds import plane_world
from tests.rebuild.crossings import FAMILIES, check


@pytest.mark.parametrize("family", list(FAMILIES))
@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_missed_and_nothing_is_left(family, seed):
    assert not {"missed", "left", "refused"} & set(check(family, seed))


def test_a_line_that_moves_along_itself_is_moved_again(monkeypatch):
    """The diagonal of a fault passes by an edge of the box, and still does after the first draw."""
    world = plane_world(3396)
    given = [*world.surfaces, *build_walls(world.box)]
    assert rebuild_surfaces(given).report["largest_move"] < 1e-4
    monkeypatch.setattr(repair, "DRAWS", 1)
    with pytest.raises(RoundingError, match="float64 cannot represent"):
        rebuild_surfaces(given)
