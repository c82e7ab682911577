"""Random arguments at every public function: ``python -m benchmarks.stress.random_arguments N``.

Each call begins with arguments that are right, and some of them are exchanged: for hostile values
(`hostile_values`), or for what another parameter takes. It may give a result or raise an error of
geosurf; anything else is a defect: another exception, an `InvariantError`, a warning of a
library, more than `SECONDS`. What a call gives back is looked at, too: all its public properties
are asked for.

Left out are methods by which stages hand arrays to each other (`BETWEEN_STAGES`), and the making
of nouns that only stages make.
"""

from __future__ import annotations

import argparse
import faulthandler
import inspect
import os
import random
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from functools import cache, cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.stress.hostile_values import POOL
from geosurf import measure, render
from geosurf.errors import GeosurfError, GeosurfWarning, InvariantError

SECONDS = 60
ANYTHING = (Exception,)  # what is no error of geosurf is a defect, and is named
SIZE = (200, 150)
BETWEEN_STAGES = {
    "Lattice": ("corners_of_keys", "keys_of_rows", "places_of_nodes", "rows_of_keys", "turned_as",
                "shares_map", "horizontal"),
    "TriSurface": ("corners_of_keys", "places_of_nodes", "rows_of_keys", "lifted"),
    "Patches": ("changed",), "Sheet": ("surface_among",), "EllipticThrow": ("at",),
    "Units": ("elements_of",),
}  # fmt: skip
MADE_BY_USERS = (
    "TriSurface",
    "FluidContact",
    "FaultSticks",
    "EllipticThrow",
    "Scene",
    "PictureStyle",
    "PictureOverlay",
)
CHEAP = 12  # calls that draw or tear are made once where others are made so often
DEAR = (
    "render",
    "ScenePlots",
    "report",
    "run_",
    "tear",
    "throw_",
    "propose_trim",
    "check",
    "Scene",
    "write",
)


@cache
def given() -> SimpleNamespace:
    """Arguments that are right, by the name of the parameter; made once."""
    world, torn = gs.synthetic.tilted_planes(n=4), gs.synthetic.torn("normal", n=15)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    top, f1 = scene.surface("Top"), scene.surface("F1")
    faults = {"F1": torn.faults["F1"]}
    corners = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    line = [np.array([[0.0, 0, 0], [0, 10, 0]])]
    files = files_of(scene, world)
    right = {
        "horizons": world.horizons, "faults": world.faults, "box": world.box, "scene": scene,
        "patches": scene.patches, "units": scene.units, "curves": scene.curves, "surface": f1,
        "surfaces": list(scene.surfaces), "surface_a": top, "surface_b": f1, "obj": top,
        "search": scene.search("Top", "F1"), "horizon": "Top", "fault": "F1", "name": "Top",
        "zone": "Top/Base", "first": "Top", "second": "F1", "path": "new.vtp", "folder": "new",
        "out": "new", "line": [(0.0, 1500.0), (4000.0, 1500.0)], "da": world.horizons["Top"],
        "data": torn.horizons["Top"], "throw": {"F1": 20.0}, "P": corners, "Q": corners + 0.5,
        "polygons": {"Top": [[0, 0, 0], [-1, 5, 1], [0, 9, 0], [1, 5, -1]]},
        "polygon": [[0, 0, 0], [-1, 5, 1], [0, 9, 0], [1, 5, -1]],
        "theme": "dark", "colours": {"Top": "teal"}, "colour_map": "viridis", "zoom": 2.0,
        "wells": {"W1": corners}, "points": {"P": corners}, "colour_by": "zone",
        "sticks": [corners[:2], corners[:2] + 5.0], "contacts": {"OWC": -2100.0},
        "truncations": {}, "diagram": scene.allan("F1"), "table": scene.juxtaposition("F1", "all"),
        "section": scene.section([(0.0, 1500.0), (4000.0, 1500.0)]), "place": (0.0, 0.0, -2000.0),
        "thickness": scene.thickness("Top/Base", 1000.0), "hanging_wall": line, "footwall": line,
        "dip_azimuth": 90.0, "side": "+", "size": SIZE, "at": -2100.0, "largest": 20.0,
        "role": "horizon", "vertices": corners, "triangles": [[0, 1, 2]], "kind": "normal",
        "positive": "up", "length_unit": "m", "pictures": {}, "n": 5, "view": "top",
        "direction": "local", "key": "x", "numbers": 0,
        "sides": "F1+", "values": [1.0], "value": 5, "grid": 1000.0, "i": 0, "what": "it",
        "tops": {"well": ["W1"], "horizon": ["Top"], "easting": [1000.0], "northing": [1000.0],
                 "elevation": [-2100.0]}, "tie": True, "distance": 100.0,
        "torn_faults": faults, "torn_grid": torn.horizons["Top"], "files": files,
        "network": scene.propose_fault_network(), "unit": next(iter(scene.units.values())),
        "sheet": gs.tear_horizon(torn.horizons["Top"], faults), "certificate": scene.check(),
        "crs": "EPSG:32631", "lines": scene.fault_polygons("Top"),
        "corner_point_grid": gs.build_grid(scene, cell=1000.0, layers=1), "throws": {},
        "zones": {"Top/Base": 10.0}, "rules": {}, "vshale": 0.3, "permeability": 100.0,
        "sheets": {"Top": gs.tear_horizon(torn.horizons["Top"], faults)},
    }  # fmt: skip
    return SimpleNamespace(**right)


