"""Tearing of whole fields by how their faults were prepared: ``python -m benchmarks.tears fields``.

Each horizon is torn at all faults of its field with sticks as picked, lengthened up and down, and
extended to the box, and with several trims.
"""

from __future__ import annotations

import json
import multiprocessing
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs
from benchmarks.folders import drogon_folder
from benchmarks.torn_networks import CRASHES

PREPARATIONS = ("as picked", "lengthened", "extended to the box")
TRIMS: tuple[float | str, ...] = ("auto", 1.5, 2.0, 3.0, 5.0)
DROGON_BOX = (454000.0, 470000.0, 5.924e6, 5.941e6, -2100.0, -1400.0)
DROGON = {
    "TopVolantis": "01_topvolantis",
    "TopTherys": "02_toptherys",
    "TopVolon": "03_topvolon",
    "BaseVolantis": "04_basevolantis",
}
Loaded = tuple[dict[str, Any], dict[str, Any], tuple[float, ...]]  # horizons, faults, box


@dataclass
class Row:
    """What became of one horizon."""

    field: str
    sticks: str
    trim: float | str
    horizon: str
    seconds: float = 0.0
    busy: float = 0.0  # seconds of the processor, whatever else runs
    megabytes: float = 0.0  # peak of the process so far
    refused: str = ""
    crashed: str = ""
    remedies: Counter[str] = field(default_factory=Counter)
    said: list[str] = field(default_factory=list)  # the remedies in words
    misfit: tuple[float, float] = (np.nan, np.nan)  # median and 95 % of held-out data [m]
    throws: dict[str, float] = field(default_factory=dict)  # largest, by fault [m]

    @property
    def cell(self) -> tuple[str, str, float | str]:
        """Field, preparation and trim."""
        return self.field, self.sticks, self.trim

    @property
    def is_built(self) -> bool:
        """Whether there is a sheet."""
        return not (self.refused or self.crashed)

    @property
    def outcome(self) -> str:
        """In words."""
        if self.crashed:
            return f"**crash**: {self.crashed}"
        if self.refused:
            return f"refused: {self.refused}"
        taken = ", ".join(f"{kind} {n}" for kind, n in sorted(self.remedies.items()))
        return taken or "built"


def _drogon_faults(data: Path) -> dict[str, Any]:
    sticks = data / "drogon" / "fault_sticks_pol"
    return {f"F{k}": gs.read_fault(sticks / f"F{k}.pol", positive="down") for k in range(1, 7)}


def _drogon_points(data: Path) -> Loaded:
    folder = data / "drogon" / "horizons_poi"
    horizons = {n: gs.read_points(folder / f"{n}.poi", positive="down") for n in DROGON}
    return horizons, _drogon_faults(data), DROGON_BOX


def _drogon_grids(data: Path) -> Loaded:
    folder = data / "drogon_xtgeo" / "horizons_gri"
    files = {name: folder / f"{file}.gri" for name, file in DROGON.items()}
    horizons = {name: gs.read_horizon(path, positive="down") for name, path in files.items()}
    return horizons, _drogon_faults(data), DROGON_BOX


def _reek(data: Path) -> Loaded:
    """The grids of Reek at the faults of Drogon, which have the same frame."""
    paths = sorted((data / "reek" / "horizons_gri").glob("*.gri"))
    if not paths:
        raise FileNotFoundError(data / "reek" / "horizons_gri")
    horizons = {path.stem: gs.read_horizon(path, positive="down") for path in paths}
    return horizons, _drogon_faults(data), DROGON_BOX


def _export(data: Path, variant: str) -> Loaded:
    """A synthetic field, read back from its files."""
    truth = gs.synthetic.field_export(tempfile.mkdtemp(), variant)
    horizons: dict[str, Any] = {}
    for name in truth.horizons:
        path, unit = truth.files[name], "ft" if name == "Base" else None
        read = gs.read_points if path.suffix == ".poi" else gs.read_horizon
        horizons[name] = read(path, positive="down", length_unit=unit)
    meshes = {name: truth.files[name] for name in truth.faults}
    faults = {
        name: gs.read_fault(path) if path.suffix == ".ts" else gs.read_fault(path, positive="down")
        for name, path in meshes.items()
    }
    x, y = truth.outline.T
    box = (x.min() - 300, x.max() + 300, y.min() - 300, y.max() + 300, -2300.0, -1300.0)
    return horizons, faults, tuple(map(float, box))


FIELDS: dict[str, Callable[[Path], Loaded]] = {
    "Drogon points": _drogon_points,
    "Drogon grids": _drogon_grids,
    "Reek grids": _reek,
    "export grids": partial(_export, variant="grids"),
    "export points": partial(_export, variant="points"),
    "export network": partial(_export, variant="network"),
}


def prepared(faults: dict[str, Any], box: tuple[float, ...], how: str) -> dict[str, Any]:
    """Faults as picked, lengthened up and down to the box, or extended to it on all sides."""
    found = {name: gs.triangulate_fault(fault, name=name) for name, fault in faults.items()}
    if how == "as picked":
        return found
    sides = {"sides": ("up", "down")} if how == "lengthened" else {}
    return {n: gs.extend_fault(fault, box, **sides).surface for n, fault in found.items()}


