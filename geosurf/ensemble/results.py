"""The results of an ensemble: quantiles, convergence with the number of realisations, tornado."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from geosurf.conventions import counted, did_you_mean, is_number, is_word, volume_text
from geosurf.ensemble.record import expect_ensemble
from geosurf.errors import InputError
from geosurf.model.expected import listed, path_of
from geosurf.model.regions import opposite, sides_of_block
from geosurf.model.units import INCLUDE, INTERVALS

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


# ---- tables ----------------------------------------
# Tables of quantiles, for people and for spreadsheets.


COLUMNS = ("P90", "P50", "P10", "mean", "sd", "present")


def quantile_csv(result: xarray.Dataset, by: str, include: str = "reservoir") -> str:
    """
    Return quantiles as text with commas: volumes in m3.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "region", "block", "contact"}
    include : {"reservoir", "all"}

    Returns
    -------
    str
        One row for each unit or sum; the columns ``n`` and ``failed`` count realisations.
    """
    found, file = quantiles(result, by, include=include), io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    # Units in the names of columns, since a table of text has no attributes.
    writer.writerow([by, *(f"{c}_m3" if c != "present" else c for c in COLUMNS), "n", "failed"])
    for row, name in enumerate(found[by].values.tolist()):
        # repr() keeps all digits.
        numbers = [repr(float(found[column][row])) for column in COLUMNS]
        writer.writerow([name, *numbers, found.attrs["n"], found.attrs["failed"]])
    return file.getvalue()


def quantile_text(result: xarray.Dataset, by: str = "contact", include: str = "reservoir") -> str:
    """
    Return quantiles as a table for the console: volumes in million m3.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "region", "block", "contact"}
    include : {"reservoir", "all"}

    Returns
    -------
    str
    """
    found = quantiles(result, by, include=include)
    names = found[by].values.tolist()
    width = max(len(by), *map(len, names))
    lines = [
        f"GRV [million m³] of {found.attrs['n']} realisations, {found.attrs['failed']} failed",
        f"{by:<{width}}" + "".join(f"{column:>12}" for column in COLUMNS[:3]),
    ]
    for row, name in enumerate(names):
        # Million cubic metres, as in messages.
        numbers = (float(found[column][row]) / 1e6 for column in COLUMNS[:3])
        lines.append(f"{name:<{width}}" + "".join(f"{number:12.3f}" for number in numbers))
    return "\n".join([*lines, *filter(None, [left_out(result, include)])])


BY = ("unit", "zone", "region", "block", "contact")
EXCEEDED = (90, 50, 10)  # %: P90 is exceeded by 90 % of the realisations
LEAST = 10  # realisations for a tornado
TAIL = 0.2  # of the realisations: those with a low or high value of a parameter


def open_ensemble(store: str | os.PathLike[str]) -> xarray.Dataset:
    """
    Return the results in the store of an ensemble; also while it is running.

    Parameters
    ----------
    store : path-like
        As for `run_ensemble`.

    Returns
    -------
    xarray.Dataset
        As from `run_ensemble`, in memory. Realisations that have not run have status 0.

    Raises
    ------
    InputError
        If there is no ensemble.
    """
    from geosurf.ensemble.on_dask import require_extra

    require_extra()
    path = path_of(store, "open_ensemble")
    # The marker of a Zarr group: another folder is an error before it is opened.
    if not (path / ".zgroup").is_file():
        raise InputError(f"{path} is not an ensemble. Give the store= of run_ensemble.")
    opened = xr.open_zarr(path, consolidated=False, chunks=None, mask_and_scale=False)
    # Sums of single regions are for continuing only.
    hidden = [name for name in opened.data_vars if str(name).startswith("region_")]
    result: xarray.Dataset = opened.drop_vars(hidden).load()
    opened.close()
    for name in [*result.variables]:
        if result[name].dtype.kind == "T":  # texts of Zarr: as other results have them
            values = result[name].values.astype(object)
            result = (
                result.assign_coords({name: (result[name].dims, values)})
                if name in result.coords
                else result.assign({name: (result[name].dims, values)})
            )
    result = result.set_coords(["zone", "block", "contact", "parameter_unit"])
    words = [*result.attrs.pop("regions", ())]  # stores that were begun earlier do not state them
    names = regions_of(result.zone.values, result.block.values, words)
    result = result.assign_coords(region=("unit", np.array(names, dtype=object)))
    # Stores that were begun earlier have no distributions in words.
    if "parameter_distribution" in result:
        result = result.set_coords("parameter_distribution")
    if "juxtaposed_area" in result:
        result = result.set_coords(["fault", "hanging_zone", "foot_zone"])
    # Realisations that have not run have no volume; 0 would mean an absent unit.
    unfinished = result.status.values == 0
    result["volume"] = result.volume.where(~unfinished[:, None])
    return result


def regions_of(zones: Sequence[str], blocks: Sequence[str], words: Sequence[str]) -> list[str]:
    """
    Return the region of the base case that each block of a zone belongs to; '' for none.

    A block that the base case does not have belongs to the region of one that lies on no opposite
    side of a fault, and on the most sides that it lies on: of several the first, in the largest
    region.

    Examples
    --------
    >>> base = ["T/B", "F1+", "A", "T/B", "F1-", "B"]
    >>> regions_of(["T/B", "T/B", "below B"], ["F1-", "F1+ F2-", "whole"], base)
    ['B', 'A', '']
    """
    known = list(zip(words[0::3], words[1::3], words[2::3], strict=True))
    exact = {(zone, block): region for zone, block, region in known}
    found = []
    for zone, block in zip(zones, blocks, strict=True):
        sides = sides_of_block(block)
        others = {opposite(side) for side in sides}
        fits = [
            (len(sides & sides_of_block(other)), -k, region)
            for k, (its_zone, other, region) in enumerate(known)
            if its_zone == zone and not others & sides_of_block(other)
        ]
        found.append(exact.get((zone, block)) or max(fits, default=(0, 0, ""))[2])
    return found


def included(result: xarray.Dataset, include: str) -> xarray.Dataset:
    """Return results of the units that tables show; these are all that is in them.

    Raises
    ------
    InputError
        For another word than ``"reservoir"`` and ``"all"``.
    """
    if not is_word(include, INCLUDE):
        raise InputError(f"include is {include!r}; it must be one of {', '.join(INCLUDE)}.")
    zones = result.attrs.get("reservoir")  # stores that were begun earlier do not state it
    if zones is not None and include != "all":
        result = result.isel(unit=np.flatnonzero(np.isin(result.zone.values.astype(str), zones)))
    found: xarray.Dataset = result.assign_attrs()  # a copy, in which nothing is left to leave out
    found.attrs.pop("reservoir", None)
    return found


def left_out(result: xarray.Dataset, include: str) -> str:
    """How many units tables leave out, their volume, and how to see them; '' for none."""
    part = included(result, include)
    n = result.sizes["unit"] - part.sizes["unit"]
    if not n:
        return ""
    rest = volume_text(float(result.base_volume.sum() - part.base_volume.sum()))
    return (
        f"Not shown: {counted(n, 'unit')} outside the reservoir, {rest} in the base case. To list "
        'them: include="all" (in a scenario: in [output]).'
    )


def volumes_by(
    result: xarray.Dataset, by: str = "unit", include: str = "reservoir"
) -> xarray.DataArray:
    """
    Return the volumes of realisations that were built, unit by unit or summed.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "region", "block", "contact"}
        Over what units are summed. ``"contact"``: zone and contact interval.
    include : {"reservoir", "all"}
        ``"all"``: also over- and underburden, which the results hold as well.

    Returns
    -------
    xarray.DataArray
        (realization, by) [m3].

    Raises
    ------
    InputError
        For another word, or if no realisation was built.
    """
    expect_ensemble(result, "volumes_by")
    result = included(result, include)
    if not is_word(by, BY):
        raise InputError(
            f"by is {by!r}; it must be one of {', '.join(BY)}.{did_you_mean(str(by), BY)}"
        )
    # Failed realisations take no part in statistics.
    rows = np.flatnonzero(result.status.values == 1)
    if not len(rows):
        raise InputError("no realisation of this ensemble has been built, so it has no volumes.")
    volume: xarray.DataArray = result.volume.isel(realization=rows)
    if by == "unit":
        return volume
    labels, names = _labels(result, by)
    sums = np.stack(
        [volume.values[:, [k for k, one in enumerate(labels) if one == name]].sum(axis=1)
         for name in names], axis=1,
    )  # fmt: skip
    return xr.DataArray(
        sums, dims=("realization", by), attrs={"units": "m3"}, name="volume",
        coords={"realization": volume.realization.values, by: np.array(names, dtype=object)},
    )  # fmt: skip


def _labels(result: xarray.Dataset, by: str) -> tuple[list[str], list[str]]:
    """The sum that each unit is a part of, and all sums in the order of units, each once.

    Parts of a zone go from above its contacts to below them: the first block of a zone may lack
    some of them.
    """
    labels = result[by].values.tolist()
    if by != "contact":
        return labels, list(dict.fromkeys(labels))
    zones = result.zone.values.tolist()
    place = {zone: k for k, zone in enumerate(dict.fromkeys(zones))}
    sums = [f"{zone} {part}".strip() for zone, part in zip(zones, labels, strict=True)]
    order = {
        name: (place[zone], INTERVALS.get(part.partition(" ")[0], 0))
        for name, zone, part in zip(sums, zones, labels, strict=True)
    }
    return sums, sorted(order, key=order.__getitem__)


def quantiles(
    result: xarray.Dataset,
    by: str = "unit",
    exceeded: tuple[float, ...] = EXCEEDED,
    include: str = "reservoir",
) -> xarray.Dataset:
    """
    Return P90, P50 and P10 of volumes, their mean and the base case.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    by : {"unit", "zone", "region", "block", "contact"}
        As for `volumes_by`.
    exceeded : tuple of float
        Percentages: P90 is the volume that 90 % of the realisations exceed.
    include : {"reservoir", "all"}
        As for `volumes_by`.

    Returns
    -------
    xarray.Dataset
        Over `by`: ``P90``, ``P50``, ``P10``, ``mean``, ``sd`` [m3], ``present``: share of the
        realisations in which the volume is above 0. ``attrs["n"]`` counts realisations that were
        built, ``attrs["failed"]`` the others.

    Raises
    ------
    InputError
        For percentages outside of 0 to 100.

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> shift = gs.ensemble.DepthShift("Top", gs.ensemble.Uniform(-10.0, 10.0))
    >>> found = gs.ensemble.quantiles(gs.run_ensemble(scene, 20, uncertain=[shift]), by="zone")
    >>> bool((found.P90 <= found.P50).all() and (found.P50 <= found.P10).all()), found.attrs["n"]
    (True, 20)
    """
    for one in listed(exceeded, "quantiles takes percentages", "exceeded=(90, 50, 10)"):
        if not (is_number(one) and 0 <= one <= 100):
            raise InputError(f"exceeded has {one!r}; give percentages from 0 to 100.")
    expect_ensemble(result, "quantiles")
    result = included(result, include)
    volume = volumes_by(result, by)
    values = volume.values
    metric = {"units": "m3"}
    data: dict[str, Any] = {
        # P90 is exceeded by 90 %: the lower tail, as reserves are quoted.
        f"P{one:g}": (by, np.quantile(values, 1.0 - one / 100.0, axis=0), metric)
        for one in exceeded
    }
    data["mean"] = (by, values.mean(axis=0), metric)
    data["sd"] = (by, values.std(axis=0, ddof=1 if len(values) > 1 else 0), metric)
    # How often a unit exists at all, which volumes alone do not show.
    data["present"] = (by, (values > 0).mean(axis=0), {"units": "1"})
    coords: dict[str, Any] = {by: volume[by].values}
    labels, names = _labels(result, by)
    base = result.base_volume.values
    sums = [math.fsum(base[[one == name for one in labels]].tolist()) for name in names]
    data["base"] = (by, np.array(sums), metric)
    if by == "unit":
        coords |= {k: (by, result[k].values) for k in BY[1:] if k in result.coords}
    attrs = {"n": len(values), "failed": int((result.status.values == 2).sum())}
    return xr.Dataset(data, coords=coords, attrs=attrs)


def convergence(
    result: xarray.Dataset, name: str, by: str = "unit", include: str = "reservoir"
) -> xarray.Dataset:
    """
    Return how P90, P50, P10 and the mean of one volume settle with the number of realisations.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    name : str
        Of a unit, or of what `by` sums over.
    by : {"unit", "zone", "region", "block", "contact"}
    include : {"reservoir", "all"}
        As for `volumes_by`.

    Returns
    -------
    xarray.Dataset
        Over ``n``, from 2 to all that were built: ``P90``, ``P50``, ``P10``, ``mean`` and
        ``standard_error`` of the mean [m3].

    Raises
    ------
    InputError
        For an unknown name, or an ensemble of less than two realisations.
    """
    values = _one(result, name, by, include)
    if len(values) < 2:
        raise InputError("convergence needs at least two realisations. Give a larger n.")
    # From two on: one realisation has no spread.
    counts = np.arange(2, len(values) + 1)
    metric = {"units": "m3"}
    data: dict[str, Any] = {
        f"P{one}": ("n", np.array([np.quantile(values[:n], 1 - one / 100) for n in counts]), metric)
        for one in EXCEEDED
    }
    data["mean"] = ("n", np.array([values[:n].mean() for n in counts]), metric)
    # Standard error of the mean: by how much more realisations could still move it.
    errors = np.array([values[:n].std(ddof=1) / np.sqrt(n) for n in counts])
    data["standard_error"] = ("n", errors, metric)
    return xr.Dataset(data, coords={"n": counts}, attrs={"name": name})


def tornado(
    result: xarray.Dataset, name: str, by: str = "unit", include: str = "reservoir"
) -> xarray.Dataset:
    """
    Return how strongly each parameter moves one volume, the strongest first.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble`.
    name : str
        Of a unit, or of what `by` sums over.
    by : {"unit", "zone", "region", "block", "contact"}
    include : {"reservoir", "all"}
        As for `volumes_by`.

    Returns
    -------
    xarray.Dataset
        Over ``parameter``: ``rank_correlation`` (Spearman, -1 to 1), and ``low`` and ``high``: the
        mean volume of the fifth of the realisations with its lowest and highest values [m3].
        ``attrs["noise"]``: smaller rank correlations may be chance.

    Raises
    ------
    InputError
        For an unknown name, or an ensemble of less than ten realisations.

    Notes
    -----
    It takes the realisations as they are: no model is built for it, parameters interact as they do
    in the ensemble, and a field counts by its mean. See docs/guides/ensembles.md.
    """
    values = _one(result, name, by, include)
    if len(values) < LEAST:
        raise InputError("a tornado needs at least ten realisations. Give a larger n.")
    # Rows of the volumes: realisations that were built.
    drawn = result.drawn.values[result.status.values == 1]
    n_tail = max(1, round(TAIL * len(values)))
    rows = []
    # Both measures need no assumption about the shape of the dependence.
    for column in drawn.T:
        order = np.argsort(column, kind="stable")
        low, high = values[order[:n_tail]].mean(), values[order[-n_tail:]].mean()
        rows.append((_rank_correlation(column, values), low, high))
    table = np.array(rows).reshape(-1, 3)
    # Widest bar first, as a tornado is drawn.
    order = np.argsort(-np.abs(table[:, 2] - table[:, 1]), kind="stable")
    metric = {"units": "m3"}
    return xr.Dataset(
        {
            "rank_correlation": ("parameter", table[order, 0], {"units": "1"}),
            "low": ("parameter", table[order, 1], metric),
            "high": ("parameter", table[order, 2], metric),
        },
        coords={"parameter": result.parameter.values[order]},
        attrs={"name": name, "mean": float(values.mean()), "noise": 2.0 / np.sqrt(len(values))},
    )


def _one(result: xarray.Dataset, name: str, by: str, include: str) -> np.ndarray:
    """Volumes of one unit, or of one sum of them."""
    volume = volumes_by(result, by, include)
    known = volume[by].values.tolist()
    if not is_word(name, known):
        raise InputError(
            f"no {by} is called {name!r}; there are {', '.join(map(str, known))}."
            f"{did_you_mean(str(name), known)}"
        )
    values: np.ndarray = volume.values[:, known.index(name)]
    return values


def _rank_correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Spearman's rank correlation; 0 where one of them does not vary."""
    # The correlation of ranks, which ignores how values are spread.
    a, b = (_ranks(values) for values in (one, other))
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / size if size > 0 else 0.0


def _ranks(values: np.ndarray) -> np.ndarray:
    """Ranks from 0, equal values sharing their mean rank."""
    _, inverse, count = np.unique(values, return_inverse=True, return_counts=True)
    # Equal values share the mean of their ranks.
    last = np.cumsum(count)
    ranks: np.ndarray = (last - 0.5 * (count + 1.0))[inverse]
    return ranks
