"""Wrong things for what reads, draws, reports, writes and measures, and for known worlds.

Rows of `wrong.row`, by the name of what is called.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

import geosurf as gs
from geosurf.render.compose import plotted
from geosurf.render.isochores import draw_thickness
from geosurf.scene.plots import ScenePlots
from tests.invalid_input import wrong
from tests.invalid_input.wrong import FLAGS, row

SIZES = ["abc", 5, (0, 0), (-1, 5), (np.nan, 5), ("a", "b"), (1, 2, 3), [], {}]
PICTURE = {"path": "no/x.png"}


def view(scene, **words):
    return ScenePlots(scene).view(**words)


SHOWING = {
    "read_horizon": row({}, path=wrong.PATHS),
    "read_fault": row({"path": "F1.ts"}, path=wrong.PATHS, format=wrong.WORDS),
    "read_points": row({}, path=wrong.PATHS),
    "read_polygons": row({}, path=wrong.PATHS),
    "read_tops": row({"positive": "up"}, path=wrong.PATHS),
    "read_wells": row({"positive": "up"}, path=wrong.PATHS),
    "read_units": row({}, path=wrong.PATHS),
    "info": row({}, path=[v for v in wrong.PATHS if v != "x"]),
    "mesh_units": row(lambda g: {"units": g.units},
                      units=wrong.things, size=[*wrong.LENGTHS, 0]),
    "build_grid": row(
        lambda g: {"scene": g.scene}, scene=wrong.things, cell=["abc", None, (1,), (0, 5), {}],
        layers=["abc", None, 0, -3, 1.5, {"Nope": 3}, {"Top/Base": 0}],
    ),
    "fault_multipliers": row(
        lambda g: {"scene": g.scene, "grid": gs.build_grid(g.scene, cell=1000, layers=1),
                   "vshale": 0.3, "permeability": 1.0},
        scene=wrong.things, grid=wrong.things,
        permeability=["abc", None, 0.0, -3, {"Nope": 3}, {"Top/Base": "x"}, {}, [1.0, 2.0]],
    ),
    "render_grid_section": row(PICTURE, grid=wrong.things),
    "reproject": row(lambda g: {"obj": g.top, "crs": "EPSG:32631"},
                     obj=wrong.things, crs=[None, 5, [], object()]),
    "to_xtgeo": row({}, obj=lambda g: wrong.things(g)[:8]),
    "to_geodataframe": row({}, obj=lambda g: wrong.things(g)[:-1]),
    "run_scenario": row({"out": "no"}, path=wrong.PATHS),
    "write": row(
        lambda g: {"obj": g.f1, "path": "no/x.ts"},
        obj=lambda g: ["Top", None, 5, [], {}, object(), g.top],
        path=[v for v in wrong.PATHS if v != "no/such.vtp"], name=[["F1"], {}, object(), 1.5],
    ),
    "show": row(
        lambda g: {"thing": g.f1}, lambda thing, **words: gs.show(thing, **words),
        thing=lambda g: [*wrong.things(g)[:6], [g.top], object()],
        max_triangle=["abc", None, 0, -1, np.nan, [], {}],
    ),
    "show_progress": row({}, on=[None, 0, "on", [], {}, object()]),
    "view": row(
        lambda g: {"scene": g.scene, "size": (400, 250), "show": "units", **PICTURE}, view,
        path=wrong.PATHS[1:], size=[*SIZES, None],
        view=[*wrong.WORDS, None, (1, 2, 3), (0, 91), ("a", 2), (np.nan, 0), [None, None], 5.0],
        exaggeration=[*wrong.LENGTHS, 0], show=["abc", 5, None, [5], ["abc"], [None], object()],
        exploded=[*wrong.LENGTHS, None], clip=FLAGS, zoom=[*wrong.LENGTHS, 0, 1e9],
        only=[5, ["Nope"], "Nope", [None], object(), {"a": 1}],
        colour_by=["abc", 5, [], [1.0], {"Nope": 1.0}, {}, object(), [np.nan] * 6, [[1.0]]],
        title=[5, b"x", ["a"]], style=["dark", 5, {}], overlay=["x", 5, {}],
    ),
    "PictureStyle": row(
        {}, theme=[*wrong.WORDS, None], font=wrong.WORDS, colour_map=wrong.WORDS,
        colours=["red", 5, [], {"Top": "tael"}, {"Top": 5}, {"Top": (2, 0, 0)}, {5: "red"}],
    ),
    "PictureOverlay": row(
        {},
        wells=["abc", 5, [], {"W": 5}, {"W": "x"}, {"W": [1, 2, 3]}, {5: [[0, 0, 0]]}, None],
        points=[{"P": v} for v in (5, None, "x", [[0, 0]], [[0, 0, np.nan]], [], {}, object(),
                                   [[1j, 0, 0]])],
    ),
    "render_place": row(
        lambda g: {"surfaces": g.surfaces, "place": (0, 0, 0), **PICTURE},
        surfaces=lambda g: [v for v in wrong.things(g) if not isinstance(v, xr.Dataset)],
        place=["abc", None, 5, (0, 1), (0, 1, np.nan), ("a", "b", "c"), {}, (1j, 0, 0)],
        reach=[*wrong.LENGTHS, 0],
    ),
    "drawn_thickness": row(
        lambda g: {"of": g.thickness, **PICTURE},
        lambda of, **words: plotted(draw_thickness, of, **words),
        of=lambda g: [g.thickness * np.nan, g.thickness[:, :1]],
    ),
    "drawn_allan": row(
        lambda g: {"scene": g.scene, **PICTURE},
        lambda scene, **words: ScenePlots(scene).allan("F1", **words),
        seal=lambda g: [*(v for v in wrong.things(g) if v is not None), g.table,
                        xr.Dataset({"sgr": 0.2}, attrs={"fault": "F2"})],
    ),
    "report_scene": row(
        lambda g: {"scene": g.scene, "folder": "no", "pictures": {}}, scene=wrong.things,
        folder=[None, 5, "", b"x", object()], certificate=[5, "abc", []],
        pictures=["abc", 5, [], {"x": 5}, {"x": None}, {"x": "no.png"}],
        regions=["abc", 5, [], {"x": 5}, {"x": (1,)}, {"x": ("a", "b")}, {"x": (np.nan, "b")}],
    ),
    **{
        f"synthetic.{name}": row(
            {}, n=["abc", 5.5, None, 0, -3, np.nan, True, []],
            offset=["abc", 5, None, (0, 1), (np.nan, 0, 0), ("a", "b", "c")],
        )
        for name in gs.synthetic.__all__
        if callable(getattr(gs.synthetic, name))
        and name not in ("World", "Fault", "FieldTruth", "field_export")
    },
}  # fmt: skip