def files_of(scene: gs.Scene, world: Any) -> dict[str, str]:
    """A file for each reader, in the working folder."""
    found = {
        "read_horizon": "top.nc", "read_fault": "f1.ts", "read_points": "points.xyz",
        "read_polygons": "lines.pol", "run_scenario": "s.toml", "read_tops": "tops.csv",
        "info": "points.xyz", "read_wells": "wells.csv", "read_units": "model.ml",
    }  # fmt: skip
    gs.write(world.horizons["Top"], "top.nc")
    gs.write(scene.surface("F1"), "f1.ts")
    gs.write(scene.units, "model.ml")
    Path("points.xyz").write_text("0 0 -1\n1 0 -2\n0 1 -2\n")
    Path("lines.pol").write_text("0 0 0\n1 0 0\n1 1 0\n999 999 999\n")
    Path("tops.csv").write_text("Well,X,Y,Z,Top\nW1,1000,1000,-2100,Top\n")
    Path("wells.csv").write_text("Well,X,Y,Z\nW1,1000,1000,-2100\nW1,1000,1000,-2300\n")
    Path("s.toml").write_text('[[horizons]]\nname = "Top"\nfile = "top.nc"\n')
    return {name: str(Path(file).resolve()) for name, file in found.items()}


# what some functions need beside, or instead of, what the names of their parameters say
SPECIAL: dict[str, dict[str, str]] = {
    **{name: {"faults": "torn_faults", "data": "torn_grid", "horizon": "torn_grid"}
       for name in ("tear_horizon", "throw_horizon", "propose_trim")},
    "triangulate_fault": {"obj": "surface"}, "Scene.surface": {"name": "horizon"},
    "to_xtgeo": {"horizon": "da"}, "render_grid_section": {"grid": "corner_point_grid"},
    "fault_multipliers": {"grid": "corner_point_grid"},
}  # fmt: skip


def targets() -> dict[str, Any]:
    """All that is called, by name: functions, what users make, and methods of nouns."""
    g = given()
    rooms = (
        (gs, gs.__all__), (measure, measure.__all__), (render, render.__all__),
        (gs.synthetic, gs.synthetic.__all__),
        (gs.conventions, ("metres_per_unit", "elevation_sign", "is_number")),
    )  # fmt: skip
    found: dict[str, Any] = {}
    for room, names in rooms:
        for name in names:
            thing = getattr(room, name)
            if inspect.isclass(thing) and name not in MADE_BY_USERS:
                continue
            if callable(thing) and name not in ("VIEWS", "run_ensemble"):
                found.setdefault(name, thing)
    nouns = (
        g.scene,
        g.scene.plot,
        g.surface,
        g.curves,
        g.patches,
        g.units,
        g.unit,
        g.sheet,
        g.network,
    )
    for noun in nouns:
        kind = type(noun).__name__
        for name, method in inspect.getmembers(type(noun), inspect.isfunction):
            if not name.startswith("_") and name not in BETWEEN_STAGES.get(kind, ()):
                found[f"{kind}.{name}"] = method.__get__(noun)
    return found


def right_arguments(name: str, function: Any) -> dict[str, Any]:
    """Arguments that are right for all parameters that are needed."""
    g, words = given(), {}
    for key, parameter in inspect.signature(function).parameters.items():
        if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
            continue
        if key == "path" and name in g.files:
            words[key] = g.files[name]
        elif key == "path" and name.startswith("render"):
            words[key] = "new.png"
        elif parameter.default is parameter.empty or key == "size":
            words[key] = getattr(g, SPECIAL.get(name, {}).get(key, key))
    if name in ("read_points", "read_polygons", "read_tops", "read_wells"):
        words["positive"] = "up"
    if name == "run_scenario":
        words["pictures"] = False
    return words


def drawn(dice: random.Random) -> Any:
    """A hostile value, or one that is right elsewhere."""
    if dice.random() < 0.2:
        return dice.choice(list(vars(given()).values()))
    return dice.choice(POOL)()


def random_call(name: str, function: Any, dice: random.Random) -> tuple[list[Any], dict[str, Any]]:
    """Arguments of one call: right ones, of which at least one is exchanged or added."""
    words = right_arguments(name, function)
    extra: list[Any] = []
    known = inspect.signature(function).parameters
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        if not known:
            break
        key = dice.choice(list(known))
        kind = known[key].kind
        if kind is inspect.Parameter.VAR_POSITIONAL:
            extra.append(drawn(dice))
        elif kind is inspect.Parameter.VAR_KEYWORD:
            of_scenes = ("faults", "horizons", "box", "views", "size", "x")
            of_plots = ("path", "size", "title", "style")
            words[dice.choice(of_plots if name.startswith("ScenePlots") else of_scenes)] = drawn(
                dice
            )
        else:
            words[key] = drawn(dice)
    if dice.random() < 0.02:
        words[dice.choice(("x", "name", "path"))] = drawn(dice)  # may be a wrong name
    return extra, words


