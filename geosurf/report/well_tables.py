"""Tables of well tops: the misfit of each, and of each horizon on average."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions import counted
from geosurf.report.page import NOTHING, Table, number

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

REMARKS = {
    "found": "",
    "several": "repeated by a reverse fault; the nearest",
    "fault gap": "in the gap of a fault",
    "absent": "the horizon does not exist there",
    "outside": "outside the model",
    "unknown horizon": "no horizon of this name",
}


def misfit_table(misfit: xarray.Dataset) -> Table:
    """Return well tops and the model: one row per top."""
    rows = []
    columns = ("horizon", "well", "picked", "model", "misfit", "block", "status", "fault")
    for row in zip(*(misfit[name].values for name in columns), strict=True):
        horizon, well, picked, model, off, block, status, fault = row

        # an unknown status prints as it is: a table never fails on a word
        remark = REMARKS.get(status, str(status))

        # a fault explains more than the status: it is named
        if fault:
            across = f"fault {fault} between top and horizon"
            remark = f"in the gap of fault {fault}" if status == "fault gap" else across
        values = (_metres(value) for value in (picked, model, off))
        rows.append((str(horizon), str(well), *values, str(block) or NOTHING, remark))
    head = ("Horizon", "Well", "Top [m]", "Model [m]", "Misfit [m]", "Block", "Remark")
    return Table(head, tuple(rows), n_label=2, n_remark=2)


def misfit_words(misfit: xarray.Dataset) -> list[str]:
    """Return a sentence on the misfit of each horizon."""
    found = []
    names = misfit["horizon"].values

    # in the order of the tops, which is that of the user's file
    for name in dict.fromkeys(names.tolist()):
        off = misfit["misfit"].values[names == name]

        # NaN where the horizon has no value at a top: those are listed, not averaged
        off = off[np.isfinite(off)]
        if len(off):
            found.append(
                f"{name}: mean misfit {_metres(off.mean())} m, standard deviation "
                f"{_metres(off.std())} m, largest {_metres(np.abs(off).max())} m at "
                f"{counted(len(off), 'top')}. Misfit is model minus top."
            )
    return found


def _metres(value: float) -> str:
    return number(float(value), 2) if np.isfinite(value) else NOTHING
