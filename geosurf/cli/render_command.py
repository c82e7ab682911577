"""The command ``render``: one view or one section of the model of a scenario."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from geosurf.cli.console import Answer, step_lines
from geosurf.cli.parser import SHOW, VIEW
from geosurf.cli.scenario_commands import scenario_of
from geosurf.conventions.machine import need_plots
from geosurf.errors import InputError
from geosurf.render.colouring import check_colour_by
from geosurf.render.compose import check_look, png_path
from geosurf.render.overlay import PictureOverlay
from geosurf.render.picture_style import PictureStyle
from geosurf.render.views import check_size
from geosurf.scenario import build_scene
from geosurf.scenario.execute import overlay_of_files, picture_style
from geosurf.scenario.keys import Scenario
from geosurf.scenario.step_log import StepLog
from geosurf.scene import Scene
from geosurf.scene.result_cache import cache_in


def render_command(options: argparse.Namespace) -> Answer:
    """Draw one picture of a scenario."""
    scenario = scenario_of(options)
    png_path(options.out)  # refuse a wrong suffix before the computation
    draw = _draw_view if options.section is None else _draw_section
    path = draw(scenario, options)
    return Answer({"scenario": scenario.path, "picture": path}, str(path))


def _draw_view(scenario: Scenario, options: argparse.Namespace) -> Path:
    """Draw a view in space; options that are not given are those of the scenario."""

    def given(option: Any, otherwise: Any) -> Any:
        """Return an option, or its default if it is not given."""
        return otherwise if option is None else option

    # an option wins over the scenario, the scenario over the default
    settings = scenario.pictures
    if options.view is not None and options.camera is not None:
        raise InputError("--view and --camera cannot be combined. Leave one of them out.")
    view = given(options.view, VIEW if settings.camera is None else settings.camera)
    look: dict[str, Any] = {
        "view": view
        if options.camera is None
        else _numbers_of(options.camera, "--camera", "225,30"),
        "size": _size_of(scenario, options),
        "zoom": given(options.zoom, settings.zoom),
        "title": options.title,
    }
    only = None if options.only is None else _words_of(",".join(options.only))
    colours = {} if options.colour_by is None else {"colour_by": options.colour_by}
    style = _style_of(scenario, options)

    # all of it is checked before the model is built
    check_look(**look, path=options.out)
    check_colour_by(given(options.colour_by, "unit"))
    overlay = _overlay_of(scenario, options)
    made: Path = _built(scenario, options).plot.view(
        path=options.out,
        show=_words_of(given(options.show, SHOW)),
        exaggeration=given(options.exaggeration, scenario.output.exaggeration),
        clip=given(options.clip, scenario.output.clip),
        only=only,
        include=scenario.output.include,
        overlay=overlay,
        style=style,
        **look,
        **colours,
    )
    return made


def _words_of(text: str) -> tuple[str, ...]:
    """Words of an option with commas between them."""
    return tuple(word.strip() for word in text.split(","))


def _numbers_of(text: str, option: str, example: str) -> tuple[float, float]:
    """Two numbers of an option with a comma between them."""
    try:
        first, second = map(float, text.split(","))
    except ValueError as error:
        raise InputError(f"{option} is {text!r}, expected two numbers: {example}.") from error
    return first, second


def _size_of(scenario: Scenario, options: argparse.Namespace) -> tuple[int, int]:
    """Width and height of the picture [pixels]."""
    if options.size is None:
        return scenario.output.size_px
    pair: Any = _numbers_of(options.size, "--size", "1280,800")
    return check_size(pair)


def _style_of(scenario: Scenario, options: argparse.Namespace) -> PictureStyle:
    """The style of the scenario with the theme of the options."""
    given = {word: getattr(options, word) for word in ("theme", "transparent")}
    known = {word: value for word, value in given.items() if value is not None}
    return replace(picture_style(scenario), **known)


def _overlay_of(scenario: Scenario, options: argparse.Namespace) -> PictureOverlay:
    """Wells, polygons and points of the scenario, and those of the options."""
    settings = scenario.pictures
    drawn: dict[str, Any] = {
        kind: {**(getattr(settings, kind) or {}), **dict(getattr(options, kind))}
        for kind in ("wells", "polygons", "points")
    }
    return overlay_of_files(replace(scenario, pictures=replace(settings, **drawn)))


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
    for word in ("view", "show", "exaggeration", "clip", "camera", "zoom", "only", "colour_by"):
        if getattr(options, word) is not None:
            word = word.replace("_", "-")
            raise InputError(
                f"--section and --{word} cannot be combined: --{word} applies to views "
                "only. Leave one of them out."
            )

    # checked before the model is built
    need_plots()
    line = _line_of(options.section)
    size, style = _size_of(scenario, options), _style_of(scenario, options)
    overlay = _overlay_of(scenario, options)
    made: Path = _built(scenario, options).plot.section(
        line, path=options.out, size=size, title=options.title, overlay=overlay, style=style
    )
    return made


def _line_of(text: str) -> list[tuple[float, float]]:
    """Return the points of a line in the map from a text such as ``0,2500 6000,2500``."""
    # points are separated by blanks, so that numbers keep their decimal points
    how = "easting and northing of two points or more"
    example = 'in metres and in quotes, as in "0,2500 6000,2500"'
    line = [_numbers_of(word, "--section", f"{how} {example}") for word in text.split()]
    if len(line) < 2:
        raise InputError(f"--section: {text!r} has fewer than two points. Give {how} {example}.")
    return line