def weight(name: str, function: Any) -> int:
    """How often something is called: rarely if it takes long, or has no arguments."""
    dear = any(word in name for word in DEAR) or not inspect.signature(function).parameters
    return 1 if dear else CHEAP


def look_at(found: Any) -> None:
    """Ask for all public properties of what a call gave, and print it."""
    kind = type(found)
    if not kind.__module__.startswith("geosurf") or inspect.isfunction(found):
        return
    if hasattr(found, "savefig"):  # a figure has the properties of matplotlib
        return
    repr(found), str(found)
    for name in dir(kind):
        static = inspect.getattr_static(kind, name)
        if not name.startswith("_") and isinstance(static, property | cached_property):
            getattr(found, name)


def outcome(name: str, function: Any, extra: list[Any], words: dict[str, Any]) -> tuple[str, str]:
    """What a call ends with: a word, and for a defect where it comes from."""
    try:
        inspect.signature(function).bind(*extra, **words)
        bound = True
    except TypeError:
        bound = False
    signal.alarm(SECONDS)
    try:
        look_at(function(*extra, **words))
    except InvariantError as error:
        return "defect", described(error)
    except (GeosurfError, GeosurfWarning):
        return "refused", ""
    except ANYTHING as error:
        if isinstance(error, TypeError) and not bound:
            return "no such argument", ""
        if isinstance(error, KeyError) and name == "Units.get":
            return "refused", ""
        return "defect", described(error)
    finally:
        signal.alarm(0)
    return "taken", ""


def described(error: BaseException) -> str:
    """An exception, and the last line of geosurf that it came through."""
    if os.environ.get("TRACEBACKS"):
        traceback.print_exception(error)
    package = str(Path(gs.__file__).parent)  # a checkout may have this name, too
    frames = [
        f for f in traceback.extract_tb(error.__traceback__) if f.filename.startswith(package)
    ]
    at = f"{frames[-1].filename[len(package) + 1 :]}:{frames[-1].lineno}" if frames else ""
    return f"{at}: {type(error).__name__}"


def too_long(*_: object) -> None:
    """Break off a call."""
    raise TimeoutError(f"more than {SECONDS} s")


def run(n: int, seed: int, only: str = "") -> tuple[Counter[str], dict[str, list[str]]]:
    """
    Make `n` calls, and return how they ended, and defects with the calls that show them.

    Call `k` depends on the seed and on `k` alone. The working folder is a new one.
    """
    before = Path.cwd()
    signal.signal(signal.SIGALRM, too_long)
    ended: Counter[str] = Counter()
    defects: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                given.cache_clear()
                called = {k: f for k, f in targets().items() if only in k}
                weights = [weight(k, f) for k, f in called.items()]
                for k in range(n):
                    dice = random.Random(f"{seed} {k}")
                    (name,) = dice.choices(list(called), weights)
                    extra, words = random_call(name, called[name], dice)
                    shown = f"{k}: {name}({shortened(extra)}, {shortened(words)})"
                    Path(folder, "last_call").write_text(shown, errors="replace")
                    word, defect = outcome(name, called[name], extra, words)
                    ended[word] += 1
                    if defect:
                        defects.setdefault(defect, []).append(shown)
        finally:
            os.chdir(before)
            given.cache_clear()
    return ended, defects


def shortened(value: Any) -> str:
    """Arguments in few words."""
    if isinstance(value, dict):
        words = ", ".join(f"{key}={shortened(one)}" for key, one in value.items())
        return ascii(words)[1:-1]
    words = f"{type(value).__name__}:{str(type(value))!a}"
    try:
        words = ascii(value)
    except ANYTHING:
        return words
    return ascii(" ".join(words.split()))[1:-1][:70]


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("n", type=int, nargs="?", default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="a part of the name of what is called")
    options = parser.parse_args()
    faulthandler.enable()
    start = time.monotonic()
    ended, defects = run(options.n, options.seed, options.only)
    for defect, calls in sorted(defects.items(), key=lambda item: -len(item[1])):
        sys.stdout.write(f"{len(calls)} x {defect}\n      {calls[0]}\n")
    words = ", ".join(f"{ended[word]} {word}" for word in ("taken", "refused", "no such argument"))
    count = f"{ended['defect']} foreign exceptions or broken promises"
    seconds = time.monotonic() - start
    sys.stdout.write(f"{options.n} calls, seed {options.seed}: {words}, {count}; {seconds:.0f} s\n")
    return int(bool(defects))


if __name__ == "__main__":
    raise SystemExit(main())
