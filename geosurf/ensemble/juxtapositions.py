"""Zones that face each other across faults, realisation by realisation: how likely, and how large.

Areas are stored like volumes: one column for each fault and pair of zones, in the order in which
realisations have them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.ensemble.record import PairKey, Record, expect_ensemble
from geosurf.errors import InputError
from geosurf.scene import Scene

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

AREA, COLUMNS = "juxtaposed_area", "region_pairs"
PAIRS = 64  # columns of a chunk


def areas_of(scene: Scene) -> dict[PairKey, float]:
    """
    Return the area of contact of each pair of zones across each fault of a scene [m2].

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes(n=3)
    >>> found = areas_of(Scene(world.horizons, world.faults, world.box))
    >>> [*found][0]
    PairKey(fault='F1', hanging_zone='above Top', foot_zone='above Top')
    """
    areas: dict[PairKey, float] = {}
    for fault in scene.faults_inside:  # one that has left the model has no area in it
        found = scene.juxtaposition(fault)
        sides = (found.zone_plus.values, found.zone_minus.values, found.area.values)
        for plus, minus, area in zip(*(side.tolist() for side in sides), strict=True):
            key = PairKey(fault, str(plus), str(minus))
            areas[key] = areas.get(key, 0.0) + area
    return areas


class PairAreas:
    """The columns of areas in the store of an ensemble.

    Parameters
    ----------
    group : zarr.Group
        Of the ensemble.
    base : dict of PairKey to float
        Of the base case: its pairs come first.
    n, n_region : int
        Numbers of realisations and regions.
    whole : int
        Regions that are written.
    """

    def __init__(
        self, group: Any, base: dict[PairKey, float], n: int, n_region: int, whole: int
    ) -> None:
        self.group = group
        columns = [group[name][:].tolist() for name in PairKey._fields]
        known = int(group[COLUMNS][whole - 1]) if whole else 0
        self.keys = [PairKey(*row) for row in zip(*(c[:known] for c in columns), strict=True)]
        group[AREA].resize((n, group[AREA].shape[1]))
        group[COLUMNS].resize((n_region,))
        self._add(base)

    @staticmethod
    def create(new: Callable[..., Any], region: int) -> None:
        """Create the arrays; `new` creates one of the store."""
        new(AREA, "f8", ("realization", "pair"), (region, PAIRS), units="m2")
        new(COLUMNS, "i4", ("region",), (1,))
        for name in PairKey._fields:
            new(name, str, ("pair",), (PAIRS,))

    def write(self, region: int, at: slice, records: list[Record]) -> None:
        """Write the areas of a region: NaN where a realisation failed, 0 for an absent pair."""
        for record in records:
            self._add(record.juxtaposed)
        if self.keys:
            self.group[AREA][at] = np.array(
                [
                    [np.nan if r.reason else r.juxtaposed.get(key, 0.0) for key in self.keys]
                    for r in records
                ]
            )
        self.group[COLUMNS][region] = len(self.keys)

    def _add(self, keys: Iterable[PairKey]) -> None:
        """Give new pairs a column; those of an interrupted region are written again."""
        known = set(self.keys)
        self.keys += [key for key in keys if key not in known]
        n = len(self.keys)
        for i, name in enumerate(PairKey._fields):
            self.group[name].resize((n,))
            if n:
                self.group[name][:] = np.array([key[i] for key in self.keys], dtype=object)
        area = self.group[AREA]
        if area.shape[1] != n:
            area.resize((area.shape[0], n))


def juxtaposition(result: xarray.Dataset) -> xarray.Dataset:
    """
    Return how likely zones face each other across each fault, and over what area.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble` with maps.

    Returns
    -------
    xarray.Dataset
        Over ``pair``, with ``fault``, ``hanging_zone`` and ``foot_zone``: ``probability``, the
        share of the realisations in which the area is above 0, and ``P90``, ``P50``, ``P10`` and
        ``mean`` of the area [m2].

    Raises
    ------
    InputError
        If the ensemble has no areas, or no realisation was built.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> shift = gs.ensemble.DepthShift("Top", gs.ensemble.Uniform(-9.0, 9.0))
    >>> result = gs.run_ensemble(scene, 3, uncertain=[shift], maps=500.0, progress=False)
    >>> float(juxtaposition(result).probability.max())
    1.0
    """
    import xarray as xr

    expect_ensemble(result, "juxtaposition")
    if AREA not in result.data_vars:
        raise InputError("this ensemble has no areas of juxtaposition. Run it with maps=True.")
    values = result[AREA].values[result.status.values == 1]
    if not len(values):
        raise InputError("no realisation of this ensemble has been built, so it has no areas.")
    area = {"units": "m2"}
    data: dict[str, Any] = {"probability": ("pair", (values > 0).mean(axis=0), {"units": "1"})}
    for key, share in (("P90", 0.1), ("P50", 0.5), ("P10", 0.9)):
        data[key] = ("pair", np.quantile(values, share, axis=0), area)
    data["mean"] = ("pair", values.mean(axis=0), area)
    return xr.Dataset(data, {name: ("pair", result[name].values) for name in PairKey._fields})
