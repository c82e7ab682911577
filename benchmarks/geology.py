"""Horizons that are torn at faults, as bench scenes, and what is timed of them.

``torn`` is a smeared grid over six faults that die inside it; ``drogon field`` has the points and
sticks of a field, torn, cut, carved, measured and certified: the way from data to volumes.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.folders import drogon_folder
from geosurf.errors import InputError
from geosurf.model import FaultSticks, Sheet
from geosurf.scene import Scene
from geosurf.sheets import tear_horizon
from geosurf.triangulate import triangulate_fault

STEP = 25.0  # m between nodes
FAULTS = 6
THROW, FADE, DIP = 60.0, 1500.0, 60.0
FIELD = ("TopVolantis", "TopTherys", "TopVolon", "BaseVolantis")
DEPTHS = -2100.0, -1400.0
RIM = 4  # nodes that the model stays inside of the field's lattice

NO_SHIFT = 0.0, 0.0, 0.0

Sources = list[tuple[str, str, Any]]


def torn_sources(n: int) -> Sources:
    """A grid of n x n nodes, smeared by one node over six faults that are 0.6 of its side long."""
    from geosurf.synthetic.world import make_fault, make_horizon

    side = (n - 1) * STEP
    axis = np.linspace(0.0, side, n)
    x, y = np.meshgrid(axis, axis)
    z = -1800.0 + 60.0 * np.sin(x / 640.0) * np.cos(y / 640.0) + 15.0 * np.sin((x + y) / 270.0)
    whole, faults, cot = z, [], 1.0 / np.tan(np.radians(DIP))
    half, fade = 0.3 * side, min(FADE, 0.05 * side)
    for k in range(FAULTS):
        turn = np.radians(20.0 if k % 2 else 14.0)
        middle = side * (k + 0.7) / (FAULTS + 0.4), side * (0.45 if k % 2 else 0.55)
        s = (x - middle[0]) * np.sin(turn) + (y - middle[1]) * np.cos(turn)
        r = (x - middle[0]) * np.cos(turn) - (y - middle[1]) * np.sin(turn)
        shift = 0.5 * THROW * np.clip(1.0 - (s / half) ** 2, 0.0, None) * np.exp(-((r / fade) ** 2))
        level = -1800.0 - (r - 20.0 * np.sin(s / 450.0)) / cot  # of the fault below each node
        # the hanging wall where it is above the fault, the footwall below; the fault between both
        z = np.clip(level, z - shift, z + shift)
        along = np.linspace(-half, half, max(round(0.3 * (n - 1)), 4) + 1)[None, :]
        up = np.array([320.0, 0.0, -320.0])[:, None]
        across = 20.0 * np.sin(along / 450.0) - up * cot
        east = middle[0] + along * np.sin(turn) + across * np.cos(turn)
        north = middle[1] + along * np.cos(turn) - across * np.sin(turn)
        faults.append(
            ("fault", f"F{k + 1}", make_fault(f"F{k + 1}", east, north, up - 1800.0, NO_SHIFT))
        )
    mean = sum(z[i : n - 2 + i, j : n - 2 + j] for i in range(3) for j in range(3)) / 9.0
    rough = np.abs(mean - z[1:-1, 1:-1]) > 1.5  # only a tear is so rough
    z[1:-1, 1:-1] = np.where(rough, mean, z[1:-1, 1:-1])
    box = (0.0, side, 0.0, side, whole.min() - 300.0, whole.max() + 300.0)
    return [("horizon", "Top", make_horizon("Top", box, n, lambda *_: z, NO_SHIFT)), *faults]


def taller(stick: np.ndarray) -> np.ndarray:
    """A stick drawn out up and down by a quarter of its height, 20 m at least."""
    stick = stick[np.argsort(-stick[:, 2], kind="stable")]
    stick = stick[np.append(True, np.diff(stick[:, 2]) < 0)]  # one goes back to its top
    reach = max(0.25 * abs(stick[0, 2] - stick[-1, 2]), 20.0)
    up, down = stick[0] - stick[1], stick[-1] - stick[-2]
    ends = [stick[0] + up * reach / abs(up[2]), stick[-1] + down * reach / abs(down[2])]
    return np.vstack([ends[0], stick, ends[1]])


def field_sources() -> tuple[Sources, dict[str, Any]]:
    """Faults of the field as arrays, and points of its horizons by name."""
    from geosurf.read import read_fault, read_points

    folder = drogon_folder() / "drogon"
    words = {"positive": "down", "length_unit": "m"}
    sticks = sorted((folder / "fault_sticks_pol").glob("F*.pol"))
    files = [folder / "horizons_poi" / f"{name}.poi" for name in FIELD]
    if len(sticks) != FAULTS or not all(path.exists() for path in files):
        raise InputError(
            f"{folder}: the points of four horizons and the sticks of six faults are not there. "
            "Set GEOSURF_SHARED to the folder that holds data/drogon."
        )
    sources: Sources = []
    for path in sticks:
        picked = read_fault(path, **words)
        drawn = FaultSticks(path.stem, tuple(taller(stick) for stick in picked.sticks))
        fault = triangulate_fault(drawn, name=path.stem)
        sources.append(("fault", path.stem, (fault.vertices, fault.triangles)))
    return sources, {path.stem: read_points(path, **words) for path in files}


# ---- what is timed -----------------------------------------------------------------------


def inputs(setting: Any, options: dict) -> tuple[dict[str, Any], list]:
    """Data by horizon, and faults made anew."""
    data = setting.truth.get("points") or setting.by_role("horizon")
    return data, [_fault(*source[1:]) for source in setting.sources if source[0] == "fault"]


def _fault(name: str, value: Any):
    from geosurf.model import TriSurface

    if isinstance(value, tuple):
        return TriSurface(name, "fault", *value)
    return triangulate_fault(value, name=name)


def tear_all(made: tuple[dict[str, Any], list], options: dict) -> dict[str, Sheet]:
    """Sheets of all horizons."""
    data, faults = made
    return {name: tear_horizon(value, faults, name=name) for name, value in data.items()}


def sheets_answer(setting: Any, sheets: dict[str, Sheet]) -> dict[str, Any]:
    """Tips and solved nodes of all sheets, and the largest throw [m]."""
    throws = [np.nanmax(cut.throw) for sheet in sheets.values() for cut in sheet.cuts.values()]
    return {
        "tips": sum(sheet.report.tips for sheet in sheets.values()),
        "solved": sum(sheet.report.n_solved for sheet in sheets.values()),
        "throw": float(max(throws)),
    }


def whole_model(made: tuple[dict[str, Any], list], options: dict) -> dict[str, Any]:
    """Sheets, units with volumes, and the certificate; processor seconds of each step."""
    marks = [time.process_time()]

    def lap() -> float:
        """Processor time since the last call [s]."""
        marks.append(time.process_time())
        return marks[-1] - marks[-2]

    sheets = tear_all(made, options)
    parts = {"sheets": lap()}
    first = next(iter(sheets.values()))
    x, y = first.lattice.easting, first.lattice.northing
    rows, cols = (RIM, -1 - RIM, -1 - RIM, RIM), (RIM, RIM, -1 - RIM, -1 - RIM)
    area = np.array([(x[i, j], y[i, j]) for i, j in zip(rows, cols, strict=True)])
    low, high = area.min(axis=0), area.max(axis=0)
    box = (low[0], high[0], low[1], high[1], *DEPTHS)
    scene = Scene(sheets, {fault.name: fault for fault in first.faults}, box, aoi=area)
    scene.patches  # noqa: B018 - asking computes
    parts["cut"] = lap()
    units = scene.units
    parts["units"] = lap()
    scene.volumes  # noqa: B018
    parts["volumes"] = lap()
    certificate = scene.check()
    parts["certificate"] = lap()
    return {"sheets": sheets, "units": units, "certificate": certificate, "parts": parts}


def model_answer(setting: Any, found: dict[str, Any]) -> dict[str, Any]:
    """What came of it, and where processor time went [s]."""
    units = found["units"]
    return sheets_answer(setting, found["sheets"]) | {
        "closed": bool(found["certificate"].ok),
        "units": len(units),
        "volumes": {name: unit.volume for name, unit in units.items()},
        "cpu_seconds_of_parts": found["parts"],
    }
