"""Maps of an ensemble, from sums over its regions.

Each region has its own sums, of differences from the base case; so regions can be written again
after a kill, and the sum over all of them is the same in any run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from geosurf.ensemble.maps import Layers
from geosurf.ensemble.record import Record

_PARTS = {"region_difference": "f8", "region_square": "f8", "region_present": "i4"}
_MAPS = {
    "thickness_mean": (
        "m",
        "mean vertical thickness over the realisations, 0 where the layer is absent",
    ),
    "thickness_sd": ("m", "standard deviation of the vertical thickness"),
    "probability": ("1", "share of the realisations in which the layer is present"),
}


class MapSums:
    """Sums of maps over the realisations of each region.

    Parameters
    ----------
    group : zarr.Group
        Of the ensemble.
    base : ndarray
        Maps of the base case.
    """

    def __init__(self, group: Any, base: Any) -> None:
        self.group, self.base = group, np.asarray(base, dtype=np.float64)

    @staticmethod
    def create(new: Callable[..., Any], layers: Layers, base: Any) -> None:
        """Create the arrays of maps; `new` creates one of the store."""
        # One chunk per region: it is written once, as a whole.
        n_layer, n_row, n_col = layers.shape
        dims = ("layer", "northing", "easting")
        for name, dtype in _PARTS.items():
            made = new(name, dtype, ("region", *dims), (1, n_layer, n_row, n_col))
            made.resize((0, n_layer, n_row, n_col))
        for name, (unit, words) in _MAPS.items():
            made = new(name, "f8", dims, layers.shape, units=unit, long_name=words)
            made.resize(layers.shape)
        made = new("base_thickness", "f8", dims, layers.shape, units="m")
        made.resize(layers.shape)
        made[:] = base
        # Axes as variables, so that xarray finds them.
        for name, values in (
            ("layer", np.array(layers.names, dtype=object)),
            ("easting", layers.easting),
            ("northing", layers.northing),
        ):
            kind: Any = str if name == "layer" else "f8"
            axis = new(name, kind, (name,), (len(values),))
            axis.resize((len(values),))
            axis[:] = values

    def write(self, region: int, records: list[Record]) -> None:
        """Write the sums of a region."""
        maps = [record.maps for record in records if record.maps is not None]
        # Differences from the base case are small: their squares keep their digits.
        off = np.zeros((2, *self.base.shape))
        present = np.zeros(self.base.shape, dtype=np.int32)
        for one in maps:
            difference = one.astype(np.float64) - self.base
            off[0] += difference
            off[1] += difference * difference
            # A layer is present where it has any thickness.
            present += one > 0
        for name, values in zip(_PARTS, (*off, present), strict=True):
            array = self.group[name]
            if array.shape[0] <= region:
                array.resize((region + 1, *self.base.shape))
            array[region] = values

    def finish(self, n_region: int) -> None:
        """Write mean, standard deviation and probability over all realisations."""
        # Failed realisations have no maps and do not count.
        n = int((self.group["status"][:] == 1).sum())
        total = [np.zeros(self.base.shape) for _ in _PARTS]
        # In the order of regions: the sum is the same in any run.
        for region in range(n_region):
            for sum_, name in zip(total, _PARTS, strict=True):
                sum_ += self.group[name][region]
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = total[0] / n
            # The unbiased variance; rounding may make it slightly negative.
            variance = (total[1] - n * mean * mean) / max(n - 1, 1)
            found = (self.base + mean, np.sqrt(np.maximum(variance, 0.0)), total[2] / n)
        for name, values in zip(_MAPS, found, strict=True):
            self.group[name][:] = values


__all__ = ["MapSums"]
