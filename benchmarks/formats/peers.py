"""Other packages, each in an interpreter of its own, open what was written."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.formats.round_trips import Row
from benchmarks.formats.subjects import difference

READER = Path(__file__).with_name("peer_reader.py")
# which packages know a suffix; those that only share it are left out
KNOWN = {
    "xtgeo": (
        ".gri", ".irap", ".irapbin", ".irapasc", ".irapascii", ".fgr", ".zmap", ".ts", ".pol",
        ".poi", ".xyz", ".egrid", ".roff", ".grdecl",
    ),
    "meshio": (".vtu", ".vtk", ".obj", ".stl", ".ply", ".msh", ".inp"),
    "pyvista": (
        ".vtp", ".vtm", ".vti", ".vtu", ".vtk", ".obj", ".stl", ".ply", ".glb", ".gltf", ".exo",
        ".e",
    ),
    "trimesh": (".obj", ".stl", ".ply", ".glb", ".gltf"),
    "rioxarray": (".asc", ".nc"),
    "geopandas": (".geojson",),
    "pandas": (".csv", ".parquet"),
    "opengeode": (".ts", ".vs", ".pl", ".ml"),
    "resqpy": (".epc",),
}  # fmt: skip


class Peers:
    """
    Interpreters with other packages.

    Parameters
    ----------
    interpreters : sequence of path
        The first one that has a package is used for it.
    folder : pathlib.Path
        For lists of tasks.
    """

    def __init__(self, interpreters: Sequence[str], folder: Path) -> None:
        self.folder = folder
        self.home: dict[str, str] = {}
        self._numbers = itertools.count()
        for interpreter in interpreters:
            for package in self._run(interpreter, []):
                self.home.setdefault(package, interpreter)

    def knowing(self, suffix: str) -> list[str]:
        """Packages at hand that know a suffix."""
        return [name for name, known in KNOWN.items() if suffix in known and name in self.home]

    def read(self, tasks: Sequence[tuple[str, Path]], repeat: int = 1) -> list[dict[str, Any]]:
        """Open files, in one process for each interpreter."""
        found: list[dict[str, Any]] = [{} for _ in tasks]
        for interpreter in set(self.home.values()):
            rows = [k for k, (name, _) in enumerate(tasks) if self.home.get(name) == interpreter]
            listed = [
                {
                    "package": tasks[k][0],
                    "path": str(tasks[k][1]),
                    "repeat": repeat,
                    "out": str(self.folder / f"answer_{next(self._numbers)}.npy"),
                }
                for k in rows
            ]
            answers = self._run(interpreter, listed) if listed else []
            for k, answer in zip(rows, answers, strict=True):
                found[k] = answer
        return found

    def compare(self, rows: Sequence[Row]) -> None:
        """Fill in what the packages make of each file."""
        tasks = [
            (row, name)
            for row in rows
            if row.files and not row.missing and _is_asked(row)
            for name in self.knowing(row.suffix)
        ]
        answers = self.read([(name, row.files[0]) for row, name in tasks])
        for (row, name), answer in zip(tasks, answers, strict=True):
            if "error" in answer:
                row.peers[name] = answer["error"]
            elif row.truth is None:
                row.peers[name] = "opens"
            else:
                row.peers[name] = difference(row.truth, np.load(answer["points"]))

    def _run(self, interpreter: str, tasks: list[dict[str, Any]]) -> list[Any]:
        """Run the reader; its answers."""
        listed = self.folder / "tasks.json"
        listed.write_text(json.dumps(tasks))
        ended = subprocess.run(
            [interpreter, str(READER), str(listed)],
            capture_output=True,
            text=True,
            check=False,
            env={key: word for key, word in os.environ.items() if key != "PYTHONPATH"},
        )
        lines = ended.stdout.strip().splitlines()
        if ended.returncode or not lines:
            raise RuntimeError(
                f"{interpreter} ended with {ended.returncode}: {ended.stderr[-500:]}"
            )
        found: list[Any] = json.loads(lines[-1])
        return found


def _is_asked(row: Row) -> bool:
    """Tables of units hold no places, and NetCDF only horizons that others know."""
    if row.suffix == ".nc":
        return row.kind == "horizon (DataArray)"
    tables = ("Dataset of lines", "Dataset of points", "DataFrame", "Curves", "list of lines")
    return row.suffix not in (".csv", ".parquet") or row.kind in tables


__all__ = ["Peers"]
