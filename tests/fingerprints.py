"""Hashes of the arrays of results: ``python -m tests.fingerprints [--field]``.

One line for each result: demo, scenarios, every synthetic world (torn where its gridded horizons
are smeared over faults), sheets of ``throw_horizon``, and with ``--field`` also Drogon's grids and
sheets from its points (in the shared data folder). Two commits that print the same lines compute
the same bytes; only public names are used, so that the file of one commit runs on another one.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs

ROOT = Path(__file__).resolve().parents[1]
WORLDS = [
    "dome_and_flat_fault",
    "egg_box",
    "faulted",
    "faulted_reservoir",
    "graben",
    "hills",
    "listric",
    "noisy",
    "tilted_planes",
    "torn",
    "waves",
]
CURVES = ("points", "segments", "surfaces_of_segment", "closed")
PATCHES = [
    "vertices",
    "triangles",
    "surface_of_triangle",
    "parent_of_triangle",
    "patch_of_triangle",
    "curve_edges",
]
UNIT = ("vertices", "triangles", "surface_of_triangle", "volume", "area")


def digest(*values: Any) -> str:
    """A short hash of arrays, numbers and texts, with shapes and kinds."""
    found = hashlib.sha256()
    for value in values:
        array = np.asarray(value)
        found.update(f"{array.dtype.kind} {array.shape}".encode())
        found.update(np.ascontiguousarray(array).tobytes() if array.dtype.kind != "O" else b"")
    return found.hexdigest()[:16]


def of_dataset(data: Any) -> str:
    """A hash of the numbers of an xarray object."""
    arrays = {**getattr(data, "data_vars", {"": data}), **data.coords}
    return digest(*(a.values for _, a in sorted(arrays.items()) if a.dtype.kind in "fib"))


def of_scene(scene: gs.Scene) -> Iterator[tuple[str, str]]:
    """All results of a scene, one after another."""
    for surface in scene.surfaces:
        yield f"surface {surface.name}", digest(surface.vertices, surface.triangles)
    curves = scene.curves
    yield "curves", digest(*(getattr(curves, name) for name in CURVES), *curves.curves)
    yield "patches", digest(*(getattr(scene.patches, name) for name in PATCHES))
    for name, unit in scene.units.items():
        yield f"unit {name}", digest(*(getattr(unit, part) for part in UNIT))
    yield "volumes", of_dataset(scene.volumes)
    yield "certificate", digest(scene.check().ok)
    for what, measure in measures_of(scene):
        try:
            yield what, of_dataset(measure())
        except gs.errors.GeosurfError as error:
            yield what, type(error).__name__


def measures_of(scene: gs.Scene) -> Iterator[tuple[str, Callable[[], Any]]]:
    """What a scene can be asked about its units."""
    west, east, south, north = scene.box[:4]
    line = [(west, 0.4 * south + 0.6 * north), (east, 0.6 * south + 0.4 * north)]
    yield "section", partial(scene.section, line)
    for zone in dict.fromkeys(unit.zone for unit in scene.units.values()):
        if zone.count("/") == 1 and set(zone.split("/")) <= set(scene.horizon_names):
            yield f"thickness {zone}", partial(scene.thickness, zone)
    for name in scene.faults_inside:
        yield f"juxtaposition {name}", partial(scene.juxtaposition, name)
        yield f"allan {name}", partial(scene.allan, name)
    for name in scene.horizons_inside:
        yield f"fault polygons {name}", partial(scene.fault_polygons, name)
        yield f"orientation {name}", partial(scene.orientation, name)
        for fault in scene.faults_inside:
            yield f"throw {name} {fault}", partial(scene.throw, name, fault)


def of_sheet(sheet: gs.Sheet) -> str:
    """A hash of a torn horizon and of what is known about it."""
    cuts = [
        value
        for _, cut in sorted(sheet.cuts.items())
        for value in (cut.throw, cut.heave, *cut.cutoffs["+"], *cut.cutoffs["-"])
    ]
    return digest(sheet.surface.vertices, sheet.surface.triangles, *cuts)


def torn_scene(horizons: dict, faults: dict, box: Any, **options: Any) -> gs.Scene:
    """A scene of horizons that are torn at all faults."""
    made = [gs.triangulate_fault(data, name=name) for name, data in faults.items()]
    sheets = {n: gs.tear_horizon(h, made, name=n, **options) for n, h in horizons.items()}
    return gs.Scene(sheets, {fault.name: fault for fault in made}, box)


def thrown_sheets() -> Iterator[tuple[str, gs.Sheet]]:
    """Horizons of synthetic worlds torn by a throw: constant, a profile, elliptic, a function."""
    graben = gs.synthetic.graben(n=41)
    listric = gs.synthetic.listric(n=41)
    tilted = gs.synthetic.tilted_planes(n=41)
    dying = gs.synthetic.torn(n=41)
    profile = [[0.0, -20.0], [1500.0, 35.0], [4000.0, 60.0]]
    ellipse = gs.EllipticThrow(60.0, half_length=1200.0, half_height=600.0)
    along = np.array([0.0, 900.0, 2500.0])
    cases: dict[str, tuple[Any, str, dict[str, Any], dict[str, Any]]] = {
        "constant": (graben, "Top", {"F1": 60.0, "F2": 40.0}, {}),
        "constant, reverse": (tilted, "Top", {"F1": -25.0}, {}),
        "constant, listric": (listric, "Top", {"F1": 50.0}, {}),
        "both walls, drag": (
            graben, "Base", {"F2": 35.0, "F1": 50.0}, {"reach": {"F1": 900.0}, "hanging_wall": 0.6},
        ),
        "profile": (tilted, "Base", {"F1": profile}, {"direction": "mean"}),
        "profile, two faults": (
            graben, "Middle", {"F1": np.column_stack([along, [10.0, 45.0, 30.0]]), "F2": 20.0}, {},
        ),
        "function": (graben, "Top", {"F2": lambda s: 20.0 + 0.01 * s}, {"hanging_wall": 0.0}),
        "elliptic": (tilted, "Top", {"F1": ellipse}, {}),
        "elliptic, at tips": (dying, "Top", {"F1": gs.EllipticThrow(30.0)}, {}),
    }  # fmt: skip
    for title, (world, horizon, throw, options) in cases.items():
        data = world.horizons[horizon]
        yield title, gs.throw_horizon(data, world.faults, throw, name=horizon, **options)


def scenes() -> Iterator[tuple[str, gs.Scene]]:
    """Every scene that the project ships."""
    from geosurf import scenario as files

    for path in sorted((ROOT / "data" / "synthetic_horizons").glob("*.toml")):
        yield path.stem, files.build_scene(files.read_scenario(path))
    for name in WORLDS:
        world = getattr(gs.synthetic, name)()
        if world.faults or len(world.horizons) > 1:
            yield f"world {name}", gs.Scene(world.horizons, world.faults, world.box)
        if name in ("torn", "faulted_reservoir"):
            yield f"torn {name}", torn_scene(world.horizons, world.faults, world.box, trim=3.0)
    world = gs.synthetic.waves(n=81)
    yield "waves, tolerance", gs.Scene(world.horizons, world.faults, world.box, tolerance=2.0)


def taller(stick: np.ndarray) -> np.ndarray:
    """A stick drawn out up and down by a quarter of its height, 20 m at least."""
    stick = stick[np.argsort(-stick[:, 2], kind="stable")]
    stick = stick[np.append(True, np.diff(stick[:, 2]) < 0)]
    reach = max(0.25 * abs(stick[0, 2] - stick[-1, 2]), 20.0)
    up, down = stick[0] - stick[1], stick[-1] - stick[-2]
    ends = [stick[0] + up * reach / abs(up[2]), stick[-1] + down * reach / abs(down[2])]
    return np.vstack([ends[0], stick, ends[1]])


def of_field() -> Iterator[tuple[str, str]]:
    """Drogon: its grids and faults as a model, its points as sheets."""
    folder = Path(os.environ.get("GEOSURF_SHARED", ROOT / ".." / "shared")) / "data" / "drogon"
    words = {"positive": "down", "length_unit": "m"}
    names = ("TopVolantis", "TopTherys", "TopVolon", "BaseVolantis")
    faults = {}
    for path in sorted((folder / "fault_sticks_pol").glob("F*.pol")):
        picked = gs.read_fault(path, **words)
        drawn = gs.FaultSticks(path.stem, tuple(taller(stick) for stick in picked.sticks))
        faults[path.stem] = gs.triangulate_fault(drawn, name=path.stem)
    for name in names:
        points = gs.read_points(folder / "horizons_poi" / f"{name}.poi", **words)
        sheet = gs.tear_horizon(points, list(faults.values()), name=name)
        yield f"Drogon sheet {name}", of_sheet(sheet)


def lines(field: bool) -> Iterator[str]:
    """All lines."""
    for title, scene in scenes():
        for what, value in of_scene(scene):
            yield f"{title:28} {what:34} {value}"
        for name, sheet in scene.sheets.items():
            yield f"{title:28} {'sheet ' + name:34} {of_sheet(sheet)}"
    for title, sheet in thrown_sheets():
        yield f"{'throw':28} {title:34} {of_sheet(sheet)}"
    for what, value in of_field() if field else ():
        yield f"{'field':28} {what:34} {value}"


def main() -> None:
    """Print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--field", action="store_true")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    for line in lines(asked.field):
        sys.stdout.write(line + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
