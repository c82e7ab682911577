"""The Zarr store of an ensemble: written batch by batch, in order, and continued after a kill.

A batch is `BATCH` realisations in a row. Each finished realisation is first a file of its own in
``.records``, so that a kill at any moment loses none. When all of a batch are there, and all
batches before it are written, the batch goes into the arrays, its status last. So names of units
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
from geosurf.files import Lock, write_whole
from geosurf.model.expected import path_of

BATCH = 20  # realisations
UNITS = 64  # units of one chunk
DONE, FAILED = 1, 2
STATUSES = {0: "not run", DONE: "done", FAILED: "failed"}
RECORDS = ".records"
TEARS = {
    "torn": "horizons that were torn as picked",
    "searched": "horizons among these that were not cut as in the base case, but anew",
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
        return bool(same and len(status) == n and status.all() and (status[:BATCH] == DONE).any())
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
        # One process at a time: two would write different batches into the same arrays.
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
        # Columns of finished batches first, then units of the base case.
        self._keys = self._stored_keys()
        self._add_columns(self.base.amounts)
        mapped = self.plan.layers is not None
        self.sums = MapSums(self.group, self.base.maps) if mapped else None
        self.pairs = None
        if mapped:
            sizes = self.n, self.n_batch, self._whole_batches()
            self.pairs = PairAreas(self.group, self.base.juxtaposed, *sizes)
        (self.path / RECORDS).mkdir(exist_ok=True)

    def _create(self) -> None:
        """Create all arrays, empty; the identity comes last, so that this can be repeated."""
        n_parameter = len(self.plan.parameters)
        for name, attrs in self.plan.rock.columns.items():
            self.array(name, "f8", ("realisation", "unit"), (BATCH, UNITS), **attrs)
            self.array(f"base_{name}", "f8", ("unit",), (UNITS,), **attrs)
        # Flags as the CF conventions name them.
        meanings = {"flag_values": [*STATUSES], "flag_meanings": ", ".join(STATUSES.values())}
        self.array("status", "u1", ("realisation",), (BATCH,), **meanings)
        self.array("reason", str, ("realisation",), (BATCH,), long_name="why it failed")
        self.array("warnings", "i4", ("realisation",), (BATCH,), long_name="number of warnings")
        for name, words in TEARS.items():
            self.array(name, "i4", ("realisation",), (BATCH,), long_name=words)
        self.array("drawn", "f8", ("realisation", "parameter"), (BATCH, max(1, n_parameter)))
        self.array("realisation", "i8", ("realisation",), (BATCH,))
        self.array("batch_units", "i4", ("batch",), (1,))
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
            PairAreas.create(self.array, BATCH)
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
        known = self.group["realisation"].shape[0]
        if known > self.n:
            raise InputError(
                f"{self.path} holds {known} realisations, more than n={self.n}. Give n={known} or "
                "more (at the command line -n), or another store (at the command line -o)."
            )
        rows = "status", "reason", "warnings", *TEARS, "drawn", *self.plan.rock.columns
        for name in rows:
            one = self.group[name]
            one.resize((self.n, *one.shape[1:]))
        drawn = self.group["drawn"]
        drawn.resize((self.n, len(self.plan.parameters)))
        self.group["batch_units"].resize((self.n_batch,))
        self.group["realisation"].resize((self.n,))
        self.group["realisation"][:] = np.arange(self.n)

    def _stored_keys(self) -> list[UnitKey]:
        """Units that have a column, those of the base case first, as far as batches are whole."""
        columns = [self.group[name][:].tolist() for name in ("unit", *UnitKey._fields[1:])]
        # Names of a batch that was interrupted do not count: they may be incomplete.
        whole = self._whole_batches()
        n = int(self.group["batch_units"][whole - 1]) if whole else 0
        return [UnitKey(*row) for row in zip(*(c[:n] for c in columns), strict=True)]

    def _whole_batches(self) -> int:
        """Number of batches that are whole, from the first."""
        status = self.group["status"][:]
        whole = [bool(status[r.start : r.stop].all()) for r in map(self.rows, range(self.n_batch))]
        return whole.index(False) if False in whole else self.n_batch

    # ---- what is there -------------------------------------------------------------------

    @property
    def n_batch(self) -> int:
        """Number of batches."""
        return -(-self.n // BATCH)

    def rows(self, batch: int) -> range:
        """Realisations of a batch."""
        return range(batch * BATCH, min((batch + 1) * BATCH, self.n))

    def missing(self) -> list[int]:
        """Load finished records that are in no batch yet; return the realisations to run."""
        # From the first incomplete batch on, records decide and not the arrays.
        self.status = self.group["status"][:]
        self.next_batch = self._whole_batches()
        self.status[self.next_batch * BATCH :] = 0
        for file in sorted((self.path / RECORDS).glob("*.npz")):
            try:
                record = Record.from_bytes(file.read_bytes())
            except (OSError, ValueError, KeyError, EOFError, BadZipFile):
                continue  # damaged by a crash of the machine: it is run again
            # Records of batches that are written already are left-overs.
            if self.next_batch * BATCH <= record.realisation < self.n:
                self.pending[record.realisation] = record
        self._write_batches()
        first = self.next_batch * BATCH
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
                file = self.path / RECORDS / f"{record.realisation:09d}.npz"
                # Written aside and renamed: a record is there completely or not at all.
                write_whole(file, record.to_bytes())
            self.pending[record.realisation] = record
            self._write_batches()
        except OSError as error:
            raise self._unwritable(error) from error

    def _write_batches(self) -> None:
        """Write all batches whose turn it is."""
        # In order, so that columns do not depend on which worker was faster.
        while self.next_batch < self.n_batch:
            rows = self.rows(self.next_batch)
            if not all(k in self.pending for k in rows):
                return
            self._write_batch(rows, [self.pending[k] for k in rows])
            for k in rows:
                # Maps of a record are large: memory is given back at once.
                del self.pending[k]
                if self.stays:
                    (self.path / RECORDS / f"{k:09d}.npz").unlink(missing_ok=True)
            self.next_batch += 1

    def _write_batch(self, rows: range, records: list[Record]) -> None:
        """Write the results of a batch; its status last, so that it counts only when whole."""
        # Columns first, so that all rows of the batch have one width.
        for record in records:
            self._add_columns(record.amounts)
        at = slice(rows.start, rows.stop)
        # NaN: failed. 0: built, and the unit is absent.
        failed, absent = ((value,) * len(self.plan.rock.columns) for value in (np.nan, 0.0))
        amounts = np.array(
            [
                [failed if r.reason else r.amounts.get(key, absent) for key in self._keys]
                for r in records
            ]
        ).reshape(len(records), len(self._keys), -1)
        drawn = np.array([vector(r.numbers, self.plan.parameters) for r in records])
        for k, name in enumerate(self.plan.rock.columns):
            self.group[name][at, : len(self._keys)] = amounts[..., k]
        if drawn.size:
            self.group["drawn"][at] = drawn
        self.group["reason"][at] = np.array([r.reason for r in records], dtype=object)
        self.group["warnings"][at] = np.array([r.n_warning for r in records], dtype=np.int32)
        self.group["torn"][at] = np.array([r.n_torn for r in records], dtype=np.int32)
        self.group["searched"][at] = np.array([r.n_searched for r in records], dtype=np.int32)
        # How many columns there were then, for a run that continues here.
        self.group["batch_units"][rows.start // BATCH] = len(self._keys)
        if self.sums is not None:
            self.sums.write(rows.start // BATCH, records)
        if self.pairs is not None:
            self.pairs.write(rows.start // BATCH, at, records)
        status = np.array([FAILED if r.reason else DONE for r in records], dtype=np.uint8)
        self.group["status"][at] = status
        self.status[at] = status

    def _add_columns(self, keys: Iterable[UnitKey]) -> None:
        """Give new units a column; they have no volume in realisations before."""
        known = set(self._keys)
        self._keys = [*self._keys, *(key for key in keys if key not in known)]
        n = len(self._keys)
        # Nothing new, and the base case is written.
        if n == len(known) == self.group["base_bulk"].shape[0]:
            return

        # names as a whole: those of a batch that was not finished are written again
        for i, name in enumerate(("unit", *UnitKey._fields[1:])):
            self.group[name].resize((n,))
            self.group[name][:] = np.array([key[i] for key in self._keys], dtype=object)
        columns = self.plan.rock.columns
        base = np.array([self.base.amounts.get(key, (0.0,) * len(columns)) for key in self._keys])
        for k, name in enumerate(columns):
            self.group[f"base_{name}"].resize((n,))
            self.group[f"base_{name}"][:] = base[:, k]
            if self.group[name].shape[1] < n:
                self.group[name].resize((self.n, n))

    def finish(self) -> None:
        """Write what follows from all realisations: maps."""
        try:
            if self.sums is not None:
                self.sums.finish(self.n_batch)
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


_PARTS = {"batch_difference": "f8", "batch_square": "f8", "batch_present": "i4"}
_MAPS = {
    "thickness_mean": (
        "m",
        "mean vertical thickness over the realisations, 0 where the layer is absent",
    ),
    "thickness_sd": ("m", "standard deviation of the vertical thickness"),
    "probability": ("1", "share of the realisations in which the layer is present"),
}


class MapSums:
    """Sums of maps over the realisations of each batch.

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
        # One chunk per batch: it is written once, as a whole.
        n_layer, n_row, n_col = layers.shape
        dims = ("layer", "northing", "easting")
        for name, dtype in _PARTS.items():
            made = new(name, dtype, ("batch", *dims), (1, n_layer, n_row, n_col))
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

    def write(self, batch: int, records: list[Record]) -> None:
        """Write the sums of a batch."""
        maps = [record.maps for record in records if record.maps is not None]
        # Differences from the base case are small: their squares keep their digits.
        off = np.zeros((2, *self.base.shape))
        present = np.zeros(self.base.shape, dtype=np.int32)
        for thickness in maps:
            difference = thickness.astype(np.float64) - self.base
            off[0] += difference
            off[1] += difference * difference
            # A layer is present where it has any thickness.
            present += thickness > 0
        for name, values in zip(_PARTS, (*off, present), strict=True):
            array = self.group[name]
            if array.shape[0] <= batch:
                array.resize((batch + 1, *self.base.shape))
            array[batch] = values

    def finish(self, n_batch: int) -> None:
        """Write mean, standard deviation and probability over all realisations."""
        # Failed realisations have no maps and do not count.
        n = int((self.group["status"][:] == 1).sum())
        total = [np.zeros(self.base.shape) for _ in _PARTS]
        # In the order of batches: the sum is the same in any run.
        for batch in range(n_batch):
            for sum_, name in zip(total, _PARTS, strict=True):
                sum_ += self.group[name][batch]
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = total[0] / n
            # The unbiased variance; rounding may make it slightly negative.
            variance = (total[1] - n * mean * mean) / max(n - 1, 1)
            found = (self.base + mean, np.sqrt(np.maximum(variance, 0.0)), total[2] / n)
        for name, values in zip(_MAPS, found, strict=True):
            self.group[name][:] = values
