"""Keys of a scenario about its simulation grid: ``[grid]``."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.declare import key


@dataclass(frozen=True, kw_only=True)
class GridInput:
    """``[grid]``: a corner-point grid for flow simulators, written as `grid.grdecl` and `grid.inc`.
    See [simulation grids](guides/simulation_grids.md).
    """

    cell_m: float | tuple[float, float] = key(
        "Size of the cells, about: whole numbers of them fill the area.",
        values.cell,
        unit="m",
        default=100.0,
    )
    layers: int | dict[str, Any] = key(
        "Layers of each zone between two horizons, or by zone.", values.layers, default=10
    )
    min_dip: float = key(
        "Pillars follow faults that dip at least this; others are stair-steps.",
        values.dip,
        unit="degrees",
        default=15.0,
    )


__all__ = ["GridInput"]
