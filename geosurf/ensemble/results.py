"""The results of an ensemble: sums, quantiles, convergence, tornado, tables."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import xarray as xr

from geosurf.conventions import check_word, counted, did_you_mean, is_number, is_word, volume_text
from geosurf.conventions.card import Card
from geosurf.ensemble.on_dask import require_extra
from geosurf.ensemble.record import (
    EXCEEDED,
    LEAST,
    MILLION,
    STATISTICS,
    TOTAL,
    expect_ensemble,
    juxtaposition,
)
from geosurf.ensemble.report import EnsemblePlots
from geosurf.errors import InputError
from geosurf.measure.volumetrics import COLUMNS, FLUIDS
from geosurf.model.base import Noun
from geosurf.model.expected import listed, path_of
from geosurf.model.units import INCLUDE, INTERVALS

LABELS = ("unit", "zone", "region", "block", "contact", "fluid")  # of each unit
FLUIDS_IN_PLACE = ("stoiip", "giip")
TAIL = 0.2  # of the realisations: those with a low or high value of a parameter


class Ensemble(Noun):
    """The realisations of a model, with their volumes and fluids in place.

    All answers are for the reservoir; ``include="all"`` adds over- and underburden. Sums are taken
    in each realisation, and quantiles of these. Realisations that could not be built take no part.
    ``print`` shows P90, P50 and P10 by region and fluid.

    What is summed is `of`: a column of `data`; default ``stoiip``, ``giip`` where there is no oil,
    or the last one that there is. `where` restricts it: ``region="A"``, ``fluid=("oil", "gas")``,
    likewise ``unit``, ``zone``, ``block``, ``contact``.

    Parameters
    ----------
    data : xr.Dataset
        See `run_ensemble`.

    Attributes
    ----------
    data : xr.Dataset

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=9)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2100.0})
    >>> level = gs.ensemble.ContactLevel("OWC", shift=gs.ensemble.Uniform(-10.0, 10.0))
    >>> ensemble = gs.run_ensemble(scene, 20, uncertain=[level], progress=False)
    >>> found = ensemble.quantiles(by="region", fluid="oil")
    >>> bool((found.P90 <= found.P50).all() and (found.P50 <= found.P10).all()), found.attrs["n"]
    (True, 20)
    """

    def __init__(self, data: xr.Dataset) -> None:
        expect_ensemble(data, "Ensemble")
        self.data = data

    # ---- what there is -------------------------------------------------------------------

    @property
    def n_built(self) -> int:
        """Number of realisations that were built."""
        return int((self.data.status == 1).sum())

    @property
    def n_failed(self) -> int:
        """Number of realisations that could not be built: ``data.reason`` has the reasons."""
        return int((self.data.status == 2).sum())

    @property
    def columns(self) -> list[str]:
        """What is counted of each unit, from gross rock volume (``bulk``) to fluids in place."""
        return [name for name in COLUMNS if name in self.data]

    @cached_property
    def parts(self) -> str:
        """What zones consist of: ``"fluid"`` where contacts name fluids, else ``"contact"``."""
        return "fluid" if (self.data.fluid.values != "").any() else "contact"

    @cached_property
    def answers(self) -> list[tuple[str, dict[str, Any]]]:
        """What is asked for first: oil and gas in place, else the rock that holds them."""
        in_place = [k for k in FLUIDS_IN_PLACE if k in self.data and (self.data[k] > 0).any()]
        if in_place:
            return [(name, {}) for name in in_place]
        words = set(self.data[self.parts].values.tolist())
        part = [w for w in sorted(words) if w in FLUIDS[:2] or w.startswith("above ")]
        return [(self.columns[-1], {self.parts: tuple(part)} if part else {})]

    def name(self, of: str | None = None) -> str:
        """Return a column and its unit in words, as ``"STOIIP [million Sm³]"``.

        Parameters
        ----------
        of : str, optional
        """
        attrs = self.data[self._column(of)].attrs
        words = attrs["long_name"].rpartition("(")
        short = words[2].rstrip(")") if words[0] else attrs["long_name"]
        return f"{short} [million {attrs['units'].replace('m3', 'm³')}]"

    # ---- sums and quantiles --------------------------------------------------------------

    def sums(
        self, by: str | Sequence[str] = (), of: str | None = None, include: str = "reservoir",
        **where: Any,
    ) -> xr.DataArray:  # fmt: skip
        """
        Return the sums of each realisation that was built.

        Parameters
        ----------
        by : str or sequence of str
            ``"region"``, ``"zone"``, ``"block"``, ``"contact"``, ``"fluid"``, ``"unit"``, several
            of them, or none for the total.
        of : str, optional
        include : {"reservoir", "all"}
        **where

        Returns
        -------
        xr.DataArray
            (realisation, by ...); 0 where there is no unit.

        Raises
        ------
        InputError
            For an unknown word, or if no realisation was built.
        """
        part, keys, name = self._part(include, where), _keys(by), self._column(of)
        rows = np.flatnonzero(self.data.status.values == 1)
        if not len(rows):
            raise InputError("no realisation of this ensemble has been built, so it has no sums.")
        values, names, _ = _summed(part, part[name].values[rows], keys, self._regions)
        return xr.DataArray(
            values, {"realisation": self.data.realisation.values[rows], **names},
            ("realisation", *keys), name=name, attrs=part[name].attrs,
        )  # fmt: skip

    def quantiles(
        self, by: str | Sequence[str] | None = None, of: str | None = None,
        include: str = "reservoir", exceeded: Sequence[float] = EXCEEDED, **where: Any,
    ) -> xr.Dataset:  # fmt: skip
        """
        Return P90, P50 and P10 of sums, their mean and the base case.

        Parameters
        ----------
        by : str or sequence of str, optional
            As for `sums`. Default: region; of rock also fluid, or contact interval.
        of, include, **where
            As for `sums`.
        exceeded : sequence of float
            Percentages: P90, the low case, is what 90 % of the realisations exceed.

        Returns
        -------
        xr.Dataset
            Over `by`: ``P90``, ``P50``, ``P10``, ``mean``, ``sd``, ``base``, and ``present``: share
            of the realisations in which the sum is above 0. ``attrs["n"]`` counts realisations that
            were built, ``attrs["failed"]`` the others.

        Raises
        ------
        InputError
            As `sums`, and for percentages outside of 0 to 100.
        """
        for share in listed(exceeded, "quantiles takes percentages", "exceeded=(90, 50, 10)"):
            if not (is_number(share) and 0 <= share <= 100):
                raise InputError(f"exceeded has {share!r}; give percentages from 0 to 100.")
        name = self._column(of)
        parts = () if name in FLUIDS_IN_PLACE else (self.parts,)
        keys = ("region", *parts) if by is None else _keys(by)
        sums = self.sums(keys, name, include, **where)
        values, attrs = sums.values, sums.attrs
        data: dict[str, Any] = {
            # P90 is exceeded by 90 %: the lower tail, as reserves are quoted.
            f"P{share:g}": (keys, np.quantile(values, 1.0 - share / 100.0, axis=0), attrs)
            for share in exceeded
        }
        data["mean"] = keys, values.mean(axis=0), attrs
        data["sd"] = keys, values.std(axis=0, ddof=1 if len(values) > 1 else 0), attrs
        # How often a unit exists at all, which volumes alone do not show.
        data["present"] = keys, (values > 0).mean(axis=0), {"units": "1"}
        part = self._part(include, where)
        base, names, _ = _summed(part, part[f"base_{sums.name}"].values[None], keys, self._regions)
        data["base"] = keys, base[0], attrs
        return xr.Dataset(data, names, {"n": len(values), "failed": self.n_failed})

    def convergence(
        self, of: str | None = None, include: str = "reservoir", **where: Any
    ) -> xr.Dataset:
        """
        Return how P90, P50, P10 and the mean of a sum settle with the number of realisations.

        Parameters
        ----------
        of, include, **where
            As for `sums`. Default: the first of `answers`.

        Returns
        -------
        xr.Dataset
            Over ``n``, from 2 to all that were built: ``P90``, ``P50``, ``P10``, ``mean`` and
            ``standard_error`` of the mean.

        Raises
        ------
        InputError
            As `sums`, and for an ensemble of less than two realisations.
        """
        sums = self.answer(of, include, **where)
        values, attrs = sums.values, sums.attrs
        if len(values) < 2:
            raise InputError("convergence needs at least two realisations. Give a larger n.")
        # From two on: one realisation has no spread.
        counts = np.arange(2, len(values) + 1)
        data: dict[str, Any] = {
            f"P{share}": (
                "n", np.array([np.quantile(values[:n], 1 - share / 100) for n in counts]), attrs
            )
            for share in EXCEEDED
        }  # fmt: skip
        data["mean"] = ("n", np.array([values[:n].mean() for n in counts]), attrs)
        # Standard error of the mean: by how much more realisations could still move it.
        errors = np.array([values[:n].std(ddof=1) / np.sqrt(n) for n in counts])
        data["standard_error"] = ("n", errors, attrs)
        return xr.Dataset(data, coords={"n": counts})

    def tornado(
        self, of: str | None = None, include: str = "reservoir", **where: Any
    ) -> xr.Dataset:
        """
        Return how strongly each uncertain input moves a sum, the strongest first.

        Parameters
        ----------
        of, include, **where
            As for `sums`. Default: the first of `answers`.

        Returns
        -------
        xr.Dataset
            Over ``parameter``: ``rank_correlation`` (Spearman, -1 to 1), and ``low`` and ``high``:
            the mean of the fifth of the realisations with its lowest and highest values.
            ``attrs["noise"]``: smaller rank correlations may be chance.

        Raises
        ------
        InputError
            As `sums`, and for an ensemble of less than ten realisations.

        Notes
        -----
        It takes the realisations as they are: no model is built for it, parameters interact as they
        do in the ensemble, and a field counts by its mean. See docs/guides/ensembles.md.
        """
        sums = self.answer(of, include, **where)
        values, attrs = sums.values, sums.attrs
        if len(values) < LEAST:
            raise InputError("a tornado needs at least ten realisations. Give a larger n.")
        # Rows of the volumes: realisations that were built.
        drawn = self.data.drawn.values[self.data.status.values == 1]
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
        return xr.Dataset(
            {
                "rank_correlation": ("parameter", table[order, 0], {"units": "1"}),
                "low": ("parameter", table[order, 1], attrs),
                "high": ("parameter", table[order, 2], attrs),
            },
            coords={"parameter": self.data.parameter.values[order]},
            attrs={"mean": float(values.mean()), "noise": 2.0 / np.sqrt(len(values))},
        )

    def answer(
        self, of: str | None = None, include: str = "reservoir", **where: Any
    ) -> xr.DataArray:
        """Return one sum of each realisation: by default the first of `answers`."""
        if of is None and not where:
            of, where = self.answers[0]
        return self.sums((), of, include, **where)

    def juxtaposition(self, include: str = "reservoir") -> xr.Dataset:
        """
        Return how likely zones face each other across each fault, and over what area.

        Parameters
        ----------
        include : {"reservoir", "all"}
            Pairs with the reservoir on one side at least, or all.

        Returns
        -------
        xr.Dataset
            Over ``pair``, with ``fault``, ``zone_plus`` and ``zone_minus``: ``probability``, the
            share of the realisations in which the area is above 0, and ``P90``, ``P50``, ``P10``
            and ``mean`` of the area [m2].

        Raises
        ------
        InputError
            If the ensemble has no maps, and therefore no areas, or no realisation was built.
        """
        inside = set(self._part(include, {}).zone.values.tolist())
        found = juxtaposition(self.data)
        zones = zip(found.zone_plus.values, found.zone_minus.values, strict=True)
        return found.isel(pair=[k for k, pair in enumerate(zones) if inside.intersection(pair)])

    # ---- tables --------------------------------------------------------------------------

    def to_dataframe(
        self, by: str | Sequence[str] | None = None, include: str = "reservoir", **where: Any
    ) -> pandas.DataFrame:
        """
        Return one row for each realisation and part of the reservoir, with all columns.

        Parameters
        ----------
        by : str or sequence of str, optional
            As for `sums`. Default: region, zone, and fluid or contact interval.
        include, **where
            As for `sums`.

        Returns
        -------
        pandas.DataFrame
            ``realisation``, labels, and the columns that there are; NaN where a realisation failed,
            0 where it does not have a part. ``attrs["units"]`` has the units of measure.
            ``data.drawn.to_pandas()`` has the drawn numbers of each realisation.
        """
        keys = ("region", "zone", self.parts) if by is None else _keys(by)
        part, rows = self._part(include, where), np.flatnonzero(self.data.status.values)
        columns = {}
        for name in self.columns:
            sums, names, count = _summed(part, part[name].values[rows], keys, self._regions)
            columns[name] = sums[:, count > 0].ravel() if keys else sums
        there = np.nonzero(count) if keys else ()
        n = int((count > 0).sum())
        table = {"realisation": np.repeat(self.data.realisation.values[rows], n)}
        for key, at in zip(keys, there, strict=True):
            table[key] = np.tile(np.array(names[key], dtype=object)[at], len(rows))
        frame = pandas.DataFrame({**table, **columns})
        frame.attrs["units"] = {name: self.data[name].attrs["units"] for name in self.columns}
        return frame

    def rows(
        self, of: str | None = None, include: str = "reservoir",
        groups: Sequence[Sequence[str]] | None = None, **where: Any,
    ) -> Iterator[tuple[tuple[str, ...], dict[str, float]]]:  # fmt: skip
        """
        Yield labels and statistics of sums that are not 0 everywhere, for tables.

        Parameters
        ----------
        of, include, **where
            As for `sums`.
        groups : sequence of sequence of str, optional
            What to sum by, one after the other. Default: the total, regions and fluids, where there
            are several.
        """
        if groups is None:
            part = self._part(include, where)
            every: list[Sequence[str]] = [(self.parts,), ("region",), ("region", self.parts)]
            every = every[1:2] if self._column(of) in FLUIDS_IN_PLACE else every
            groups = [(), *(k for k in every if all(len(np.unique(part[w])) > 1 for w in k))]
        for keys in groups:
            quantiles = self.quantiles(keys, of, include, **where)
            for at in np.ndindex(*quantiles.sizes.values()):
                numbers = {key: float(quantiles[key].values[at]) for key in STATISTICS}
                if not keys or any(numbers[key] for key in STATISTICS):
                    yield (
                        tuple(str(quantiles[k].values[i]) for k, i in zip(keys, at, strict=True)),
                        numbers,
                    )

    def left_out(self, include: str) -> str:
        """Return how many units tables leave out, their volume, and how to see them."""
        part, data = self._part(include, {}), self.data
        n = data.sizes["unit"] - part.sizes["unit"]
        if not n or data.bulk.attrs["units"] != "m3":
            return ""
        rest = volume_text(float(data.base_bulk.sum() - part.base_bulk.sum()))
        return (
            f"Not shown: {counted(n, 'unit')} outside the reservoir, {rest} in the base case. To "
            'list them: include="all" (in a scenario: in [output]).'
        )

    def __str__(self) -> str:
        return quantile_text(self)

    def __repr__(self) -> str:
        return f"<Ensemble: {self.n_built} realisations built, {self.n_failed} failed>"

    def _card(self) -> Card:
        """Return P90, P50 and P10 of the answers by region."""
        rows = []
        for column, where in self.answers if self.n_built else ():
            for labels, quantiles in self.rows(column, groups=[(), ("region",)], **where):
                numbers = " / ".join(f"{quantiles[key] / MILLION:.2f}" for key in STATISTICS[:3])
                rows.append(
                    (" ".join((self.name(column), *labels)), f"{numbers} (P90 / P50 / P10)")
                )
        return Card(repr(self)[1:-1], rows)

    # ---- pictures and pages --------------------------------------------------------------

    @property
    def plot(self) -> EnsemblePlots:
        """The charts of the ensemble: ``plot.tornado()``, ``plot.quantiles()`` ..."""
        return EnsemblePlots(self)

    def report(
        self, folder: str | os.PathLike[str], *, title: str = "Ensemble",
        inputs: Mapping[str, Any] | None = None,
        relative_to: str | os.PathLike[str] | None = None, include: str = "reservoir",
    ) -> Path:  # fmt: skip
        """
        Write ``index.html``: quantiles, tornado, convergence, maps and failures.

        The page is one file, which needs no network. Its charts are PNG files, too, in the folder
        ``pictures``.

        Parameters
        ----------
        folder : path-like
            Folder of the page. It is created if it does not exist.
        title : str
            Heading of the page.
        inputs : mapping of str to path-like, optional
            Files that the model was made of: the page lists their paths, sizes and hashes.
        relative_to : path-like, optional
            Folder that printed paths start from. Default: the current folder.
        include : {"reservoir", "all"}
            ``"all"``: also over- and underburden.

        Returns
        -------
        pathlib.Path
            File of the page.

        Raises
        ------
        InputError
            If no realisation was built, or the files or their folder are not named as above.
        OutputError
            If a file cannot be written.
        DependencyError
            If matplotlib, which draws the charts, is not installed.

        Examples
        --------
        >>> import tempfile
        >>> import geosurf as gs
        >>> from geosurf.ensemble import ContactLevel, Uniform
        >>> world = gs.synthetic.tilted_planes(n=3)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2200.0})
        >>> level = ContactLevel("OWC", shift=Uniform(-9.0, 9.0))
        >>> ensemble = gs.run_ensemble(scene, 3, uncertain=[level], progress=False)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     ensemble.report(folder, title="Two planes").name
        'index.html'
        """
        from geosurf.ensemble.report import report_ensemble

        return report_ensemble(
            self, path_of(folder, "report"), str(title), inputs, relative_to, include
        )

    # ---- inner ---------------------------------------------------------------------------

    @property
    def _regions(self) -> list[str]:
        """Names of regions of the base case, the largest first."""
        return list(self.data.attrs.get("regions", ()))

    def _column(self, column: Any) -> str:
        """The name of a column, or an error that lists them."""
        if column is None:
            return self.answers[0][0]
        refusal = f"of is {column!r}; this ensemble has {', '.join(self.columns)}."
        check_word(column, self.columns, refusal, " Others need volumetrics=.")
        return str(column)

    def _part(self, include: str, where: Mapping[str, Any]) -> xr.Dataset:
        """Data of the units that count."""
        if not is_word(include, INCLUDE):
            raise InputError(f"include is {include!r}; it must be one of {', '.join(INCLUDE)}.")
        keep = np.ones(self.data.sizes["unit"], dtype=bool)
        if include != "all" and "reservoir" in self.data.attrs:
            keep &= np.isin(self.data.zone.values.astype(str), self.data.attrs["reservoir"])
        for key, value in where.items():
            check_word(key, LABELS, f"{key!r} does not restrict sums; {', '.join(LABELS)} do.")
            known = list(dict.fromkeys(self.data[key].values.tolist()))
            how = f"give one name or several: {key}={known[-1:]}"
            words = [value] if isinstance(value, str) else listed(value, f"{key} takes names", how)
            for word in words or [None]:
                there = ", ".join(filter(None, known))
                check_word(word, known, f"no {key} is called {word!r}; there are {there}.")
            keep &= np.isin(self.data[key].values.astype(str), words)
        return self.data.isel(unit=np.flatnonzero(keep))


def open_ensemble(store: str | os.PathLike[str]) -> Ensemble:
    """
    Return the results in the store of an ensemble; also while it is running.

    Parameters
    ----------
    store : path-like
        As for `run_ensemble`.

    Returns
    -------
    Ensemble
        As from `run_ensemble`, in memory. Realisations that have not run have status 0.

    Raises
    ------
    InputError
        If there is no ensemble.
    """
    require_extra()
    path = path_of(store, "open_ensemble")
    # The marker of a Zarr group: another folder is an error before it is opened.
    if not (path / ".zgroup").is_file():
        raise InputError(f"{path} is not an ensemble. Give the store= of run_ensemble.")
    opened = xr.open_zarr(path, consolidated=False, chunks=None, mask_and_scale=False)
    # Sums of single batches are for continuing only.
    hidden = [name for name in opened.data_vars if str(name).startswith("batch_")]
    result: xr.Dataset = opened.drop_vars(hidden).load()
    opened.close()
    for name in [*result.variables]:
        if result[name].dtype.kind == "T":  # texts of Zarr: as other results have them
            values = result[name].values.astype(object)
            result = (
                result.assign_coords({name: (result[name].dims, values)})
                if name in result.coords
                else result.assign({name: (result[name].dims, values)})
            )
    labels = (*LABELS[1:], "parameter_unit", "parameter_distribution")
    result = result.set_coords(labels)
    if "juxtaposed_area" in result:
        result = result.set_coords(["fault", "zone_plus", "zone_minus"])
    # Realisations that have not run have no volume; 0 would mean an absent unit.
    unfinished = result.status.values == 0
    for name in COLUMNS:
        if name in result:
            result[name] = result[name].where(~unfinished[:, None])
    return Ensemble(result)


# ---- sums ----------------------------------------


def _keys(by: Any) -> tuple[str, ...]:
    """Words to sum by, or an error that lists them."""
    keys = (by,) if isinstance(by, str) else by
    if not isinstance(keys, list | tuple) or any(not is_word(key, LABELS) for key in keys):
        raise InputError(
            f"by is {by!r}; give one or several of {', '.join(LABELS)}."
            f"{did_you_mean(str(by), LABELS)}"
        )
    return tuple(keys)


def _summed(
    part: xr.Dataset, values: np.ndarray, keys: Sequence[str], regions: Sequence[str]
) -> tuple[np.ndarray, dict[str, Any], np.ndarray]:
    """
    Sum the columns (n, unit) of units with the same labels.

    Returns the sums (n, words of the first key, of the second ...), the words by key in the order
    of tables, and how many units each sum has.
    """
    names = {key: _in_order(key, part[key].values.tolist(), regions) for key in keys}
    at = np.zeros(part.sizes["unit"], dtype=np.int64)
    for key, words in names.items():
        rank = [words.index(word) for word in part[key].values.tolist()]
        at = at * len(words) + np.array(rank, dtype=np.int64)
    shape = tuple(map(len, names.values()))
    n = math.prod(shape)
    # in the order of the columns: the same bytes each time
    sums = [values[:, at == k].sum(axis=1) for k in range(n)]
    count = np.bincount(at, minlength=n).reshape(shape)
    coords = {key: np.array(words, dtype=object) for key, words in names.items()}
    return np.stack(sums, axis=1).reshape(len(values), *shape), coords, count


def _in_order(key: str, words: list[str], regions: Sequence[str]) -> list[str]:
    """Each word once: regions by size, fluids and contact intervals from the top down."""
    unique = list(dict.fromkeys(words))
    if key == "region":
        return sorted(unique, key=[*regions, *unique].index)
    if key == "fluid":
        return sorted(unique, key=[*FLUIDS, *unique].index)
    if key == "contact":
        return sorted(unique, key=lambda word: INTERVALS.get(word.partition(" ")[0], 0))
    return unique


def _rank_correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Spearman's rank correlation; 0 where one of them does not vary."""
    # The correlation of ranks, which ignores how values are spread.
    a, b = (pandas.Series(values).rank().to_numpy() for values in (first, second))
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / size if size > 0 else 0.0


