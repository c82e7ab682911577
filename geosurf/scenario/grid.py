"""The simulation grid that a scenario asks for: files, a picture and notes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geosurf.model import CornerPointGrid
from geosurf.scenario.keys import GridInput
from geosurf.scene import Scene
from geosurf.warning import collected
from geosurf.write import write

FILES = ("grid.grdecl", "grid.inc")
PICTURE = "section_grid.png"


def write_grid(scene: Scene, wanted: GridInput, folder: Path) -> tuple[CornerPointGrid, list[str]]:
    """Build the grid and write its files; also return what was assumed."""
    from geosurf.grid import build_grid  # loaded by those who want one

    with collected() as found:
        grid = build_grid(scene, wanted.cell_m, wanted.layers, min_dip=wanted.min_dip)
    for name in FILES:
        write(grid, folder / name, name="grid")
    return grid, list(map(str, found))


def draw_grid(grid: CornerPointGrid, folder: Path) -> dict[str, Path]:
    """Draw the row with most active cells; the caption sums up the grid."""
    from geosurf.render import render_grid_section

    row = int(grid.actnum.sum(axis=(0, 2)).argmax()) + 1
    path = render_grid_section(grid, folder / PICTURE, row=row)
    return {f"Simulation grid: {in_words(grid)}": path}


def in_words(grid: CornerPointGrid) -> str:
    """Size of a grid, and how far its volumes are from those of the zones."""
    nz, ny, nx = grid.shape
    zones = grid.table.groupby("zone").sum()
    worst = float(np.abs(zones.volume / zones.exact - 1.0).max())
    return (
        f"{nx} x {ny} x {nz} cells, {int(grid.actnum.sum())} active; volumes of zones within "
        f"{100 * worst:.2g} % of the model"
    )
