"""The Zarr store of an ensemble: written region by region, in order, and continued after a kill.

A region is `REGION` realisations in a row. Each finished realisation is first a file of its own in
``.records``, so that a kill at any moment loses none. When all of a region are there, and all
regions before it are written, the region goes into the arrays, its status last. So names of units
are found in the order of the realisations, and the bytes of the store do not depend on workers,
on their order, or on how often a run was interrupted.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from geosurf.ensemble.plan import Plan, vector
from geosurf.ensemble.record import Layers, PairAreas, Record, UnitKey
from geosurf.errors import InputError, OutputError
from geosurf.files.atomic import write_whole
from geosurf.files.folders import Lock
from geosurf.model.expected import path_of

REGION = 20  # realisations
UNITS = 64  # units of one chunk
DONE, FAILED = 1, 2
STATUSES = {0: "not run", DONE: "done", FAILED: "failed"}
RECORDS = ".records"
TEARS = {
    "torn": "horizons that were torn as picked",
    "searched": "horizons among these that the remedies of the base case did not close",
}


def is_finished(path: str | os.PathLike[str], identity: str, n: int) -> bool:
    """Return whether a folder holds all n realisations of an ensemble, so that nothing is built.

    An ensemble whose first realisations all failed is not: it is refused when it is opened.
    """
    import zarr

    folder = path_of(path, "store")
    # `finish` removes the records last
    if not (folder / ".zgroup").is_file() or (folder / RECORDS).exists():
        return False
    try:
        group: Any = zarr.open_group(folder, mode="r", zarr_format=2)
        same = group.attrs.get("identity") == identity
        status = group["status"][:]
        return bool(same and len(status) == n and status.all() and (status[:REGION] == DONE).any())
    except (KeyError, OSError, ValueError):
        return False  # what is wrong with it is said when it is opened to be continued


class EnsembleStore:
    """
    The store of one ensemble.

    Parameters
    ----------
    path : pathlib.Path
        A folder, new or of the same ensemble.
    plan : Plan
        Started.
    base : Record
        Of the base case.
    n : int
        Number of realisations.
    stays : bool
        Whether another call may continue it: finished realisations are files first then.

    Raises
    ------
    InputError
        If the folder holds something else, an ensemble of other inputs, or a longer one, or
        another process writes to it.
    OutputError
        If it cannot be written.
    """

    def __init__(self, path: Path, plan: Plan, base: Record, n: int, *, stays: bool = True) -> None:
        self.path, self.plan, self.base, self.n, self.stays = path, plan, base, n, stays
        self.pending: dict[int, Record] = {}
        # One process at a time: two would write different regions into the same arrays.
        self.lock = Lock(path / ".lock")
        self._keys: list[UnitKey] = []
        try:
            self._open()
        except OSError as error:
            self.lock.release()
            raise self._unwritable(error) from error
        # The folder is given back, so that the next call does not wait for this one.
        except InputError:
            self.lock.release()
            raise

    # ---- open and create -----------------------------------------------------------------

    def _open(self) -> None:
        """Open the store, or create it; another length is the same ensemble."""
        import zarr

        # Only an empty folder or an ensemble: nothing of the user is overwritten.
        stranger = self.path.exists() and (
            not self.path.is_dir()
            or (any(self.path.iterdir()) and not (self.path / ".zgroup").is_file())
        )
        if stranger:
            raise InputError(
                f"{self.path} exists and is not an ensemble. Give the path of a new folder, as in "
                'store="ensemble.zarr".'
            )
        self.path.mkdir(parents=True, exist_ok=True)
        if not self.lock.take():
            raise InputError(
                f"{self.path}: another process writes to this ensemble. Wait for it, or give "
                "another store."
            )
        for left in self.path.rglob("*.partial"):  # of a write that was killed
            left.unlink(missing_ok=True)
        self.group: Any = zarr.open_group(self.path, mode="a", zarr_format=2)
        # Another seed, data or version would mix results that do not belong together.
        known = self.group.attrs.get("identity")
        if known is None:
            self._create()
        elif known != self.plan.identity:
            raise InputError(
                f"{self.path} holds an ensemble of other inputs, uncertainties, maps or seed. Give "
                "another store, or delete this folder."
            )
        self._resize()
        # Columns of finished regions first, then units of the base case.
        self._keys = self._stored_keys()
        self._add_columns(self.base.volumes)
        mapped = self.plan.layers is not None
        self.sums = MapSums(self.group, self.base.maps) if mapped else None
        self.pairs = None
        if mapped:
            sizes = self.n, self.n_region, self._whole_regions()
            self.pairs = PairAreas(self.group, self.base.juxtaposed, *sizes)
        (self.path / RECORDS).mkdir(exist_ok=True)

    def _create(self) -> None:
        """Create all arrays, empty; the identity comes last, so that this can be repeated."""
        n_parameter = len(self.plan.parameters)
        self.array("volume", "f8", ("realization", "unit"), (REGION, UNITS), units="m3")
        # Flags as the CF conventions name them.
        meanings = {"flag_values": [*STATUSES], "flag_meanings": ", ".join(STATUSES.values())}
        self.array("status", "u1", ("realization",), (REGION,), **meanings)
        self.array("reason", str, ("realization",), (REGION,), long_name="why it failed")
        self.array("warnings", "i4", ("realization",), (REGION,), long_name="number of warnings")
        for name, words in TEARS.items():
            self.array(name, "i4", ("realization",), (REGION,), long_name=words)
        self.array("drawn", "f8", ("realization", "parameter"), (REGION, max(1, n_parameter)))
        self.array("realization", "i8", ("realization",), (REGION,))
        self.array("region_units", "i4", ("region",), (1,))
        self.array("base_volume", "f8", ("unit",), (UNITS,), units="m3", long_name="base case")
        for name in UnitKey._fields:
            self.array("unit" if name == "name" else name, str, ("unit",), (UNITS,))
        for name, values in (
            ("parameter", self.plan.parameters), ("parameter_unit", self.plan.units),
            ("parameter_distribution", self.plan.distributions),
        ):  # fmt: skip
            made = self.array(name, str, ("parameter",), (max(1, n_parameter),))
            if values:
                made.resize((n_parameter,))
                made[:] = np.array(values, dtype=object)
        if self.plan.layers is not None:
            MapSums.create(self.array, self.plan.layers, self.base.maps)
            PairAreas.create(self.array, REGION)
        self.group.attrs.update(
            {"title": "geosurf ensemble", "seed": str(self.plan.seed),
             "reservoir": list(self.plan.reservoir), "regions": self.plan.regions,
             "identity": self.plan.identity}
        )  # fmt: skip

    def array(
        self, name: str, dtype: Any, dims: tuple[str, ...], chunks: tuple[int, ...], **attrs: Any
    ) -> Any:
        """Create an empty array without compression: compressors may differ between machines."""
        fill = "" if dtype is str else 0
        return self.group.create_array(
            name, shape=(0,) * len(dims), chunks=chunks, dtype=dtype, fill_value=fill,
            compressors=None, overwrite=True,
            attributes={"_ARRAY_DIMENSIONS": list(dims), **attrs},
        )  # fmt: skip

    def _resize(self) -> None:
        """Make the arrays as long as the ensemble."""
        # Longer is the same ensemble with more realisations; shorter would drop results.
        known = self.group["realization"].shape[0]
        if known > self.n:
            raise InputError(
                f"{self.path} holds {known} realisations, more than n={self.n}. Give n={known} or "
                "more (at the command line -n), or another store (at the command line -o)."
            )
        for name in ("volume", "status", "reason", "warnings", *TEARS, "drawn"):
            one = self.group[name]
            one.resize((self.n, *one.shape[1:]))
        drawn = self.group["drawn"]
        drawn.resize((self.n, len(self.plan.parameters)))
        self.group["region_units"].resize((self.n_region,))
        self.group["realization"].resize((self.n,))
        self.group["realization"][:] = np.arange(self.n)

    def _stored_keys(self) -> list[UnitKey]:
        """Units that have a column, those of the base case first, as far as regions are whole."""
        columns = [self.group[name][:].tolist() for name in ("unit", *UnitKey._fields[1:])]
        # Names of a region that was interrupted do not count: they may be incomplete.
        whole = self._whole_regions()
        n = int(self.group["region_units"][whole - 1]) if whole else 0
        return [UnitKey(*row) for row in zip(*(c[:n] for c in columns), strict=True)]

    def _whole_regions(self) -> int:
        """Number of regions that are whole, from the first."""
        status = self.group["status"][:]
        whole = [bool(status[r.start : r.stop].all()) for r in map(self.rows, range(self.n_region))]
        return whole.index(False) if False in whole else self.n_region

    # ---- what is there -------------------------------------------------------------------

    @property
    def n_region(self) -> int:
        """Number of regions."""
        return -(-self.n // REGION)

    def rows(self, region: int) -> range:
        """Realisations of a region."""
        return range(region * REGION, min((region + 1) * REGION, self.n))

    def missing(self) -> list[int]:
        """Load finished records that are in no region yet; return the realisations to run."""
        # From the first incomplete region on, records decide and not the arrays.
        self.status = self.group["status"][:]
        self.next_region = self._whole_regions()
        self.status[self.next_region * REGION :] = 0
        for file in sorted((self.path / RECORDS).glob("*.npz")):
            try:
                record = Record.from_bytes(file.read_bytes())
            except (OSError, ValueError, KeyError, EOFError, BadZipFile):
                continue  # damaged by a crash of the machine: it is run again
            # Records of regions that are written already are left-overs.
            if self.next_region * REGION <= record.realization < self.n:
                self.pending[record.realization] = record
        self._write_regions()
        first = self.next_region * REGION
        return [k for k in range(first, self.n) if k not in self.pending]

    # ---- write ---------------------------------------------------------------------------

    def add(self, record: Record) -> None:
        """Store a finished realisation.

        Raises
        ------
        OutputError
            If the disk is full, or the folder cannot be written.
        """
        try:
            if self.stays:
                file = self.path / RECORDS / f"{record.realization:09d}.npz"
                # Written aside and renamed: a record is there completely or not at all.
                write_whole(file, record.to_bytes())
            self.pending[record.realization] = record
            self._write_regions()
        except OSError as error:
            raise self._unwritable(error) from error

    def _write_regions(self) -> None:
        """Write all regions whose turn it is."""
        # In order, so that columns do not depend on which worker was faster.
        while self.next_region < self.n_region:
            rows = self.rows(self.next_region)
            if not all(k in self.pending for k in rows):
                return
            self._write_region(rows, [self.pending[k] for k in rows])
            for k in rows:
                # Maps of a record are large: memory is given back at once.
                del self.pending[k]
                if self.stays:
                    (self.path / RECORDS / f"{k:09d}.npz").unlink(missing_ok=True)
            self.next_region += 1

    def _write_region(self, rows: range, records: list[Record]) -> None:
        """Write the results of a region; its status last, so that it counts only when whole."""
        # Columns first, so that all rows of the region have one width.
        for record in records:
            self._add_columns(record.volumes)
        at = slice(rows.start, rows.stop)
        volumes = np.array(
            # NaN: failed. 0: built, and the unit is absent.
            [
                [np.nan if r.reason else r.volumes.get(key, 0.0) for key in self._keys]
                for r in records
            ]
        ).reshape(len(records), len(self._keys))
        drawn = np.array([vector(r.numbers, self.plan.parameters) for r in records])
        self.group["volume"][at, : len(self._keys)] = volumes
        if drawn.size:
            self.group["drawn"][at] = drawn
        self.group["reason"][at] = np.array([r.reason for r in records], dtype=object)
        self.group["warnings"][at] = np.array([r.n_warning for r in records], dtype=np.int32)
        self.group["torn"][at] = np.array([r.n_torn for r in records], dtype=np.int32)
        self.group["searched"][at] = np.array([r.n_searched for r in records], dtype=np.int32)
        # How many columns there were then, for a run that continues here.
        self.group["region_units"][rows.start // REGION] = len(self._keys)
        if self.sums is not None:
            self.sums.write(rows.start // REGION, records)
        if self.pairs is not None:
            self.pairs.write(rows.start // REGION, at, records)
        status = np.array([FAILED if r.reason else DONE for r in records], dtype=np.uint8)
        self.group["status"][at] = status
        self.status[at] = status

    def _add_columns(self, keys: Iterable[UnitKey]) -> None:
        """Give new units a column; they have no volume in realisations before."""
        known = set(self._keys)
        self._keys = [*self._keys, *(key for key in keys if key not in known)]
        n = len(self._keys)
        # Nothing new, and the base case is written.
        if n == len(known) == self.group["base_volume"].shape[0]:
            return

        # names as a whole: those of a region that was not finished are written again
        for i, name in enumerate(("unit", *UnitKey._fields[1:])):
            self.group[name].resize((n,))
            self.group[name][:] = np.array([key[i] for key in self._keys], dtype=object)
        self.group["base_volume"].resize((n,))
        base = [self.base.volumes.get(key, 0.0) for key in self._keys]
        self.group["base_volume"][:] = np.array(base)
        if self.group["volume"].shape[1] < n:
            self.group["volume"].resize((self.n, n))

    def finish(self) -> None:
        """Write what follows from all realisations: maps."""
        try:
            if self.sums is not None:
                self.sums.finish(self.n_region)
            # All records are in the arrays now.
            shutil.rmtree(self.path / RECORDS, ignore_errors=True)
        except OSError as error:
            raise self._unwritable(error) from error

    def close(self) -> None:
        """Give back the claim on the folder."""
        self.lock.release()

    def _unwritable(self, error: OSError) -> OutputError:
        reason = error.strerror or type(error).__name__
        return OutputError(
            f"{self.path}: cannot be written ({reason}). What is stored stays. "
            "When there is space, run the same call again: it continues."
        )


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
