"""What readers return of places that are in metres already: points, and faults as grids."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import FAULT_DIMS
from geosurf.errors import InputError

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

METRE, UP = {"units": "m"}, {"units": "m", "positive": "up"}
AXES = {"easting": METRE, "northing": METRE, "elevation": UP}


def points_dataset(
    points: np.ndarray,
    source: str,
    crs: str | None = None,
    others: dict[str, Any] | None = None,
    **attrs: str,
) -> xr.Dataset:
    """
    Return points as a Dataset.

    Parameters
    ----------
    points : ndarray of float64, shape (n, 3)
        Easting, northing, elevation [m].
    source : str
        Name of the file.
    crs : str, optional
    others : dict, optional
        Further variables, as xarray takes them.
    **attrs : str
        Further attributes.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``point``.
    """
    import xarray as xr

    data = {
        key: ("point", points[:, k].copy(), dict(meaning))
        for k, (key, meaning) in enumerate(AXES.items())
    }
    stated = {} if crs is None else {"crs": crs}
    return xr.Dataset(data | (others or {}), attrs={"source": source, **attrs, **stated})


def fault_dataset(nodes: np.ndarray, name: str, source: str, crs: str | None) -> xr.Dataset:
    """
    Return a fault given by rows down its dip and columns along its strike.

    Parameters
    ----------
    nodes : ndarray of float64, shape (n_row, n_column, 3)
        Easting, northing, elevation [m].
    name, source : str
        Of the fault, and of its file.
    crs : str or None

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` over ``(down_dip, along_strike)``.
    """
    import xarray as xr

    data = {
        key: (FAULT_DIMS, nodes[..., k].copy(), dict(meaning))
        for k, (key, meaning) in enumerate(AXES.items())
    }
    stated = {} if crs is None else {"crs": crs}
    return xr.Dataset(data, attrs={"name": name, "source": source, **stated})


def refuse_columns(path: Path, format_: str, columns: object, decimal: str) -> None:
    """Refuse arguments that apply to tables of text only."""
    if columns is not None or decimal != ".":
        raise InputError(
            f"{path}: columns= and decimal= apply to tables of text, but this is {format_}. Leave "
            "them out."
        )
