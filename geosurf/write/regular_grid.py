"""The regular grid behind a horizon: what formats of grids store instead of its nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geosurf.errors import OutputError
from geosurf.write.written import Loss

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# nodes may be off the regular grid by this much of an increment
SLACK = 1e-6

Geometry = tuple[float, float, float, float, float]


def regular_grid(
    horizon: xr.DataArray, name: str, title: str = "IRAP"
) -> tuple[Geometry, np.ndarray]:
    """Return origin, increments and rotation of a regular grid, and its values.

    Parameters
    ----------
    horizon : DataArray
    name : str
        Name of the horizon, for errors.
    title : str
        Name of the format, for errors.

    Returns
    -------
    geometry : tuple of float
        x and y of the first node, step along columns, step along rows [m], and the rotation
        (degrees, counter-clockwise from east).
    values : ndarray of float64, shape (n_row, n_column)

    Raises
    ------
    OutputError
        If nodes are not on a regular, right-angled grid.
    """
    if horizon.ndim != 2 or "easting" not in horizon.coords or "northing" not in horizon.coords:
        raise OutputError(
            f"horizon {name!r} has dims {horizon.dims} and coordinates {list(horizon.coords)}; "
            "a grid file needs two dims and the coordinates easting and northing. Add them."
        )

    # rows from the south, columns from the west, whatever order the array has
    if horizon.easting.ndim == horizon.northing.ndim == 1:
        across = (*horizon.northing.dims, *horizon.easting.dims)
        horizon = horizon.transpose(*across)
        falling = [key for key in ("northing", "easting") if (np.diff(horizon[key]) < 0).any()]
        horizon = horizon.sortby(falling) if falling else horizon  # sorting copies all values

    refuse_odd_nodes(horizon, name)
    values = np.asarray(horizon.values, dtype=np.float64)
    easting = np.asarray(horizon.easting.values, dtype=np.float64)
    northing = np.asarray(horizon.northing.values, dtype=np.float64)
    if easting.ndim == northing.ndim == 1:
        # one line of nodes for each axis: a mesh of all would take more memory than the values
        easting, northing = easting[None], northing[:, None]

    # The stated geometry is exact; one fitted to the nodes has rounding.
    stated = _stated(horizon)
    if stated is not None and _fits(stated, easting, northing, exact=True):
        return stated, values

    fitted = _fitted(easting, northing)
    if 0.0 in fitted[2:4] or not _fits(fitted, easting, northing, exact=False):
        raise OutputError(
            f"horizon {name!r}: its nodes are not on a regular rectangular grid, and {title} "
            "stores no other grids. Write .nc, or resample the horizon."
        )
    return fitted, values


def upright_grid(horizon: xr.DataArray, name: str, title: str) -> UprightGrid:
    """Return a grid for a format without rotation; quarter turns become rows and columns.

    Parameters
    ----------
    horizon : DataArray
    name, title : str
        Names of the horizon and of the format, for errors.

    Returns
    -------
    UprightGrid

    Raises
    ------
    OutputError
        If the grid is rotated by another angle, or is not regular.
    """
    (x, y, xinc, yinc, rotation), values = regular_grid(horizon, name, title)
    n_row, n_column = values.shape

    # the far ends of the first row and of the first column, measured along both axes
    turn = math.radians(rotation)
    along = np.array([math.cos(turn), math.sin(turn)]) * xinc
    across = np.array([-math.sin(turn), math.cos(turn)]) * yinc
    turned = abs(along[1]) > abs(along[0])
    if turned:
        along, across, values = across, along, values.T
    n_row, n_column = values.shape
    skew = max(abs(along[1]) * (n_column - 1), abs(across[0]) * (n_row - 1))
    if skew > SLACK * min(abs(along[0]), abs(across[1])):
        raise OutputError(
            f"horizon {name!r} is rotated by {rotation:.6g} degrees, and {title} stores no "
            "rotation. Write .irapasc, .gri or .nc, which do, or resample the horizon onto a grid "
            "along east and north."
        )

    # steps against the axes: begin at the other end
    west, south = x, y
    if along[0] < 0:
        west, values = x + (n_column - 1) * along[0], values[:, ::-1]
    if across[1] < 0:
        south, values = y + (n_row - 1) * across[1], values[::-1]
    return UprightGrid(
        float(west), float(south), float(abs(along[0])), float(abs(across[1])), values
    )


@dataclass(frozen=True)
class UprightGrid:
    """
    A grid along east and north.

    Attributes
    ----------
    west, south : float
        The first node [m].
    dx, dy : float
        Steps [m].
    values : ndarray of float64, shape (n_row, n_column)
        Rows from the south, each from the west.
    """

    west: float
    south: float
    dx: float
    dy: float
    values: np.ndarray

    @property
    def east(self) -> float:
        """Easting of the last column [m]."""
        return float(self.west + (self.values.shape[1] - 1) * self.dx)

    @property
    def north(self) -> float:
        """Northing of the last row [m]."""
        return float(self.south + (self.values.shape[0] - 1) * self.dy)


def refuse_odd_nodes(horizon: xr.DataArray, name: str) -> None:
    """Refuse infinite values, and nodes that have no place or share one: readers would fail."""
    if np.isinf(np.asarray(horizon.values, dtype=np.float64)).any():
        raise OutputError(
            f"horizon {name!r} has infinite values. Set missing nodes to NaN instead."
        )
    for key in ("easting", "northing"):
        if key not in horizon.coords:
            continue
        axis = np.asarray(horizon[key].values, dtype=np.float64)
        if not np.isfinite(axis).all():
            raise OutputError(
                f"horizon {name!r}: {key} has values that are not finite. Give each node a place."
            )
        if axis.ndim == 1 and len(np.unique(axis)) < len(axis):
            raise OutputError(
                f"horizon {name!r}: {key} has the same value twice. Drop one of the rows or "
                "columns there."
            )


def refuse_value(values: np.ndarray, mark: float, name: str, title: str) -> None:
    """Refuse a value that means 'undefined' in a format: it would be read as absent."""
    if (values == mark).any():
        raise OutputError(
            f"horizon {name!r} has a value of {mark!r}, which means 'undefined' in {title}. Write "
            ".nc instead."
        )


def null_for(values: np.ndarray, candidates: tuple[str, ...]) -> str:
    """Return the first null value that no node has; the formats state it in their headers."""
    return next(word for word in candidates if not (values == float(word)).any())


def direction_lost(horizon: xr.DataArray, title: str) -> list[Loss]:
    """State what a format cannot: direction and unit of its values."""
    positive = horizon.attrs.get("positive", "up")
    word = "depth" if positive == "down" else "elevation"
    unit = horizon.attrs.get("units", "m")
    found = [
        Loss(
            "direction",
            f"Values are {word} in {unit}, which {title} does not store: "
            f"read the file with positive={positive!r}.",
        )
    ]
    if unit != "m":
        words = f"Values are in {unit}: read the file with length_unit={unit!r}."
        found.append(Loss("unit", words))
    return found


def node_of(grid: Geometry, row: int, column: int) -> tuple[float, float]:
    """Easting and northing of a node of a regular grid [m]."""
    x, y, xinc, yinc, rotation = grid
    cos, sin = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))

    # The step along columns, turned by the rotation, and the one along rows at a right angle [m].
    return (
        x + column * xinc * cos - row * yinc * sin,
        y + column * xinc * sin + row * yinc * cos,
    )


def _stated(horizon: xr.DataArray) -> Geometry | None:
    """Return the geometry in the attributes, if there is one."""
    try:
        x, y, xinc, yinc, rotation = (
            float(horizon.attrs[key]) for key in ("xori", "yori", "xinc", "yinc", "rotation")
        )
    except (KeyError, TypeError, ValueError):
        return None
    return x, y, xinc, yinc, rotation


def _fitted(easting: np.ndarray, northing: np.ndarray) -> Geometry:
    """Return the geometry that the corner nodes imply; single rows get a step of 1."""
    nrow, ncol = np.broadcast_shapes(easting.shape, northing.shape)
    x, y = float(easting[0, 0]), float(northing[0, 0])

    # Steps between corner nodes average the rounding of all columns and rows.
    along = (float(easting[0, -1]) - x, float(northing[0, -1]) - y)
    across = (float(easting[-1, 0]) - x, float(northing[-1, 0]) - y)

    # a single column of nodes: the direction follows from the rows, at a right angle
    if ncol > 1:
        rotation = math.degrees(math.atan2(along[1], along[0]))
    else:
        rotation = math.degrees(math.atan2(-across[0], across[1])) if nrow > 1 else 0.0
    xinc = math.hypot(*along) / (ncol - 1) if ncol > 1 else 1.0
    yinc = math.hypot(*across) / (nrow - 1) if nrow > 1 else 1.0

    # A negative step along rows where rows run clockwise from columns.
    left_handed = along[0] * across[1] - along[1] * across[0] < 0
    return x, y, xinc, -yinc if left_handed else yinc, rotation


def _fits(grid: Geometry, easting: np.ndarray, northing: np.ndarray, *, exact: bool) -> bool:
    """Whether all nodes lie where the geometry puts them."""
    x, y, xinc, yinc, rotation = grid
    turn = math.radians(rotation)

    # places that the geometry gives all nodes, to compare with their own
    nrow, ncol = np.broadcast_shapes(easting.shape, northing.shape)
    column, row = np.arange(ncol), np.arange(nrow)[:, None]
    if easting.shape != northing.shape:
        # axes along east and north: other rotations do not fit
        if rotation % 360.0:
            return False
        east, north = x + column * xinc, y + row * yinc
    else:
        east = x + (column * xinc * math.cos(turn) - row * yinc * math.sin(turn))
        north = y + (column * xinc * math.sin(turn) + row * yinc * math.cos(turn))

    slack = 1e-9 if exact else SLACK
    # float64 itself moves nodes by a few units in the last place
    scale = max(abs(x), abs(y), 1.0) * 8 * np.finfo(np.float64).eps
    limit = slack * min(abs(xinc), abs(yinc)) + scale
    return bool(
        (np.abs(east - easting) <= limit).all() and (np.abs(north - northing) <= limit).all()
    )