def run_fields(
    fields: Sequence[str] = tuple(FIELDS),
    sticks: Sequence[str] = PREPARATIONS,
    trims: Sequence[float | str] = TRIMS,
    results: Path | None = None,
) -> list[Row]:
    """
    Tear all horizons of some fields, each field, preparation and trim in a process of its own.

    Parameters
    ----------
    fields : sequence of str
        Names in `FIELDS`.
    sticks : sequence of str
        Some of `PREPARATIONS`.
    trims : sequence of float or "auto"
    results : Path, optional
        A file to which rows are appended. What it has already is not run again.

    Returns
    -------
    list of Row
        None for fields whose files are absent: a line on stderr gives the reason.
    """
    path = Path(tempfile.mkdtemp()) / "rows.jsonl" if results is None else results
    wanted = list(product(fields, sticks, trims))
    for cell in wanted:
        if any(row.cell == cell for row in read_rows(path)):
            continue
        process = multiprocessing.get_context("spawn").Process(target=run_cell, args=(*cell, path))
        process.start()
        process.join()
        if process.exitcode:  # killed, or a crash outside of Python
            _append(path, Row(*cell, "all", crashed=f"exit code {process.exitcode}"))
    return [row for row in read_rows(path) if row.cell in wanted]


def run_cell(name: str, how: str, trim: float | str, path: Path) -> None:
    """Tear all horizons of one field, and append their rows to a file when all are done."""
    try:
        horizons, faults, box = FIELDS[name](drogon_folder())
    except (gs.errors.GeosurfError, FileNotFoundError) as error:
        sys.stderr.write(f"{name} is left out: {error}. Set GEOSURF_SHARED.\n")
        return
    ready, rows = prepared(faults, box, how), []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # each sheet's report has them
        for horizon, data in horizons.items():
            row = _torn(Row(name, how, trim, horizon), data, ready)
            rows.append(row)
            sys.stderr.write(
                f"{name:15}{how:20}{trim!s:6}{horizon:18}{row.seconds:6.1f} s {row.outcome}\n"
            )
            sys.stderr.flush()
    _append(path, *rows)


def _append(path: Path, *rows: Row) -> None:
    """Append rows to a file, one line of JSON for each."""
    with path.open("a", encoding="utf-8") as file:
        for row in rows:
            file.write(json.dumps({**vars(row), "remedies": dict(row.remedies)}) + "\n")


def read_rows(path: Path) -> list[Row]:
    """Rows of a file; none if the file does not exist."""
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = [Row(**json.loads(line)) for line in lines]
    for row in rows:
        row.remedies, row.misfit = Counter(row.remedies), tuple(row.misfit)
    return rows


def _torn(row: Row, data: Any, faults: dict[str, Any]) -> Row:
    """Tear one horizon."""
    start, busy = time.perf_counter(), time.process_time()
    try:
        sheet = gs.tear_horizon(data, faults, name=row.horizon, trim=row.trim)
    except gs.errors.GeosurfError as error:
        row.refused = str(error)
    except CRASHES as error:  # a result here
        row.crashed = f"{type(error).__name__}: {error}"
    row.seconds, row.busy = time.perf_counter() - start, time.process_time() - busy
    row.megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    if row.is_built:
        row.remedies = Counter(warning.kind for warning in sheet.report.remedies)
        row.said = [warning.effect for warning in sheet.report.remedies]
        misfit = sheet.report.holdout_misfit
        row.misfit = misfit.get("median", np.nan), misfit.get("p95", np.nan)
        row.throws = {
            name: float(np.nanmax(np.abs(cut.throw), initial=0.0))
            for name, cut in sheet.cuts.items()
        }
    return row


def fields_table(rows: Sequence[Row]) -> str:
    """
    Results as Markdown.

    Parameters
    ----------
    rows : sequence of Row

    Returns
    -------
    str
    """
    return "\n".join([*_summary(rows), "", *_details(rows)])


def _summary(rows: Sequence[Row]) -> Iterator[str]:
    """One line for each field and preparation."""
    yield (
        "| field | sticks | built | with remedies | refused | crashed | s per horizon | most s "
        "| peak MB |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    keys = list(dict.fromkeys((row.field, row.sticks) for row in rows))
    groups = [[row for row in rows if (row.field, row.sticks) == key] for key in keys]
    for (name, how), mine in [*zip(keys, groups, strict=True), (("**all**", ""), list(rows))]:
        built = [row for row in mine if row.is_built]
        helped = sum(bool(row.remedies) for row in built)
        refused, crashed = sum(bool(r.refused) for r in mine), sum(bool(r.crashed) for r in mine)
        seconds = [row.seconds for row in mine] or [0.0]
        peak = max((row.megabytes for row in mine), default=0.0)
        yield (
            f"| {name} | {how} | {len(built)} of {len(mine)} | {helped} | {refused} | {crashed} "
            f"| {np.mean(seconds):.1f} | {max(seconds):.1f} | {peak:.0f} |"
        )


def _details(rows: Sequence[Row]) -> Iterator[str]:
    """One line for each horizon."""
    yield (
        "| field | sticks | trim | horizon | outcome | s | hidden data: median, 95 % [m] "
        "| largest throw [m] |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for row in rows:
        throws = ", ".join(f"{name} {throw:.0f}" for name, throw in row.throws.items())
        misfit = "{:.2f}, {:.2f}".format(*row.misfit) if row.is_built else ""
        yield (
            f"| {row.field} | {row.sticks} | {row.trim} | {row.horizon} | {row.outcome} "
            f"| {row.seconds:.1f} | {misfit} | {throws} |"
        )
