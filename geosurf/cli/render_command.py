"""The command ``render``: one view or one section of the model of a scenario."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from geosurf.cli.console import Answer, step_lines
from geosurf.cli.parser import SHOW, VIEW
from geosurf.conventions.machine import need_plots
from geosurf.errors import InputError
from geosurf.render.colouring import check_colour_by
from geosurf.render.compose import check_look, png_path
from geosurf.scenario import build_scene, read_scenario
from geosurf.scenario.execute import overlay_of_files, picture_style
from geosurf.scenario.keys import Scenario
from geosurf.scenario.step_log import StepLog
from geosurf.scene import Scene
from geosurf.scene.result_cache import cache_in


def render_command(options: argparse.Namespace) -> Answer:
    """Draw one picture of a scenario."""
    scenario = read_scenario(options.scenario, options.set)
    png_path(options.out)  # refuse a wrong suffix before the computation
    draw = _draw_view if options.section is None else _draw_section
    path = draw(scenario, options)
    return Answer({"scenario": scenario.path, "picture": path}, str(path))


def _draw_view(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a view in space, which looks as the scenario states."""
    settings, output = scenario.pictures, scenario.output
    look: dict[str, Any] = {
        "view": options.view or settings.camera or VIEW,
        "size": output.size_px,
        "zoom": settings.zoom,
        "title": options.title,
    }
    only = None if options.only is None else _words_of(",".join(options.only))

    # all of it is checked before the model is built
    check_look(**look, path=options.out)
    check_colour_by(options.colour_by or "unit")
    overlay = overlay_of_files(scenario)
    made: Path = _built(scenario, options).plot.view(
        path=options.out,
        show=_words_of(options.show or SHOW),
        exaggeration=output.exaggeration,
        clip=output.clip,
        only=only,
        include=output.include,
        colour_by=options.colour_by,
        overlay=overlay,
        style=picture_style(scenario),
        **look,
    )
    return made


def _words_of(text: str) -> tuple[str, ...]:
    """Words of an option with commas between them."""
    return tuple(word.strip() for word in text.split(","))


def _built(scenario: Scenario, options: argparse.Namespace) -> Scene:
    """Build the scene, with its steps shown as a command was asked to."""
    log = StepLog(step_lines(options, steps=False))
    scene = build_scene(scenario, log, cache_in(options.cache_dir))
    with log.watching(scene):
        _ = scene.sheets
    return scene


def _draw_section(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a vertical section; refuse options of views, which would have no effect."""
    # None means "not given": argparse has no other way to tell it from a default
    for word in ("view", "show", "only", "colour_by"):
        if getattr(options, word) is not None:
            word = word.replace("_", "-")
            raise InputError(
                f"--section and --{word} cannot be combined: --{word} applies to views "
                "only. Leave one of them out."
            )

    # checked before the model is built
    need_plots()
    line = _line_of(options.section)
    overlay = overlay_of_files(scenario)
    made: Path = _built(scenario, options).plot.section(
        line, path=options.out, size=scenario.output.size_px, title=options.title,
        overlay=overlay, style=picture_style(scenario),
    )  # fmt: skip
    return made


def _line_of(text: str) -> list[tuple[float, float]]:
    """Return the points of a line in the map from a text such as ``0,2500 6000,2500``."""
    how = "easting and northing of two points or more"
    example = 'in metres and in quotes, as in "0,2500 6000,2500"'
    line = []
    # points are separated by blanks, so that numbers keep their decimal points
    for word in text.split():
        try:
            easting, northing = map(float, word.split(","))
        except ValueError as error:
            raise InputError(
                f"--section is {word!r}, expected two numbers: {how} {example}."
            ) from error
        line.append((easting, northing))
    if len(line) < 2:
        raise InputError(f"--section: {text!r} has fewer than two points. Give {how} {example}.")
    return line
