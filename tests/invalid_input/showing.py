"""Wrong things for what reads, draws, reports, writes and measures, and for known worlds.

What is called: (with what, wrong things): a list, or a function of `g`, the model
of test_wrong_things.py.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

import geosurf as gs
from geosurf import measure
from geosurf.render.allan import draw_allan
from geosurf.render.compose import plotted
from geosurf.render.isochores import draw_thickness
from geosurf.render.section import draw_section
from geosurf.scene.plots import ScenePlots
from tests.invalid_input import wrong
from tests.invalid_input.building import FLAGS

LINE = [np.array([[0.0, 0, 0], [0, 10, 0]])]
SIZES = ["abc", 5, (0, 0), (-1, 5), (np.nan, 5), ("a", "b"), (1, 2, 3), [], {}]
SHOWING = {
    "read_horizon": (lambda g, v: gs.read_horizon(v), wrong.PATHS),
    "read_fault": (lambda g, v: gs.read_fault(v), wrong.PATHS),
    "read_points": (lambda g, v: gs.read_points(v), wrong.PATHS),
    "read_polygons": (lambda g, v: gs.read_polygons(v), wrong.PATHS),
    "read_tops": (lambda g, v: gs.read_tops(v, positive="up"), wrong.PATHS),
    "read_wells": (lambda g, v: gs.read_wells(v, positive="up"), wrong.PATHS),
    "read_fault.format": (lambda g, v: gs.read_fault("F1.ts", format=v), wrong.WORDS),
    "read_units": (lambda g, v: gs.read_units(v), wrong.PATHS),
    "info": (lambda g, v: gs.info(v), [v for v in wrong.PATHS if v != "x"]),
    "mesh_units": (lambda g, v: gs.mesh_units(v), wrong.things),
    "mesh_units.size": (lambda g, v: gs.mesh_units(g.units, size=v), [*wrong.LENGTHS, 0]),
    "build_grid": (lambda g, v: gs.build_grid(v), wrong.things),
    "build_grid.cell": (lambda g, v: gs.build_grid(g.scene, cell=v),
                        ["abc", None, (1,), (0, 5), {}]),
    "build_grid.layers": (lambda g, v: gs.build_grid(g.scene, layers=v),
                          ["abc", None, 0, -3, 1.5, {"Nope": 3}, {"Top/Base": 0}]),
    "fault_multipliers": (
        lambda g, v: gs.fault_multipliers(v, None, vshale=0.3, permeability=1.0), wrong.things,
    ),
    "fault_multipliers.grid": (
        lambda g, v: gs.fault_multipliers(g.scene, v, vshale=0.3, permeability=1.0), wrong.things,
    ),
    "fault_multipliers.permeability": (
        lambda g, v: gs.fault_multipliers(
            g.scene, gs.build_grid(g.scene, cell=1000, layers=1), vshale=0.3, permeability=v
        ),
        ["abc", None, 0.0, -3, {"Nope": 3}, {"Top/Base": "x"}, {}, [1.0, 2.0]],
    ),
    "render_grid_section": (lambda g, v: gs.render_grid_section(v, "no/x.png"), wrong.things),
    "reproject": (lambda g, v: gs.reproject(v, "EPSG:32631"), wrong.things),
    "reproject.crs": (lambda g, v: gs.reproject(g.top, v), [None, 5, [], object()]),
    "to_xtgeo": (lambda g, v: gs.to_xtgeo(v), lambda g: wrong.things(g)[:8]),
    "to_geodataframe": (lambda g, v: gs.to_geodataframe(v), lambda g: wrong.things(g)[:-1]),
    "run_scenario": (lambda g, v: gs.run_scenario(v, "no"), wrong.PATHS),
    "write": (lambda g, v: gs.write(v, "no/x.vtp"),
              lambda g: ["Top", None, 5, [], {}, object(), g.top]),
    "write.path": (lambda g, v: gs.write(g.f1, v), [v for v in wrong.PATHS if v != "no/such.vtp"]),
    "write.name": (lambda g, v: gs.write(g.f1, "no/x.ts", name=v), [["F1"], {}, object(), 1.5]),
    "show": (lambda g, v: gs.show(v), lambda g: [*wrong.things(g)[:6], [g.top], object()]),
    "show.max_triangle": (lambda g, v: gs.show(g.f1, max_triangle=v),
                          ["abc", None, 0, -1, np.nan, [], {}]),
    "show_progress": (lambda g, v: gs.show_progress(v), [None, 0, "on", [], {}, object()]),
    "view": (lambda g, v: ScenePlots(v).view(path="no/x.png"), wrong.things),
    "view.path": (lambda g, v: ScenePlots(g.scene).view(path=v, size=(400, 250)), wrong.PATHS[1:]),
    "view.view": (lambda g, v: ScenePlots(g.scene).view(v, path="no/x.png"), [*wrong.WORDS, None]),
    "view.size": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", size=v), [*SIZES, None]),
    "view.exaggeration": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", exaggeration=v),
                          [*wrong.LENGTHS, 0]),
    "view.show": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", show=v),
                  ["abc", 5, None, [5], ["abc"], [None], object()]),
    "view.exploded": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", exploded=v, show="units"),
        [*wrong.LENGTHS, None],
    ),
    "view.clip": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", clip=v), FLAGS),
    "view.view.angles": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", view=v),
                         [(1, 2, 3), (0, 91), ("a", 2), (np.nan, 0), [None, None], 5.0]),
    "view.zoom": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", zoom=v),
                  [*wrong.LENGTHS, 0, 1e9]),
    "view.only": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", only=v),
                  [5, ["Nope"], "Nope", [None], object(), {"a": 1}]),
    "view.colour_by": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", colour_by=v, show="units"),
        ["abc", 5, [], [1.0], {"Nope": 1.0}, {}, object(), [np.nan] * 6, [[1.0]]],
    ),
    "view.title": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", title=v),
                   [5, b"x", ["a"]]),
    "view.style": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", style=v),
                   ["dark", 5, {}]),
    "view.overlay": (lambda g, v: ScenePlots(g.scene).view(path="no/x.png", overlay=v),
                     ["x", 5, {}]),
    "PictureStyle": (lambda g, v: gs.PictureStyle(v), [*wrong.WORDS, None]),
    "PictureStyle.font": (lambda g, v: gs.PictureStyle(font=v), wrong.WORDS),
    "PictureStyle.colours": (
        lambda g, v: gs.PictureStyle(colours=v),
        ["red", 5, [], {"Top": "tael"}, {"Top": 5}, {"Top": (2, 0, 0)}, {5: "red"}],
    ),
    "PictureStyle.colour_map": (lambda g, v: gs.PictureStyle(colour_map=v), wrong.WORDS),
    "PictureOverlay": (
        lambda g, v: gs.PictureOverlay(v),
        ["abc", 5, [], {"W": 5}, {"W": "x"}, {"W": [1, 2, 3]}, {5: [[0, 0, 0]]}, None],
    ),
    "PictureOverlay.points": (
        lambda g, v: gs.PictureOverlay(points={"P": v}),
        [5, None, "x", [[0, 0]], [[0, 0, np.nan]], [], {}, object(), [[1j, 0, 0]]],
    ),
    "render_place": (lambda g, v: gs.render_place(v, (0, 0, 0), "no/x.png"),
                     lambda g: [v for v in wrong.things(g) if not isinstance(v, xr.Dataset)]),
    "render_place.place": (
        lambda g, v: gs.render_place(g.surfaces, v, "no/x.png"),
        ["abc", None, 5, (0, 1), (0, 1, np.nan), ("a", "b", "c"), {}, (1j, 0, 0)],
    ),
    "render_place.reach": (lambda g, v: gs.render_place(g.surfaces, (0, 0, 0), "no/x.png", reach=v),
                           [*wrong.LENGTHS, 0]),
    "drawn_thickness": (lambda g, v: plotted(draw_thickness, v, path="no/x.png"),
                        lambda g: [*wrong.things(g), g.top, g.thickness * np.nan, g.table]),
    "drawn_thickness.polygons": (
        lambda g, v: plotted(draw_thickness, g.thickness, path="no/x.png", polygons=v),
        ["abc", 5, [], {"Top": 5}, {"Top": "x"}, {"Top": xr.Dataset()}, object()],
    ),
    "drawn_allan": (lambda g, v: plotted(draw_allan, v, g.table, path="no/x.png"),
                    lambda g: [*wrong.things(g), g.table]),
    "allan_diagram.table": (lambda g, v: plotted(draw_allan, g.allan, v, path="no/x.png"),
                            lambda g: [*wrong.things(g), g.allan]),
    "allan_diagram.zones": (
        lambda g, v: plotted(draw_allan, g.allan, g.table, path="no/x.png", zones=v),
        [5, None, object()],
    ),
    "drawn_section": (lambda g, v: plotted(draw_section, v, path="no/x.png"),
                      lambda g: [*wrong.things(g), g.allan]),
    "report_scene": (lambda g, v: gs.report_scene(v, "no"), wrong.things),
    "report_scene.folder": (lambda g, v: gs.report_scene(g.scene, v, {}),
                            [None, 5, "", b"x", object()]),
    "report_scene.pictures": (lambda g, v: gs.report_scene(g.scene, "no", v),
                              ["abc", 5, [], {"x": 5}, {"x": None}, {"x": "no.png"}]),
    "report_scene.certificate": (lambda g, v: gs.report_scene(g.scene, "no", {}, certificate=v),
                                 [5, "abc", []]),
    "report_scene.regions": (
        lambda g, v: gs.report_scene(g.scene, "no", {}, regions=v),
        ["abc", 5, [], {"x": 5}, {"x": (1,)}, {"x": ("a", "b")}, {"x": (np.nan, "b")}],
    ),
    "separation": (lambda g, v: measure.separation(v, LINE, 90.0), [[v] for v in wrong.ARRAYS]),
    "separation.dip_azimuth": (lambda g, v: measure.separation(LINE, LINE, v),
                               [*wrong.NUMBERS, None]),
    "separation.start": (lambda g, v: measure.separation(LINE, LINE, 90.0, start=v), wrong.NUMBERS),
    "measure.patches": (lambda g, v: measure.allan_diagram(v, g.units, "F1"), wrong.things),
    "measure.units": (lambda g, v: measure.juxtaposition_table(g.patches, v, "F1"), wrong.things),
    "thickness_map": (lambda g, v: measure.thickness_map(v, "Top/Base"), wrong.things),
    "wall_lines": (lambda g, v: measure.wall_lines(g.patches, g.units, "Top", "F1", v),
                   [5, -1, "x", None]),
    **{
        f"synthetic.{name}.{key}": (
            lambda g, v, name=name, key=key: getattr(gs.synthetic, name)(**{key: v}),
            ["abc", 5.5, None, 0, -3, np.nan, True, []] if key == "n"
            else ["abc", 5, None, (0, 1), (np.nan, 0, 0), ("a", "b", "c")],
        )
        for name in gs.synthetic.__all__
        if callable(getattr(gs.synthetic, name))
        and name not in ("World", "Fault", "FieldTruth", "field_export")
        for key in ("n", "offset")
    },
}  # fmt: skip
