"""What is timed of geosurf: public calls, and what is looked at after the clock has stopped.

A task has three steps. `fresh` makes what the call takes, anew for each repeat and beside the
clock; `run` is timed; `answer` measures what came out, so that it can be judged.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import geology, truth
from benchmarks.distance import hausdorff
from benchmarks.installed import prepare_start
from benchmarks.scenes import Setting
from benchmarks.starts import (
    parts_of_run,
    small_scenario,
    start_from_files,
    start_of_run,
    start_process,
    two_files,
)
from geosurf.carve import carve_units
from geosurf.intersect import intersect_surfaces
from geosurf.model import Curves, Patches, Units
from geosurf.rebuild import rebuild_surfaces
from geosurf.scene import Scene
from geosurf.triangulate import build_walls

FLOOR_BLOCK = 32_768  # doubles that stay in the nearest cache between the two passes
_START = (
    "from geosurf.model import TriSurface as T;"
    "from geosurf.intersect import intersect_surfaces as f;"
    "c=f([T('A','surface',[[0,0,0],[9,0,0],[0,9,0]],[[0,1,2]]),"
    "T('B','surface',[[3,-1,-5],[3,9,-5],[3,4,9]],[[0,1,2]])]);"
    "raise SystemExit(c.n_curve!=1)"
)


@dataclass(frozen=True)
class Task:
    """A timed call.

    Attributes
    ----------
    fresh : callable
        From a `Setting` and options to what `run` takes; not timed.
    run : callable
        From that and the options to a result; timed.
    answer : callable
        From the setting and the result to numbers that can be judged; not timed.
    """

    fresh: Callable[[Setting, dict], Any]
    run: Callable[[Any, dict], Any]
    answer: Callable[[Setting, Any], dict[str, Any]]


# ---- steps -----------------------------------------------------------------------------


def _itself(setting: Setting, options: dict) -> Setting:
    return setting


def _surfaces(setting: Setting, options: dict) -> Any:
    return setting.surfaces()


def _searched(setting: Setting, options: dict) -> Any:
    """Surfaces that keep their search structures from a first call."""
    if not setting.truth.get("searched"):
        setting.truth["searched"] = setting.surfaces()
        intersect_surfaces(setting.truth["searched"], **options)
    return setting.truth["searched"]


def _curve(setting: Setting, options: dict) -> Curves:
    """From the grids: triangles, search structures and the curve."""
    return intersect_surfaces(setting.surfaces(), **options)


def _full(setting: Setting, options: dict) -> Patches:
    """Split, and all arrays of the welded mesh in world coordinates."""
    patches = rebuild_surfaces(setting.surfaces())
    patches.vertices  # noqa: B018 - asking computes
    patches.triangles  # noqa: B018
    return patches


def _scene(setting: Setting, options: dict) -> Scene:
    surfaces = setting.by_role("horizon"), setting.by_role("fault"), setting.box
    return Scene(*surfaces, tolerance=options.get("tolerance"))


def _first_pair(scene: Scene) -> tuple[str, str]:
    return scene.horizon_names[0], scene.fault_names[0]


def _picture(scene: Scene, options: dict) -> int:

    with tempfile.TemporaryDirectory() as folder:
        return scene.plot.view(path=Path(folder) / "view.png").stat().st_size


def _floor(setting: Setting, options: dict) -> float:
    """Smallest and largest value of all grids, each number read from memory once."""
    total = 0.0
    for _, _, value in setting.sources:
        parts = value.data_vars.values() if hasattr(value, "data_vars") else [value]
        for part in parts:
            flat = part.values.reshape(-1)
            blocks = [flat[k : k + FLOOR_BLOCK] for k in range(0, len(flat), FLOOR_BLOCK)]
            bounds = [(block.min(), block.max()) for block in blocks]
            total += float(min(b[0] for b in bounds) + max(b[1] for b in bounds))
    return total


# ---- answers ---------------------------------------------------------------------------


def segments_answer(setting: Setting, segments: np.ndarray) -> dict[str, Any]:
    """Return length and number of segments (n, 2, 3) of a curve, and its error where known."""
    steps = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    found: dict[str, Any] = {"length": math.fsum(steps), "segments": len(segments)}
    for curve_at in setting.truth.get("curve_at", {}).values():
        _, _, south, north, _, _ = setting.box or (0.0,) * 6
        found["strays"], found["misses"] = hausdorff(segments, curve_at, (south, north))
    return found


def _curves_answer(setting: Setting, curves: Curves) -> dict[str, Any]:
    found = segments_answer(setting, curves.points[curves.segments])
    return found | {"curves": curves.n_curve}


def pieces_answer(corners: list[np.ndarray], wholes: list[np.ndarray]) -> float:
    """Return the largest relative change of area of surfaces, from corners (n, 3, 3) each."""
    pairs = [
        (math.fsum(truth.areas(part)), math.fsum(truth.areas(whole)))
        for part, whole in zip(corners, wholes, strict=True)
    ]
    return max(abs(part / whole - 1.0) for part, whole in pairs)


def _patches_answer(setting: Setting, patches: Patches) -> dict[str, Any]:
    edges = patches.local[patches.curve_edges]
    corners = patches.local[patches.triangles]
    parts = [corners[patches.surface_of_triangle == i] for i in range(len(patches.sources))]
    wholes = [(s.vertices - patches.origin)[s.triangles] for s in patches.sources]
    return {
        "length": math.fsum(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)),
        "segments": len(edges),
        "triangles": patches.n_triangle,
        "area_error": pieces_answer(parts, wholes),
    }


def _units_answer(setting: Setting, units: Units) -> dict[str, Any]:
    found: dict[str, Any] = {
        "units": len(units),
        "closed": all(truth.is_closed(unit.triangles) for unit in units.values()),
        "box_error": abs(units.volume / units.box_volume - 1.0),
        "volumes": {name: unit.volume for name, unit in units.items()},
    }
    grids = [value for role, _, value in setting.sources if role == "horizon"]
    found["zone_error"] = _zone_error(grids, units)
    known = {
        f"{zone} {' '.join(s)}": v for (zone, s), v in setting.truth.get("volumes", {}).items()
    }
    if known:
        found["volume_error"] = max(abs(units[key].volume / v - 1.0) for key, v in known.items())
    return found


def _zone_error(grids: list[Any], units: Units) -> float:
    """Largest relative error of the volume of a zone, from the grids alone."""
    bottom = float(units.box[4])
    below = [
        truth.volume_below_grid(grid.easting.values, grid.northing.values, grid.values, bottom)
        for grid in grids
    ]
    zones = -np.diff([units.box_volume, *below, 0.0])
    sums = [
        math.fsum(unit.volume for unit in units.values() if unit.zone_index == i)
        for i in range(len(zones))
    ]
    return float(np.abs(np.array(sums) / zones - 1.0).max())


def _nothing(setting: Setting, result: Any) -> dict[str, Any]:
    return {}


def _carve_answer(setting: Setting, units: Units) -> dict[str, Any]:
    patches = setting.truth["patches"]
    rows = np.sort(patches.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    n = np.int64(rows.max()) + 1
    found = _units_answer(setting, units)
    return found | {"edges": len(np.unique(rows[:, 0] * n + rows[:, 1]))}


def _split_box(setting: Setting, options: dict) -> Patches:
    """Patches with the walls of the box, made once."""
    if "patches" not in setting.truth:
        walls = build_walls(setting.box)
        setting.truth["patches"] = rebuild_surfaces([*setting.surfaces(), *walls])
    return setting.truth["patches"]


def _truth(setting: Setting, options: dict) -> list[tuple[float, int]]:
    """Length and number of segments of each grid with each fault, by plain numpy."""
    faults = [s for s in setting.surfaces() if s.role == "fault"]
    found = []
    for role, _, grid in setting.sources:
        if role != "horizon":
            continue
        axes = grid.easting.values, grid.northing.values
        for fault in faults:
            corners = fault.vertices[fault.triangles]
            found.append(truth.curve_of_grid(*axes, grid.values, corners))
    return found


def _truth_answer(setting: Setting, found: list[tuple[float, int]]) -> dict[str, Any]:
    return {
        "length": math.fsum(length for length, _ in found),
        "segments": sum(count for _, count in found),
        "first": {"length": found[0][0], "segments": found[0][1]},
    }


TASKS = {
    "curve": Task(_itself, _curve, _curves_answer),
    "curve, kept search": Task(_searched, lambda s, o: intersect_surfaces(s, **o), _curves_answer),
    "split": Task(_itself, lambda s, o: rebuild_surfaces(s.surfaces()), _patches_answer),
    "split, full arrays": Task(_itself, _full, _patches_answer),
    "split, from arrays": Task(_surfaces, lambda s, o: rebuild_surfaces(s), _patches_answer),
    "units": Task(_scene, lambda s, o: s.units, _units_answer),
    "carve": Task(_split_box, lambda p, o: carve_units(p), _carve_answer),
    "sheets": Task(geology.inputs, geology.tear_all, geology.sheets_answer),
    "model": Task(geology.inputs, geology.whole_model, geology.model_answer),
    "one curve": Task(_scene, lambda s, o: s.curves_between(*_first_pair(s)), _curves_answer),
    "all curves": Task(_scene, lambda s, o: s.curves, _curves_answer),
    "one unit": Task(_scene, lambda s, o: next(iter(s.units.values())), _nothing),
    "one picture": Task(_scene, _picture, _nothing),
    "floor": Task(_itself, _floor, _nothing),
    "start": Task(
        lambda s, o: prepare_start(o), lambda s, o: start_process(_START, s.environment), _nothing
    ),
    "start from files": Task(two_files, start_from_files, lambda s, n: {"bytes": n}),
    "start of a run": Task(small_scenario, start_of_run, lambda s, made: parts_of_run(made)),
    "truth": Task(_itself, _truth, _truth_answer),
}
