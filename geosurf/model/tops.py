"""Well tops, checked: where wells meet horizons."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import (
    check_word,
    elevation_sign,
    is_number,
    length_text,
    metres_per_unit,
    real_numbers,
)
from geosurf.conventions.axes import FOOT
from geosurf.conventions.checks import no_data_in
from geosurf.conventions.crs import crs_of
from geosurf.errors import GeosurfWarning, InputError
from geosurf.model.base import Noun, frozen

COLUMNS = ("well", "horizon", "easting", "northing", "elevation")


@dataclass(frozen=True, eq=False)
class Tops:
    """Well tops as stages take them.

    Attributes
    ----------
    wells, horizons : tuple of str
        Name of the well and of the horizon, one for each top.
    points : ndarray of float64, shape (n_top, 3)
        Easting, northing, elevation [m], positive up.
    crs : str or None
        Coordinate reference system that the tops declare.
    """

    wells: tuple[str, ...]
    horizons: tuple[str, ...]
    points: np.ndarray
    crs: str | None = None

    def __len__(self) -> int:
        return len(self.wells)

    def of(self, horizon: str) -> np.ndarray:
        """Rows of the tops of one horizon."""
        # A mask over all tops: a well may meet a horizon several times.
        return np.flatnonzero(np.array([name == horizon for name in self.horizons], dtype=bool))

    def words(self, row: int) -> str:
        """One top, as messages name it."""
        return f"{self.horizons[row]!r} in well {self.wells[row]!r}"

    def __iter__(self) -> Iterator[tuple[str, str, tuple[float, float, float]]]:
        """Well, horizon and place of each top."""
        for well, horizon, point in zip(self.wells, self.horizons, self.points, strict=True):
            east, north, up = point.tolist()
            yield well, horizon, (east, north, up)


def tops_of(tops: Any) -> Tops:
    """
    Return well tops from a dataset or a table, or raise an error that names what is wrong.

    Parameters
    ----------
    tops : xarray.Dataset, pandas.DataFrame, mapping or Tops
        With the columns ``well``, ``horizon``, ``easting``, ``northing``, ``elevation``; the last
        is positive up and in metres, unless its attributes ``positive`` and ``units`` differ.

    Returns
    -------
    Tops

    Raises
    ------
    InputError

    Examples
    --------
    >>> found = tops_of(
    ...     {"well": ["W1"], "horizon": ["Top"], "easting": [0], "northing": [9], "elevation": [-5]}
    ... )
    >>> len(found), found.words(0)
    (1, "'Top' in well 'W1'")
    """
    # Checked before.
    if isinstance(tops, Tops):
        return tops
    how = "Pass the result of geosurf.read_tops, or a table with these columns"
    try:
        columns = {name: tops[name] for name in COLUMNS}
    except (KeyError, TypeError, IndexError, AttributeError) as error:
        raise InputError(
            f"tops is {type(tops).__name__} without all of {', '.join(COLUMNS)}. {how}."
        ) from error

    # xarray variables, columns of pandas and lists alike
    arrays = {name: np.ravel(getattr(value, "values", value)) for name, value in columns.items()}
    sizes = {name: len(array) for name, array in arrays.items()}
    # Columns of different lengths would pair tops with the wrong wells.
    if len(set(sizes.values())) != 1:
        raise InputError(f"the columns of tops have different lengths: {sizes}. {how}.")
    wells, horizons = (tuple(map(str, arrays[name].tolist())) for name in COLUMNS[:2])
    try:
        # One column at a time, so that dates or complex numbers are refused.
        points = np.stack([real_numbers(arrays[name]) for name in COLUMNS[2:]], axis=1)
    except (TypeError, ValueError) as error:
        raise InputError(f"tops have coordinates that are not numbers ({error}). {how}.") from error

    # depth or feet in the attributes of the column, as `read_tops` or the user set them
    attrs = dict(getattr(columns["elevation"], "attrs", {}))
    scale = elevation_sign(attrs.get("positive", "up"), "the tops")
    points[:, 2] *= scale * metres_per_unit(attrs.get("units", "m"), "the tops")

    # one top without a place would make every misfit statistic NaN
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        first = bad[0]
        raise InputError(
            f"{len(bad)} tops have coordinates that are not finite; the first is "
            f"{horizons[first]!r} in well {wells[first]!r}. Leave these tops out."
        )
    if absent := no_data_in(points, elevations=False):
        raise InputError(
            f"the place of {horizons[absent[0]]!r} in well {wells[absent[0]]!r} has "
            f"{absent[1]:g}, a usual mark of no data. Leave this top out, or correct it."
        )
    return Tops(wells, horizons, frozen(points + 0.0, np.float64), crs_of(tops))


# ---- heights of another sign or unit ----------------------------------------
# A top that is far from its horizon, and near it as a depth or in feet, is one.


FARTHEST = 100.0  # m: a misfit that a wrong pick may have
NEARER = 10.0  # times, with the other sign or unit
READ_AS = {
    -1.0: ("a depth", "positive='down'"),
    FOOT: ("in feet", "length_unit='ft'"),
    -FOOT: ("a depth in feet", "positive='down', length_unit='ft'"),
}


def doubtful_top(tops: Tops, rows: np.ndarray, model: np.ndarray) -> GeosurfWarning | None:
    """
    Return a warning of the first top that is met with another sign or unit; None without one.

    Parameters
    ----------
    tops : Tops
    rows : ndarray of int64
        Which tops are compared.
    model : ndarray of float64
        Elevation of the horizon at each of them [m]; NaN where it has none.

    Examples
    --------
    >>> tops = Tops(("W",), ("Top",), np.array([[0.0, 0.0, 2050.0]]))
    >>> print(doubtful_top(tops, np.array([0]), np.array([-2053.0])).effect)
    The top 'Top' in well 'W' is 4.1 km off its horizon; as a depth it would be 3 m off.
    """
    picked = tops.points[rows, 2]
    off = np.abs(model - picked)
    for factor, (what, how) in READ_AS.items():
        as_read = np.abs(model - factor * picked)
        doubted = np.flatnonzero((off > FARTHEST) & (NEARER * as_read < off))
        if len(doubted):
            first = doubted[0]
            row = int(rows[first])
            effect = (
                f"The top {tops.words(row)} is {length_text(off[first])} off its horizon; "
                f"{'' if what == 'in feet' else 'as '}{what} it would be "
                f"{length_text(as_read[first])} off."
            )
            remedy = f"Give read_tops {how}, or elevations in metres, or correct this top."
            return GeosurfWarning("tops", tops.horizons[row], effect, remedy, tops.points[row])
    return None


# ---- tie ----------------------------------------
# How horizons are tied to well tops: range and tolerance, and what a tie did.


RANGE = 1000.0  # m: the default; beyond it a top changes nothing
TOLERANCE = 0.1  # m: largest misfit after a tie
HOW = 'Write tie=True, or tie={"range": 1000.0, "tolerance": 0.1} in metres'


@dataclass(frozen=True)
class TieSettings:
    """How horizons are tied to well tops.

    Attributes
    ----------
    range : float
        Distance from a well beyond which it changes nothing, in map view [m].
    tolerance : float
        Largest misfit after the tie [m].
    assumed : bool
        Whether the range is the default.
    """

    range: float = RANGE
    tolerance: float = TOLERANCE
    assumed: bool = False


@dataclass(frozen=True, repr=False)
class TieReport(Noun):
    """What the tie of one horizon to its well tops did.

    Attributes
    ----------
    horizon : str
    settings : TieSettings
    wells : tuple of str
        Wells of the tops in use.
    unused : tuple of str
        Tops that are not used, each with its reason.
    before, after : float
        Largest misfit of the tops in use [m].
    largest : float
        Largest change of the data [m].
    moved : float
        Share of the data that changed, 0 to 1.
    rounds : int
        How often the horizon was corrected.
    """

    horizon: str
    settings: TieSettings
    wells: tuple[str, ...]
    unused: tuple[str, ...]
    before: float
    after: float
    largest: float
    moved: float
    rounds: int

    def __repr__(self) -> str:
        tops = f"{len(self.wells)} of {len(self.wells) + len(self.unused)} tops"
        # Nothing was moved: all tops are within the tolerance already.
        if not self.rounds:
            most = length_text(round(self.before, 6), 2)
            return f"{tops} are met; misfit at most {most}"
        return (
            f"{tops}; misfit at most "
            f"{length_text(self.before)} before, {length_text(round(self.after, 6), 2)} after; "
            f"{100 * self.moved:.0f} % of the data moved, by up to {length_text(self.largest)}"
        )


def tie_settings(tie: Any) -> TieSettings | None:
    """
    Return how to tie, or None, or raise an error that shows what to write.

    Examples
    --------
    >>> tie_settings(True), tie_settings(False)
    (TieSettings(range=1000.0, tolerance=0.1, assumed=True), None)
    >>> tie_settings({"range": 500})
    TieSettings(range=500.0, tolerance=0.1, assumed=False)
    """
    # False means the same as None: nothing is tied.
    if tie is None or tie is False or isinstance(tie, TieSettings):
        return tie or None
    if tie is True:
        return TieSettings(assumed=True)
    if not isinstance(tie, Mapping):
        raise InputError(f"tie is {tie!r}. {HOW}.")
    # Unknown keys before wrong values: the former is mostly a misspelling of the latter.
    for key, value in tie.items():
        check_word(key, ("range", "tolerance"), f"tie has no option {key!r}.", f" {HOW}.")
        if not (is_number(value) and value > 0):
            raise InputError(f"tie: {key} is {value!r}, expected metres above 0. {HOW}.")

    # what was left out takes its default; `assumed` says that the range was nobody's choice
    values = {key: float(value) for key, value in tie.items()}
    return TieSettings(**values, assumed="range" not in values)
