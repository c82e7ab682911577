"""The rows that users wait for, on this checkout and on another one, in turns.

``python -m benchmarks.side_by_side --other FOLDER [--rounds 3] [--only WORD]``: each row runs in a
process of its own, first here, then there, and so on; the least time of each side counts. Only
public names that both checkouts have are used. Drogon's rows need the shared data folder.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
REPEATS = 3
Run = Callable[[], Any]


def _grid(n: int, bend: float, level: float) -> Any:
    import xarray as xr

    x = np.linspace(0.0, 10_000.0, n)
    z = level + bend * np.sin(x / 900.0)[None, :] * np.cos(x / 1100.0)[:, None]
    attrs = {"units": "m", "positive": "up"}
    return xr.DataArray(z, {"northing": x, "easting": x}, ("northing", "easting"), attrs=attrs)


def _plane(name: str, x: float, dip: float = 0.4) -> Any:
    import geosurf as gs

    y, z = (-500.0, 10_500.0), (-4000.0, 0.0)
    corners = [(x - dip * up, north, up) for up in z for north in y]
    return gs.TriSurface(name, "fault", corners, [[0, 1, 2], [1, 3, 2]])


def _field(n: int, **more: Any) -> Any:
    import geosurf as gs

    horizons = {f"H{k}": _grid(n, 40.0, -1500.0 - 150.0 * k) for k in range(5)}
    faults = {f"F{k}": _plane(f"F{k}", 1500.0 + 3000.0 * k) for k in range(3)}
    return gs.Scene(horizons, faults, (100, 9900, 100, 9900, -2600.0, -1200.0), **more)


def _drogon() -> tuple[dict[str, Any], dict[str, Any]]:
    import geosurf as gs

    shared = Path(os.environ.get("GEOSURF_SHARED", ROOT.parent / "shared"))
    folder, words = shared / "data" / "drogon", {"positive": "down", "length_unit": "m"}
    faults = {
        path.stem: gs.read_fault(path, **words)
        for path in sorted((folder / "fault_sticks_pol").glob("F*.pol"))
    }
    names = ("TopVolantis", "TopTherys", "TopVolon", "BaseVolantis")
    points = {n: gs.read_points(folder / "horizons_poi" / f"{n}.poi", **words) for n in names}
    return points, faults


def rows() -> dict[str, Callable[[], Run]]:
    """Name of each row -> what prepares it, and returns what is timed."""
    import geosurf as gs

    def pair(n: int, mesh: bool) -> list[Any]:
        made = [
            gs.triangulate_horizon(_grid(n, b, -1500.0), name=k) for k, b in (("A", 40), ("B", 5))
        ]
        return (
            [gs.TriSurface(s.name, "horizon", s.vertices, s.triangles) for s in made]
            if mesh
            else made
        )

    def torn() -> Run:
        points, faults = _drogon()
        extend = dict.fromkeys(faults, ("up", "down"))
        return lambda: gs.Scene(points, faults, tear=True, extend=extend).check()

    def ensemble() -> Run:
        from geosurf.ensemble import DepthError

        world = gs.synthetic.torn(n=101)
        flat = dict(world.horizons)
        scene = gs.Scene(flat, world.faults, world.box, tear=True)
        uncertain = [DepthError(list(flat), sd=5.0, range=900.0)]
        return lambda: gs.run_ensemble(
            scene, 12, uncertain=uncertain, workers=1, processes=False, progress=False
        )

    def demo() -> Run:
        import tempfile

        file = ROOT / "data" / "synthetic_horizons" / "faulted_reservoir.toml"
        return lambda: gs.run_scenario(file, tempfile.mkdtemp())

    def moved() -> Run:
        scene = _field(401)
        _ = scene.units
        shift = iter(range(1, 99))
        return lambda: scene.replace(faults={"F1": _plane("F1", 4500.0 + next(shift))}).units

    def measures() -> Run:
        scene = _field(401)
        _ = scene.units
        return lambda: (
            scene.throw("H1", "F1"), scene.thickness("H1/H2"), scene.allan("F1")
        )  # fmt: skip

    curves, split = gs.intersect_surfaces, gs.rebuild_surfaces
    return {
        "curve, two grids of 1e6 triangles": lambda: partial(curves, pair(708, False)),
        "curve, two meshes of 1e5 triangles": lambda: partial(curves, pair(224, True)),
        "split, two grids of 1e6 triangles": lambda: partial(split, pair(708, False)),
        "split, two meshes of 1e5 triangles": lambda: partial(split, pair(224, True)),
        "units, 5 x 401^2, 3 faults": lambda: lambda: _field(401).units,
        "certificate, 5 x 401^2, 3 faults": lambda: _field(401).check,
        "a moved fault, 5 x 401^2": moved,
        "throw and thickness, 5 x 401^2": measures,
        "tear and certificate, Drogon from points": torn,
        "ensemble of a torn horizon, 12 realisations": ensemble,
        "make demo, without installing": demo,
    }


def timed(name: str) -> float:
    """The least seconds of some repeats of a row, in this process."""
    warnings.simplefilter("ignore")
    best = math.inf
    run = rows()[name]()
    run()  # kernels are loaded, files are in memory
    for _ in range(REPEATS):
        fresh = rows()[name]() if name.startswith(("certificate", "throw")) else run
        start = time.perf_counter()
        fresh()
        best = min(best, time.perf_counter() - start)
    return best


def _child(folder: Path, name: str) -> float:
    code = (
        f"import sys; sys.path.insert(0, {str(folder)!r}); import importlib.util as u; "
        f"s = u.spec_from_file_location('rows', {str(Path(__file__).resolve())!r}); "
        "m = u.module_from_spec(s); s.loader.exec_module(m); "
        f"print('seconds', m.timed({name!r}))"
    )
    environment = {**os.environ, "PYTHONPATH": str(folder), "GEOSURF_PROGRESS": "off"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    found = [line.split()[1] for line in done.stdout.splitlines() if line.startswith("seconds ")]
    if not found:
        sys.stderr.write(f"{folder}, {name}:\n{done.stderr[-2000:]}\n")
    return float(found[0]) if found else math.nan


def main() -> None:
    """Print one line for each row, and the geometric mean of all ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--other", type=Path, required=True, help="another checkout")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="rows with this word")
    asked = parser.parse_args()
    ratios = []
    print(f"{'':46}{'here [s]':>10}{'there [s]':>11}{'ratio':>8}")
    for name in rows():
        if asked.only not in name:
            continue
        both = [
            [_child(folder, name) for folder in (ROOT, asked.other.resolve())]
            for _ in range(asked.rounds)
        ]
        here, there = np.nanmin(np.array(both), axis=0)
        ratios.append(here / there)
        print(f"{name:46}{here:10.4f}{there:11.4f}{here / there:8.2f}", flush=True)
    print(f"geometric mean of {len(ratios)} rows: {math.exp(np.nanmean(np.log(ratios))):.2f}")


if __name__ == "__main__":
    main()
