"""A model made by hand that has all that a report asks for."""

from types import SimpleNamespace

import numpy as np
import pytest

from geosurf.model import Certificate, Check, Curves, TriSurface, Unit, Units

BOX = (0.0, 1000.0, 0.0, 1000.0, -300.0, 0.0)


def unit(zone, zone_index, block, volume):
    return Unit(
        name=f"{zone}, {block}",
        zone=zone,
        zone_index=zone_index,
        block=block,
        local=np.zeros((3, 3)),
        origin=np.zeros(3),
        triangles=np.array([[0, 1, 2]]),
        surface_of_triangle=np.zeros(1, dtype=int),
        surface_names=("Top",),
        volume=volume,
        area=1.0,
    )


# the other members that a report asks for, of a model that has nothing to tell there
NOTHING_ELSE = {
    **dict.fromkeys(("warnings", "contacts", "fault_actions", "faults_inside"), ()),
    **dict.fromkeys(("horizons_inside", "horizon_names", "fault_names", "virtual_walls"), ()),
    **dict.fromkeys(("surface", "search", "cutoffs", "thickness", "fault_polygons"), None),
    **dict.fromkeys(
        ("juxtaposition", "allan", "section", "throw", "aoi", "tolerance", "tops", "misfit"), None
    ),
    "sheets": {},
    "volume_error_bound": 0.0,
    "steps": (),
    "render_pictures": lambda *_, **__: {},
    "input_files": {},
    "view_3d": lambda *_: None,
}


@pytest.fixture
def scene():
    return made_by_hand()


def made_by_hand():
    """Two surfaces, two units, one curve."""
    top = TriSurface("Top <&>", "horizon", [[0, 0, -9], [1e3, 0, -9], [0, 1e3, -9]], [[0, 1, 2]])
    fault = TriSurface("F1", "fault", [[5, 0, 0], [5, 1e3, 0], [9, 0, -300]], [[0, 1, 2]])
    line = np.array([[5.0, 0, -9], [5.0, 900.0, -9]])
    pair = np.array([[0, 1]])
    return SimpleNamespace(
        surfaces=(top, fault),
        coverage={top.name: 1.0, fault.name: 0.5},
        curves=Curves(
            names=("Top <&>", "F1"),
            local=line,
            origin=np.zeros(3),
            segments=pair,
            surfaces_of_segment=pair,
            curves=(np.array([0, 1]),),
            surfaces_of_curve=pair,
            closed=np.array([False]),
            cost={"n_pair_tested": 123456},
        ),
        patches=SimpleNamespace(report={"n_cut": 2, "repaired": []}),
        units=Units(
            [unit("above Top", 0, "F1-", 1e8), unit("below Top", 1, "F1+", 2e8)],
            BOX,
            {"open_rim": {"F1": 12.5}},
        ),
        box=BOX,
        check=lambda: Certificate((Check("closed", True, 0.0, "2 of 2 units are closed"),)),
        **NOTHING_ELSE,
    )
