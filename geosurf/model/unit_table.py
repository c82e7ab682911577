"""The table of units: volumes, areas and names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

Units = Any  # `Units` of geosurf.model.units, which makes its tables here


def table_of(units: Units) -> xarray.Dataset:
    """Return volumes and areas of all units; ``sliver`` marks the slivers."""
    import xarray as xr

    each = list(units.values())
    columns = {
        "area": ([u.area for u in each], "m2", "area of the closed shell"),
        "map_area": ([u.map_area for u in each], "m2", "area of the upper side in the map"),
        # Where the unit is, as in the picture of the column; a shell without area has no volume.
        "thickness_mean": (
            [u.volume / u.map_area if u.map_area > 0 else 0.0 for u in each],
            "m",
            "mean vertical thickness where the unit is present: volume over map_area",
        ),
    }
    data = {
        key: ("unit", np.array(values, dtype=np.float64), {"units": unit, "long_name": name})
        for key, (values, unit, name) in columns.items()
    }
    attrs = {"box": list(units.box), "box_units": "m", **_crs(units)}
    return xr.Dataset({"volume": volumes_of(units), **data}, labels_of(units), attrs)


def volumes_of(units: Units) -> tuple[tuple[str], np.ndarray, dict[str, Any]]:
    """Return the column of volumes; no area is computed for it."""
    attrs = {"units": "m3", "long_name": "bulk volume", **_crs(units)}
    # Float64 even without units, so that an empty model has the same types.
    return ("unit",), np.array([u.volume for u in units.values()], dtype=np.float64), attrs


def labels_of(units: Units) -> dict[str, tuple[str, np.ndarray]]:
    """Return name, zone and block of each unit, and contact where there are some."""
    each = list(units.values())
    labels = {
        "zone": ("unit", np.array([u.zone for u in each], dtype=object)),
        "block": ("unit", np.array([u.block for u in each], dtype=object)),
        "zone_index": ("unit", np.array([u.zone_index for u in each], dtype=np.int64)),
    }
    if any(u.contact for u in each):
        labels["contact"] = ("unit", np.array([u.contact for u in each], dtype=object))
    if any(u.compartment_of for u in each):
        within = np.array([u.compartment_of for u in each], dtype=object)
        labels["compartment_of"] = ("unit", within)
    # Marked rather than left out, so that volumes of the table add up to the model.
    labels["sliver"] = ("unit", np.array([u.name in units._small for u in each], dtype=bool))
    return {"unit": ("unit", np.array([u.name for u in each], dtype=object)), **labels}


def _crs(units: Units) -> dict[str, str]:
    """The reference system as an attribute of tables, if there is one."""
    return {} if units.crs is None else {"crs": units.crs}
