"""Models at the edge of what has a thickness: pinched zones, slivers, coinciding contacts.

Each is a legal model. Every measure and every picture of it is a result, or an error of geosurf
that says why there is none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

from geosurf import Scene, TriSurface
from geosurf.errors import GeosurfError, GeosurfWarning
from geosurf.render.compose import plotted
from geosurf.render.section import draw_section
from tests import strategies

Calls = Iterator[tuple[str, Callable[[], Any]]]

BOX = (0.0, 400.0, 0.0, 300.0, -200.0, -100.0)


def sheet(name: str, height: Callable[[Any], Any]) -> TriSurface:
    """A horizon over the box and around it, whose elevation depends on easting."""
    z = np.broadcast_to(height(np.arange(-50.0, 451.0, 50.0)), (9, 11))
    return strategies.grid(name, z, spacing=50.0, corner=(-50.0, -50.0))


def fault(name: str = "F1", west: float = 150.0, bottom: float = -250.0) -> TriSurface:
    """An upright fault across the box."""
    return strategies.upright(name, west, (-50, 350), (bottom, -50))


def tube(name: str = "F1") -> TriSurface:
    """An upright fault all around a block: it has no strike."""
    ring = [(150.0, 100.0), (250.0, 100.0), (250.0, 200.0), (150.0, 200.0)]
    corners = [(*at, z) for z in (-250.0, -50.0) for at in ring]
    sides = [(k, (k + 1) % 4) for k in range(4)]
    faces = [f for a, b in sides for f in ((a, b, b + 4), (a, b + 4, a + 4))]
    return TriSurface(name, "fault", corners, faces)


def level(name: str, z: float) -> TriSurface:
    return sheet(name, lambda x: z + 0.0 * x)


def wedge(name: str, z: float, start: float, slope: float = 0.1) -> TriSurface:
    """Level until some easting, falling from there."""
    return sheet(name, lambda x: z - slope * np.maximum(0.0, x - start))


def _scene(*horizons: TriSurface, faults: tuple[TriSurface, ...] = (), **options: Any) -> Scene:
    names = {one.name: one for one in horizons}
    return Scene(names, {one.name: one for one in faults}, options.pop("box", BOX), **options)


WORLDS: dict[str, Callable[[], Scene]] = {
    "zone pinched in half": lambda: _scene(level("A", -150.0), wedge("B", -150.0, 200.0)),
    "zone pinched at a fault": lambda: _scene(
        level("A", -150.0), wedge("B", -150.0, 150.0), level("C", -180.0), faults=(fault(),)
    ),
    "zone of no thickness": lambda: _scene(level("A", -150.0), level("B", -150.0)),
    "zone as thin as a digit": lambda: _scene(level("A", -150.0), level("B", -150.0 - 2.0**-44)),
    "zone that pinches to a line": lambda: _scene(
        level("A", -150.0), sheet("B", lambda x: -150.0 - 0.1 * abs(x - 200.0))
    ),
    "one horizon": lambda: _scene(level("A", -150.0)),
    "no horizon": lambda: Scene({}, {"F1": fault()}, BOX),
    "no horizon and no fault inside": lambda: Scene({}, {"F1": fault(west=900.0)}, BOX),
    "horizon on the lid": lambda: _scene(level("A", BOX[5]), level("B", -150.0)),
    "fault on a wall": lambda: _scene(level("A", -150.0), faults=(fault(west=0.0),)),
    "fault that ends on the horizon": lambda: _scene(
        level("A", -150.0), level("B", -170.0), faults=(fault(bottom=-150.0),)
    ),
    "thin box": lambda: _scene(
        level("A", -150.0), level("B", -170.0), faults=(fault(),),
        box=(149.0, 151.0, 0.0, 300.0, -200.0, -100.0),
    ),
    "flat box": lambda: _scene(
        level("A", -150.0), faults=(fault(),), box=(0.0, 400.0, 0.0, 300.0, -150.001, -149.999)
    ),
    "far away": lambda: _scene(
        *(TriSurface(n, "horizon", s.vertices + np.array([5e5, 6e6, 0.0]), s.triangles)
          for n, s in (("A", level("A", -150.0)), ("B", wedge("B", -150.0, 200.0)))),
        box=(5e5, 5e5 + 400.0, 6e6, 6e6 + 300.0, -200.0, -100.0),
    ),
    "sliver beside a fault": lambda: _scene(
        level("A", -150.0), faults=(fault("F1"), fault("F2", 150.0 + 2.0**-40))
    ),
    "two faults in one": lambda: _scene(level("A", -150.0), faults=(fault("F1"), fault("F2"))),
    "contact in a horizon": lambda: _scene(
        level("A", -150.0), level("B", -170.0), contacts={"OWC": -150.0, "FWL": -170.0}
    ),
    "contact in a pinched zone": lambda: _scene(
        level("A", -150.0), wedge("B", -150.0, 200.0), contacts={"GOC": -155.0, "OWC": -160.0}
    ),
    "area of interest on a fault": lambda: _scene(
        level("A", -150.0), level("B", -170.0), faults=(fault(),),
        aoi=[(150.0, 0.0), (400.0, 0.0), (400.0, 300.0), (150.0, 300.0)],
    ),
    "level fault": lambda: _scene(
        level("A", -150.0), faults=(level("F1", -170.0).renamed("F1", "fault"),)
    ),
    "level fault in a horizon": lambda: _scene(
        level("A", -150.0), faults=(level("F1", -150.0).renamed("F1", "fault"),)
    ),
    "fault like a tube": lambda: _scene(level("A", -150.0), level("B", -170.0), faults=(tube(),)),
    "crossing horizons": lambda: _scene(
        level("A", -150.0), sheet("B", lambda x: -150.0 - 0.1 * (x - 200.0)), faults=(fault(),)
    ),
}  # fmt: skip


def measures(scene: Scene) -> Calls:
    """All that can be asked about a model, by name."""
    yield "units", lambda: scene.units.table
    yield "volumes", lambda: scene.volumes
    yield "check", lambda: scene.check()
    yield "explain", lambda: scene.explain()
    step = (scene.box[1] - scene.box[0]) / 20.0
    for zone in dict.fromkeys(unit.zone for unit in scene.units.values()):
        for kind in ("isochore", "isopach"):
            yield f"{kind} {zone}", lambda z=zone, k=kind: scene.thickness(z, step, kind=k)
    for unit in scene.units.values():
        if unit.contact:
            yield (
                f"thickness {unit.name}",
                lambda u=unit: scene.thickness(u.zone, 50.0, contact=u.contact),
            )
    for name in (*scene.horizon_names, *scene.fault_names):
        yield f"orientation {name}", lambda n=name: scene.orientation(n)
    for name in scene.horizon_names:
        yield f"fault polygons {name}", lambda n=name: scene.fault_polygons(n)
        for other in scene.fault_names:
            yield f"throw {name} {other}", lambda n=name, o=other: scene.throw(n, o)
            for side in (None, "+", "-"):
                yield (
                    f"cutoffs {name} {other} {side}",
                    lambda n=name, o=other, s=side: scene.cutoffs(n, o, s),
                )
    for name in scene.fault_names:
        yield f"juxtaposition {name}", lambda n=name: scene.juxtaposition(n, "all")
        yield f"allan {name}", lambda n=name: scene.allan(n)
    for row, line in enumerate(lines_of(scene)):
        yield f"section {row}", lambda at=line: scene.section(at)


def lines_of(scene: Scene) -> list[list[tuple[float, float]]]:
    """Lines of sections: through all, along walls and edges, outside, from corner to corner."""
    w, e, s, n = scene.box[:4]
    x, y = 0.5 * (w + e), 0.5 * (s + n)
    upright = [[(at, s), (at, n)] for at in (w, w + 0.375 * (e - w), x)]
    level = [[(w, at), (e, at)] for at in (s, y)]
    odd = [[(w, s), (e, n)], [(w, y), (x, y), (x, n)], [(x, y), (x + 1e-9, y)], [(e, s), (w, s)]]
    return [*upright, *level, *odd, [(w - 1.0, s), (w - 1.0, n)]]


def foreign(calls: Calls) -> list[str]:
    """What ends by an error that is not of geosurf, each as one sentence."""
    found = []
    for name, call in calls:
        try:
            call()
        except GeosurfWarning:  # of faults that are left out: once, then the call is answered
            call()
        except GeosurfError as error:
            if error.exit_code == 4:
                found.append(f"{name}: {type(error).__name__}: {error}")
        except Exception as error:
            found.append(f"{name}: {type(error).__name__}: {error}")
    return found


# of a world whose fault is left out; its warning has a test of its own
pytestmark = pytest.mark.filterwarnings("ignore::geosurf.errors.GeosurfWarning")
PINCHED = [name for name in WORLDS if "pinched" in name or "crossing" in name]


@cache
def scene_of(world):
    return WORLDS[world]()


@pytest.mark.parametrize("world", WORLDS)
def test_every_measure_is_a_result_or_an_error_of_geosurf(world):
    assert foreign(measures(scene_of(world))) == []


@pytest.mark.parametrize("world", PINCHED)
def test_sections_along_a_zone_of_no_thickness_are_drawn_without_it(world, tmp_path):
    scene, path = scene_of(world), tmp_path / "s.png"
    calls = (
        (
            str(line),
            lambda at=line: plotted(draw_section, scene.section(at), path=path, size=(400, 300)),
        )
        for line in lines_of(scene)[:2]
    )
    assert foreign(calls) == []
