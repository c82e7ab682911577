"""Wrong things for what reads, draws, reports, writes and measures, and for known worlds.

What is called: (with what, wrong things); `g` is the model of test_wrong_things.py.
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
    "read_horizon": (lambda g, v: gs.read_horizon(v), lambda g: wrong.paths(".")),
    "read_fault": (lambda g, v: gs.read_fault(v), lambda g: wrong.paths(".")),
    "read_points": (lambda g, v: gs.read_points(v), lambda g: wrong.paths(".")),
    "read_polygons": (lambda g, v: gs.read_polygons(v), lambda g: wrong.paths(".")),
    "read_tops": (lambda g, v: gs.read_tops(v, positive="up"), lambda g: wrong.paths(".")),
    "read_wells": (lambda g, v: gs.read_wells(v, positive="up"), lambda g: wrong.paths(".")),
    "read_fault.format": (
        lambda g, v: gs.read_fault("F1.ts", format=v), lambda g: wrong.words(),
    ),
    "read_units": (lambda g, v: gs.read_units(v), lambda g: wrong.paths(".")),
    "info": (lambda g, v: gs.info(v), lambda g: [v for v in wrong.paths(".") if v != "x"]),
    "mesh_units": (lambda g, v: gs.mesh_units(v), lambda g: wrong.things(g.scene)),
    "mesh_units.size": (
        lambda g, v: gs.mesh_units(g.units, size=v), lambda g: [*wrong.lengths(), 0],
    ),
    "build_grid": (lambda g, v: gs.build_grid(v), lambda g: wrong.things(g.scene)),
    "build_grid.cell": (
        lambda g, v: gs.build_grid(g.scene, cell=v), lambda g: ["abc", None, (1,), (0, 5), {}],
    ),
    "build_grid.layers": (
        lambda g, v: gs.build_grid(g.scene, layers=v),
        lambda g: ["abc", None, 0, -3, 1.5, {"Nope": 3}, {"Top/Base": 0}],
    ),
    "render_grid_section": (
        lambda g, v: gs.render_grid_section(v, "no/x.png"), lambda g: wrong.things(g.scene),
    ),
    "reproject": (lambda g, v: gs.reproject(v, "EPSG:32631"), lambda g: wrong.things(g.scene)),
    "reproject.crs": (lambda g, v: gs.reproject(g.top, v), lambda g: [None, 5, [], object()]),
    "to_xtgeo": (lambda g, v: gs.to_xtgeo(v), lambda g: wrong.things(g.scene)[:8]),
    "to_geodataframe": (lambda g, v: gs.to_geodataframe(v), lambda g: wrong.things(g.scene)[:-1]),
    "run_scenario": (lambda g, v: gs.run_scenario(v, "no"), lambda g: wrong.paths(".")),
    "write": (
        lambda g, v: gs.write(v, "no/x.vtp"), lambda g: ["Top", None, 5, [], {}, object(), g.top],
    ),
    "write.path": (
        lambda g, v: gs.write(g.f1, v),
        lambda g: [v for v in wrong.paths(".") if v != "no/such.vtp"],
    ),
    "write.name": (
        lambda g, v: gs.write(g.f1, "no/x.ts", name=v), lambda g: [["F1"], {}, object(), 1.5],
    ),
    "show": (lambda g, v: gs.show(v), lambda g: [*wrong.things(g.scene)[:6], [g.top], object()]),
    "show.max_triangle": (
        lambda g, v: gs.show(g.f1, max_triangle=v), lambda g: ["abc", None, 0, -1, np.nan, [], {}],
    ),
    "show_progress": (
        lambda g, v: gs.show_progress(v), lambda g: [None, 0, "on", [], {}, object()],
    ),
    "view": (lambda g, v: ScenePlots(v).view(path="no/x.png"), lambda g: wrong.things(g.scene)),
    "view.path": (
        lambda g, v: ScenePlots(g.scene).view(path=v, size=(400, 250)),
        lambda g: wrong.paths(".")[1:],
    ),
    "view.view": (
        lambda g, v: ScenePlots(g.scene).view(v, path="no/x.png"), lambda g: [*wrong.words(), None],
    ),
    "view.size": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", size=v), lambda g: [*SIZES, None],
    ),
    "view.exaggeration": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", exaggeration=v),
        lambda g: [*wrong.lengths(), 0],
    ),
    "view.show": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", show=v),
        lambda g: ["abc", 5, None, [5], ["abc"], [None], object()],
    ),
    "view.exploded": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", exploded=v, show="units"),
        lambda g: [*wrong.lengths(), None],
    ),
    "view.clip": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", clip=v), lambda g: FLAGS,
    ),
    "view.view.angles": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", view=v),
        lambda g: [(1, 2, 3), (0, 91), ("a", 2), (np.nan, 0), [None, None], 5.0],
    ),
    "view.zoom": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", zoom=v),
        lambda g: [*wrong.lengths(), 0, 1e9],
    ),
    "view.only": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", only=v),
        lambda g: [5, ["Nope"], "Nope", [None], object(), {"a": 1}],
    ),
    "view.colour_by": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", colour_by=v, show="units"),
        lambda g: ["abc", 5, [], [1.0], {"Nope": 1.0}, {}, object(), [np.nan] * 6, [[1.0]]],
    ),
    "view.title": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", title=v), lambda g: [5, b"x", ["a"]],
    ),
    "view.style": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", style=v), lambda g: ["dark", 5, {}],
    ),
    "view.overlay": (
        lambda g, v: ScenePlots(g.scene).view(path="no/x.png", overlay=v), lambda g: ["x", 5, {}],
    ),
    "PictureStyle": (lambda g, v: gs.PictureStyle(v), lambda g: [*wrong.words(), None]),
    "PictureStyle.font": (lambda g, v: gs.PictureStyle(font=v), lambda g: wrong.words()),
    "PictureStyle.colours": (
        lambda g, v: gs.PictureStyle(colours=v),
        lambda g: ["red", 5, [], {"Top": "tael"}, {"Top": 5}, {"Top": (2, 0, 0)}, {5: "red"}],
    ),
    "PictureStyle.colour_map": (
        lambda g, v: gs.PictureStyle(colour_map=v), lambda g: wrong.words(),
    ),
    "PictureOverlay": (
        lambda g, v: gs.PictureOverlay(v),
        lambda g: ["abc", 5, [], {"W": 5}, {"W": "x"}, {"W": [1, 2, 3]}, {5: [[0, 0, 0]]}, None],
    ),
    "PictureOverlay.points": (
        lambda g, v: gs.PictureOverlay(points={"P": v}),
        lambda g: [5, None, "x", [[0, 0]], [[0, 0, np.nan]], [], {}, object(), [[1j, 0, 0]]],
    ),
    "render_place": (
        lambda g, v: gs.render_place(v, (0, 0, 0), "no/x.png"),
        lambda g: [v for v in wrong.things(g.scene) if not isinstance(v, xr.Dataset)],
    ),
    "render_place.place": (
        lambda g, v: gs.render_place(g.surfaces, v, "no/x.png"),
        lambda g: ["abc", None, 5, (0, 1), (0, 1, np.nan), ("a", "b", "c"), {}, (1j, 0, 0)],
    ),
    "render_place.reach": (
        lambda g, v: gs.render_place(g.surfaces, (0, 0, 0), "no/x.png", reach=v),
        lambda g: [*wrong.lengths(), 0],
    ),
    "drawn_thickness": (
        lambda g, v: plotted(draw_thickness, v, path="no/x.png"),
        lambda g: [*wrong.things(g.scene), g.top, g.thickness * np.nan, g.table],
    ),
    "drawn_thickness.polygons": (
        lambda g, v: plotted(draw_thickness, g.thickness, path="no/x.png", polygons=v),
        lambda g: ["abc", 5, [], {"Top": 5}, {"Top": "x"}, {"Top": xr.Dataset()}, object()],
    ),
    "drawn_allan": (
        lambda g, v: plotted(draw_allan, v, g.table, path="no/x.png"),
        lambda g: [*wrong.things(g.scene), g.table],
    ),
    "allan_diagram.table": (
        lambda g, v: plotted(draw_allan, g.allan, v, path="no/x.png"),
        lambda g: [*wrong.things(g.scene), g.allan],
    ),
    "allan_diagram.zones": (
        lambda g, v: plotted(draw_allan, g.allan, g.table, path="no/x.png", zones=v),
        lambda g: [5, None, object()],
    ),
    "drawn_section": (
        lambda g, v: plotted(draw_section, v, path="no/x.png"),
        lambda g: [*wrong.things(g.scene), g.allan],
    ),
    "report_scene": (lambda g, v: gs.report_scene(v, "no"), lambda g: wrong.things(g.scene)),
    "report_scene.folder": (
        lambda g, v: gs.report_scene(g.scene, v, {}), lambda g: [None, 5, "", b"x", object()],
    ),
    "report_scene.pictures": (
        lambda g, v: gs.report_scene(g.scene, "no", v),
        lambda g: ["abc", 5, [], {"x": 5}, {"x": None}, {"x": "no.png"}],
    ),
    "report_scene.certificate": (
        lambda g, v: gs.report_scene(g.scene, "no", {}, certificate=v), lambda g: [5, "abc", []],
    ),
    "report_scene.regions": (
        lambda g, v: gs.report_scene(g.scene, "no", {}, regions=v),
        lambda g: ["abc", 5, [], {"x": 5}, {"x": (1,)}, {"x": ("a", "b")}, {"x": (np.nan, "b")}],
    ),
    "separation": (
        lambda g, v: measure.separation(v, LINE, 90.0), lambda g: [[v] for v in wrong.arrays()],
    ),
    "separation.dip_azimuth": (
        lambda g, v: measure.separation(LINE, LINE, v), lambda g: [*wrong.numbers(), None],
    ),
    "separation.start": (
        lambda g, v: measure.separation(LINE, LINE, 90.0, start=v), lambda g: wrong.numbers(),
    ),
    "measure.patches": (
        lambda g, v: measure.allan_diagram(v, g.units, "F1"), lambda g: wrong.things(g.scene),
    ),
    "measure.units": (
        lambda g, v: measure.juxtaposition_table(g.patches, v, "F1"),
        lambda g: wrong.things(g.scene),
    ),
    "thickness_map": (
        lambda g, v: measure.thickness_map(v, "Top/Base"), lambda g: wrong.things(g.scene),
    ),
    "wall_lines": (
        lambda g, v: measure.wall_lines(g.patches, g.units, "Top", "F1", v),
        lambda g: [5, -1, "x", None],
    ),
    **{
        f"synthetic.{name}.{key}": (
            lambda g, v, name=name, key=key: getattr(gs.synthetic, name)(**{key: v}),
            lambda g, key=key: ["abc", 5.5, None, 0, -3, np.nan, True, []] if key == "n"
            else ["abc", 5, None, (0, 1), (np.nan, 0, 0), ("a", "b", "c")],
        )
        for name in gs.synthetic.__all__
        if callable(getattr(gs.synthetic, name))
        and name not in ("World", "Fault", "FieldTruth", "field_export")
        for key in ("n", "offset")
    },
}  # fmt: skip