# ---- tables ----------------------------------------
# Tables of an ensemble, for people and for spreadsheets.


def quantile_frame(
    ensemble: Any, by: Sequence[str], include: str = "reservoir"
) -> pandas.DataFrame:
    """
    Return quantiles of all columns as a table.

    Parameters
    ----------
    ensemble : Ensemble
    by : sequence of str
    include : {"reservoir", "all"}

    Returns
    -------
    pandas.DataFrame
        One row for each column and sum that is not 0 everywhere; ``n`` and ``failed`` count
        realisations.
    """
    ends = (ensemble.n_built, ensemble.n_failed)
    rows = [
        [*labels, of, ensemble.data[of].attrs["units"], *(found[key] for key in STATISTICS), *ends]
        for of in ensemble.columns
        for labels, found in ensemble.rows(of, include, [by])
    ]
    return pandas.DataFrame(rows, columns=[*by, "quantity", "units", *STATISTICS, "n", "failed"])


def realisations_csv(ensemble: Any, include: str = "reservoir") -> str:
    """Return one row for each realisation and region as text: rock by fluid, and drawn numbers."""
    data, keys = ensemble.data, ["realisation", "region"]
    frame = ensemble.to_dataframe("region", include).set_index(keys)
    parts = ensemble.to_dataframe(("region", ensemble.parts), include)
    rock = parts.pivot_table("bulk", keys, ensemble.parts, sort=False, dropna=False).fillna(0.0)
    for k, name in enumerate(word for word in rock.columns if word):
        frame.insert(k + 1, f"bulk {name}", rock[name].where(frame.bulk.notna()))
    units = {name: data[name.partition(" ")[0]].attrs["units"] for name in frame.columns}
    frame = frame.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items()})
    drawn = data.drawn.to_pandas()
    drawn.columns = [
        f"{name} [{unit}]"
        for name, unit in zip(data.parameter.values, data.parameter_unit.values, strict=True)
    ]
    made: str = frame.reset_index().join(drawn, on="realisation").to_csv(index=False)
    return made


def quantile_text(ensemble: Any, include: str = "reservoir") -> str:
    """Return P90, P50 and P10 by region and fluid for the console: oil and gas in place first."""
    asked = [column for column, _ in ensemble.answers]
    lines = [f"{counted(ensemble.n_built, 'realisation')}, {ensemble.n_failed} failed"]
    for column in dict.fromkeys([*asked, "bulk"]):
        rows = [
            (" ".join(labels) or TOTAL[include], quantiles)
            for labels, quantiles in ensemble.rows(column, include)
            if not labels or quantiles["P10"] or quantiles["base"]  # others are in the files
        ]
        head = ensemble.name(column)
        width = max(len(head), *(len(label) for label, _ in rows))
        lines += ["", f"{head:<{width}}" + "".join(f"{key:>12}" for key in STATISTICS[:3])]
        for label, quantiles in rows:
            # Millions, as in messages.
            numbers = "".join(f"{quantiles[key] / MILLION:12.3f}" for key in STATISTICS[:3])
            lines.append(f"{label:<{width}}{numbers}")
    return "\n".join([*lines, *filter(None, [ensemble.left_out(include)])])
