"""Tetrahedra of whole models: ``python -m benchmarks.tets SCENARIO.toml ...`` (extra ``tet``).

Processor times of `mesh_units`, with the process of TetGen, next to those of the model, errors of
volumes of units, and whether meshio reads the same mesh back.
"""

from __future__ import annotations

import os
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import geosurf as gs
from geosurf.scenario import build_scene, read_scenario

SIZES = (None, 200.0)


def processor_time() -> float:
    """Of this process and of those that ended [s]."""
    return sum(os.times()[:4])


def row(units: gs.Units, size: float | None) -> tuple[gs.TetMesh, str]:
    """A mesh and its row of the table."""
    start = processor_time()
    mesh = gs.mesh_units(units, size)
    taken = processor_time() - start
    error = np.abs(mesh.volumes.values / units.volumes.values - 1.0).max()
    counts = f"{len(mesh.faces)} | {len(mesh.local)} | {len(mesh.tetrahedra)}"
    return mesh, f"{size or 'none'} | {counts} | {taken:.1f} | {error:.1e}"


def read_back(mesh: gs.TetMesh) -> str:
    """The formats that meshio reads back as they were written."""
    import meshio

    agreed = []
    with tempfile.TemporaryDirectory() as folder:
        for suffix in (".vtu", ".msh", ".inp"):
            (path,) = gs.write(mesh, Path(folder) / f"model{suffix}")
            again = meshio.read(path)
            same = np.array_equal(again.cells_dict["tetra"], mesh.tetrahedra)
            if same and np.array_equal(again.points, mesh.vertices):
                agreed.append(f"{suffix} ({path.stat().st_size / 1e6:.0f} MB)")
    return ", ".join(agreed)


def main(paths: list[str]) -> None:
    """Print one row for each scenario and size."""
    warnings.simplefilter("ignore")
    print("| model | units | model [s] | size [m] | faces | vertices | tetrahedra | mesh [s] | largest error |")  # fmt: skip  # noqa: E501
    print("|---|---|---|---|---|---|---|---|---|")
    files = []
    for path in paths:
        start = processor_time()
        units = build_scene(read_scenario(path)).units
        name = f"{Path(path).stem} | {len(units)} | {processor_time() - start:.1f}"
        for size in SIZES:
            mesh, line = row(units, size)
            print(f"| {name} | {line} |", flush=True)
        files.append(read_back(mesh))
    print(f"\nmeshio reads back the last mesh of each: {'; '.join(files)}.")


if __name__ == "__main__":
    main(sys.argv[1:])
