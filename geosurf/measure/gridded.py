"""Put a horizon of a model on the nodes of a grid, and state what that loses at its faults."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from geosurf.conventions import counted, length_text
from geosurf.errors import GeosurfWarning
from geosurf.measure.columns import cross_columns
from geosurf.measure.faces import edge_keys, faces_of
from geosurf.measure.thickness import nodes_of
from geosurf.model import Patches, Units

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


def horizon_on_grid(
    patches: Patches, units: Units, horizon: str, grid: Any = None
) -> tuple[xarray.DataArray, GeosurfWarning | None]:
    """
    Return a horizon as a grid, and what it loses at faults, if it does.

    Parameters
    ----------
    patches, units : Patches, Units
    horizon : str
    grid : None, float or xarray object
        As for `thickness_map`.

    Returns
    -------
    (xarray.DataArray, GeosurfWarning or None)
        See `Scene.horizon_grid`.
    """
    nodes, faces = nodes_of(grid, units.box), faces_of(patches, units, horizon, "horizon")
    west, east, south, north = units.box[:4]
    middle = np.array([0.5 * (west + east), 0.5 * (south + north)]) - faces.origin[:2]
    met = cross_columns(faces.x, faces.triangles, nodes.feet - faces.origin[:2], middle)
    values = np.full(len(nodes.feet), -np.inf)
    np.maximum.at(values, met.foot, met.elevation + faces.origin[2])
    count = np.bincount(met.foot, minlength=len(values))
    attrs = {"units": "m", "positive": "up", "long_name": f"elevation of {horizon}"}
    found = xr.DataArray(
        np.where(count > 0, values, np.nan).reshape(nodes.shape),
        nodes.coords, nodes.dims, horizon, attrs,
    )  # fmt: skip

    # rims of the horizon on faults: both walls, where they are apart
    key, uses = np.unique(edge_keys(faces.triangles, len(faces.x)), return_counts=True)
    ends = np.stack(np.divmod(key[uses == 1], len(faces.x)), axis=1)
    rows = [i for i, source in enumerate(patches.sources) if source.role == "fault"]
    on_fault = np.isin(faces.point, patches.triangles[np.isin(patches.surface_of_triangle, rows)])
    a, b = faces.x[ends[on_fault[ends].all(axis=1)]].transpose(1, 0, 2)
    length, doubled = float(np.linalg.norm(b - a, axis=1).sum()), int((count > 1).sum())
    if not length and not doubled:
        return found, None
    lost = (
        f"The grid of horizon {horizon!r} has no walls at faults: along {length_text(length)} of "
        "cut-offs it ends or slopes within one cell of them. "
        f"{counted(int((count == 0).sum()), 'node')} in fault gaps or outside the model have no "
        f"value; {counted(doubled, 'node')} where the horizon is doubled, as at reverse faults, "
        "have the upper elevation."
    )
    found.attrs["lost"] = lost
    remedy = "Write scene.patches.surface(name) to keep the walls, or give smaller cells: grid=25."
    return found, GeosurfWarning("grid", horizon, lost, remedy)
