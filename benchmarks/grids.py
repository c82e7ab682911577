"""Corner-point grids of a field: volumes against the sealed units, inside-out cells, times.

Run as ``python -m benchmarks.grids SCENARIO [CELL ...]``; docs/validation/grids.md has the results.
"""

from __future__ import annotations

import sys
import time
import warnings

import geosurf as gs
from geosurf.scenario.build import build_scene
from geosurf.scenario.validate import read_scenario

LAYERS = 10


def lines_of(scene: gs.Scene, cell: float, min_dip: float | None) -> list[str]:
    """Rows of a table: one grid, and each of its units, without slivers."""
    start = time.process_time()
    grid = gs.build_grid(scene, cell=cell, layers=LAYERS, min_dip=min_dip)
    seconds = time.process_time() - start
    nz, ny, nx = grid.shape
    table = grid.table
    small = {(unit.zone, unit.block) for unit in scene.units.values()} - {
        (unit.zone, unit.block) for unit in scene.units.without_slivers
    }
    head = (
        f"cell {cell:g} m, min_dip {min_dip}: {nx} x {ny} x {nz}, "
        f"{int(grid.inside_out.sum())} inside out, {seconds:.1f} s"
    )
    found = [head]
    for by in ("zone", "unit"):
        sums = table.groupby("zone").sum() if by == "zone" else table
        for row in range(sums.sizes[by]):
            one = sums.isel({by: row})
            name = str(one.zone.item()) if by == "zone" else " ".join(grid.unit_names[row])
            if by == "unit" and grid.unit_names[row] in small:
                continue
            share = float(one.volume / one.exact - 1.0)
            found.append(f"  {name}: {float(one.exact) / 1e6:.2f} million m3, {100 * share:+.2f} %")
    return found


def main() -> None:
    """Build the model once, and its grids."""
    warnings.simplefilter("ignore", gs.GeosurfWarning)
    scene = build_scene(read_scenario(sys.argv[1]))
    for cell in map(float, sys.argv[2:] or ["100"]):
        for min_dip in (15.0, None):
            sys.stdout.write("\n".join(lines_of(scene, cell, min_dip)) + "\n")


if __name__ == "__main__":
    main()
