"""Files that others made: what `gs.info` names them, and whether other packages agree."""

from __future__ import annotations

from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.folders import drogon_folder
from benchmarks.formats.peers import Peers
from benchmarks.formats.subjects import difference
from geosurf.read.file_info import kind_of_file, points_of_file

SUFFIXES = (".gri", ".poi", ".pol", ".ts", ".ml", ".vs", ".zmap", ".csv")


def field_rows(peers: Peers) -> list[tuple[str, ...]]:
    """File, format, function, number of points, and the differences of other packages."""
    folder = drogon_folder()
    paths = [path for path in sorted(folder.rglob("*")) if path.suffix in SUFFIXES]
    tasks = [(name, path) for path in paths for name in peers.knowing(path.suffix)]
    answers = peers.read(tasks)
    rows = []
    for path in paths:
        found = gs.info(path)
        key, function = kind_of_file(path)
        points = points_of_file(path, key, function) if found.count else np.empty((0, 3))
        points = points[np.isfinite(points).all(axis=1)]
        said = [
            f"{name} {_compared(points, answer)}"
            for (name, one), answer in zip(tasks, answers, strict=True)
            if one == path
        ]
        what = str(path.relative_to(folder)), found.format, f"`{found.read_with}`"
        rows.append((*what, str(found.count), "; ".join(said) or "no peer"))
    return rows


def _compared(points: np.ndarray, answer: dict[str, Any]) -> str:
    """A difference in metres, whichever way z points in the other package; or its answer."""
    if "error" in answer:
        return f"refuses ({answer['error'].split(':')[0]})"
    other = np.load(answer["points"])
    if other.shape[1] == 3 and len(points) and len(other):
        # trees are slow where all places are kilometres away: only the nearer direction is compared
        level, theirs = points[:, 2].mean(), other[:, 2].mean()
        other = other * [1.0, 1.0, -1.0 if abs(level + theirs) < abs(level - theirs) else 1.0]
    least = difference(points, other)
    return "0" if least == 0.0 else f"{least:.1e}"


__all__ = ["field_rows"]
