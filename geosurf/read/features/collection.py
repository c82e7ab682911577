"""Points and lines with attributes -> a table of points, polygons, or the sticks of a fault.

Elevations are third coordinates, or an attribute: one with a usual name (z, depth ...), or the one
that the third name of ``columns=`` states. Lines without elevations lie in the map, at z = 0.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.column_names import USUAL
from geosurf.conventions.crs import EPSG, crs_of, label
from geosurf.errors import FormatError, GeosurfWarning, InputError
from geosurf.model import FaultSticks
from geosurf.model.base import in_crs_of
from geosurf.read._choice import chosen
from geosurf.read._common import agreed_scale, agreed_sign
from geosurf.read._noted import is_looking, noted
from geosurf.read._placed import AXES, points_dataset
from geosurf.warning import warn

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# attributes that name the fault or horizon of a feature, lower case; the first that is there counts
NAMES = ("name", "fault", "fault_name", "faultname", "horizon", "surface")
KINDS = ("point", "line", "ring")
GEOGRAPHIC = re.compile(r"\AGEOG(?:CS|CRS)\s*\[|(?:OGC|CRS)[:\w.]*:?CRS(?:84|83|27)\Z", re.I)
# codes of EPSG in degrees that files of this kind carry most
DEGREES = {"EPSG:4326", "EPSG:4258", "EPSG:4269", "EPSG:4267", "EPSG:4979"}


class _Declared:
    """What `crs_of` looks at."""

    def __init__(self, crs: str | None) -> None:
        self.attrs = {"crs": crs}


def crs_from(text: str) -> str | None:
    """
    Return a reference system as geosurf has it: an EPSG code where the text has one.

    Examples
    --------
    >>> crs_from("urn:ogc:def:crs:EPSG::23031"), crs_from(" ")
    ('EPSG:23031', None)
    """
    found = crs_of(_Declared(" ".join(text.split()) or None))
    code = EPSG.fullmatch(found or "")
    return f"EPSG:{code[1]}" if code else found


@dataclass(frozen=True)
class Feature:
    """One part of a feature.

    Attributes
    ----------
    kind : {"point", "line", "ring"}
        A ring is the border of an area.
    points : ndarray of float64, shape (n, 3)
        x, y, z; NaN where there is no z.
    words : dict
        Attributes of the feature.
    """

    kind: str
    points: np.ndarray
    words: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the fault or horizon, or nothing."""
        words = {key.lower(): value for key, value in self.words.items()}
        found = (words[key] for key in NAMES if words.get(key) not in (None, ""))
        return str(next(found, ""))


@dataclass(frozen=True)
class Features:
    """What a file holds.

    Attributes
    ----------
    path : pathlib.Path
    items : list of Feature
    crs : str or None
    empty : int
        Features without a place, which are left out.
    positive, length_unit : str or None
        What the file states of z.
    """

    path: Path
    items: list[Feature]
    crs: str | None = None
    empty: int = 0
    positive: str | None = None
    length_unit: str | None = None

    def checked(self) -> Features:
        """Return self, or raise an error if there is nothing, or if places are in degrees."""
        if not self.items:
            raise FormatError(f"{self.path}: the file has no points and no lines. Export it again.")
        noted("features", ", ".join(counted(n, kind) for kind, n in self._counts().items()))
        keys = list(dict.fromkeys(key for one in self.items for key in one.words))
        noted("attributes", ", ".join(keys) or "none")
        if self.empty:
            noted("left out", counted(self.empty, "feature") + " without a place")
        if self.crs is not None:
            noted("crs", label(self.crs))
            if GEOGRAPHIC.search(self.crs) or self.crs in DEGREES:
                raise InputError(
                    f"{self.path}: coordinates are in degrees ({label(self.crs)}); geosurf takes "
                    "metres. Convert the file, as in ogr2ogr -t_srs EPSG:32631 out.geojson in."
                )
        self._warn_of_degrees()
        return self

    def _counts(self) -> dict[str, int]:
        found: Counter[str] = Counter()
        for one in self.items:
            found[one.kind] += len(one.points) if one.kind == "point" else 1
        return {kind: found[kind] for kind in KINDS if found[kind]}

    def _warn_of_degrees(self) -> None:
        """Small numbers may be degrees, also in systems that are given by a code."""
        x, y = np.concatenate([one.points[:, :2] for one in self.items]).T
        # a plain model may begin at 0, but rarely lies below 90 in all
        if np.abs(x).max() <= 180 and np.abs(y).max() <= 90 and not is_looking():
            effect = (
                f"Coordinates of '{self.path.name}' are {x.min():g} to {x.max():g} by {y.min():g} "
                f"to {y.max():g}, which could be degrees. geosurf takes them as metres."
            )
            remedy = "If they are degrees, convert the file to a projected system."
            warn(GeosurfWarning("crs", self.path.name, effect, remedy))

    def only(self, kinds: Sequence[str], caller: str) -> list[Feature]:
        """All features, if they are of some kinds."""
        if any(one.kind not in kinds for one in self.items):
            held = " and ".join(counted(n, kind) for kind, n in self._counts().items())
            readers = {
                "point": "read_points", "line": "read_fault or read_polygons",
                "ring": "read_polygons",
            }  # fmt: skip
            others = [readers[kind] for kind in self._counts() if kind not in kinds]
            remedy = (
                "Write one file for each kind."
                if len(self._counts()) > 1
                else f"Read it with {others[0]}."
            )
            raise FormatError(
                f"{self.path}: the file holds {held}, which {caller} does not read. {remedy}"
            )
        return self.items

    def raised(self, columns: Any) -> Features:
        """Return the same with z from an attribute, where there are no third coordinates."""
        flat = [one for one in self.items if np.isnan(one.points[:, 2]).any()]
        if not flat and columns is None:
            noted("elevations", "third coordinates")
            return self
        key = self._attribute_of_z(columns, bool(flat))
        if key is None:
            return self
        noted("elevations", f"attribute {key}")
        items = []
        for k, one in enumerate(self.items):
            value = one.words.get(key)
            if (
                isinstance(value, bool)
                or not isinstance(value, int | float)
                or not np.isfinite(value)
            ):
                raise FormatError(
                    f"{self.path}: attribute {key!r} of feature {k} (counted from 0) is {value!r}, "
                    "expected a number. Complete it, or delete the feature."
                )
            points = one.points.copy()
            points[:, 2] = value
            items.append(Feature(one.kind, points, one.words))
        return Features(self.path, items, self.crs, self.empty, self.positive, self.length_unit)

    def _attribute_of_z(self, columns: Any, flat: bool) -> str | None:
        """Name of the attribute that holds z."""
        keys = list(dict.fromkeys(key for one in self.items for key in one.words))
        if columns is not None:
            if isinstance(columns, str) or len(list(columns)) != 3 or list(columns)[2] not in keys:
                raise InputError(
                    f"{self.path}: columns is {columns!r}. x and y are coordinates here; give the "
                    f"attribute of z as the third name, one of {', '.join(keys) or 'none'}, as in "
                    "columns=('X', 'Y', 'DEPTH')."
                )
            return str(list(columns)[2])
        usual = [key for key in keys if key.lower() in (*USUAL["z"], "tvdss")]
        return usual[0] if flat and len(usual) == 1 else None

    def to_metres(self, one: Feature, scale: float) -> np.ndarray:
        """Points of a feature with elevations."""
        missing = int(np.isnan(one.points[:, 2]).sum())
        if missing:
            keys = ", ".join(one.words) or "none"
            raise FormatError(
                f"{self.path}: {missing} of {counted(len(one.points), 'point')} of a {one.kind} "
                f"have no elevation (attributes: {keys}). Give the attribute that holds it, as in "
                "columns=('X', 'Y', 'DEPTH'), or export third coordinates."
            )
        return one.points * [1.0, 1.0, scale] + 0.0


def points_of(
    found: Features, positive: str | None, length_unit: str | None, columns: Any
) -> xr.Dataset:
    """
    Return points with their attributes.

    Parameters
    ----------
    found : Features
    positive : {"up", "down"} or None
    length_unit : str or None
    columns : sequence of str or None
        The third name is the attribute that holds z.

    Returns
    -------
    xarray.Dataset
        ``easting``, ``northing``, ``elevation`` and the attributes over ``point``.

    Raises
    ------
    FormatError
        If the file holds lines, or points without elevations.
    InputError
        If `positive` is missing, or coordinates are degrees.
    """
    found = found.checked().raised(columns)
    items = found.only(("point",), "read_points")
    scale = _scale(found, positive, length_unit, "points")
    xyz = np.concatenate([found.to_metres(one, scale) for one in items])
    keys = dict.fromkeys(key for one in items for key in one.words)
    sizes = [len(one.points) for one in items]
    # an attribute called as a coordinate would hide it
    others: dict[str, Any] = {}
    for key in (key for key in keys if key.lower() not in (*AXES, *others)):
        others[key] = ("point", _column([one.words.get(key) for one in items], sizes))
    return points_dataset(xyz, found.path.name, found.crs, others)


def _column(values: list[Any], sizes: list[int]) -> np.ndarray:
    """One value for each point: numbers as float64, else objects."""
    numeric = all(
        value is None or (isinstance(value, int | float) and not isinstance(value, bool))
        for value in values
    )
    column = np.array([np.nan if numeric and v is None else v for v in values],
                      dtype=np.float64 if numeric else object)  # fmt: skip
    return np.repeat(column, sizes)


def polygons_of(
    found: Features,
    positive: str | None,
    length_unit: str | None,
    columns: Any,
    name: str | None,
) -> list[np.ndarray]:
    """
    Return lines and the borders of areas, each (n, 3), in file order.

    Parameters
    ----------
    found, positive, length_unit, columns
        As for `points_of`.
    name : str or None
        Only those of this name.

    Raises
    ------
    FormatError
        If the file holds points.
    InputError
        If `positive` is missing while some z is not 0, or no line has that name.
    """
    found = found.checked().raised(columns)
    items = named_only(found.path, found.only(("line", "ring"), "read_polygons"), name)
    z = np.concatenate([one.points[:, 2] for one in items])
    # lines drawn on a map have no z, or 0 throughout
    if np.isnan(z).all() or (positive is None and found.positive is None and not z.any()):
        noted("elevations", "none: lines lie in the map, z = 0")
        return [np.nan_to_num(one.points) for one in items]
    scale = _scale(found, positive, length_unit, "polygons")
    return [found.to_metres(one, scale) for one in items]


def sticks_of(
    found: Features, name: str | None, positive: str | None, length_unit: str | None, columns: Any
) -> FaultSticks:
    """
    Return the lines of one fault as its sticks.

    Parameters
    ----------
    found, positive, length_unit, columns
        As for `points_of`.
    name : str or None
        Which fault, if there are several; else its name.

    Raises
    ------
    FormatError
        If the file holds points or areas, or lines have no elevations.
    InputError
        If there are several faults and `name` picks none, or `positive` is missing.
    """
    found = found.checked().raised(columns)
    groups: dict[str, list[Feature]] = {}
    for one in found.only(("line",), "read_fault"):
        groups.setdefault(one.name, []).append(one)
    title, items = chosen(found.path, groups, name, "faults")
    scale = _scale(found, positive, length_unit, "fault sticks")
    sticks = tuple(found.to_metres(one, scale) for one in items)
    return in_crs_of(FaultSticks(name or title or found.path.stem, sticks), [found])


def named_only(path: Path, items: list[Feature], name: str | None) -> list[Feature]:
    """Features of one name; all of them without a name."""
    names = list(dict.fromkeys(one.name for one in items if one.name))
    if names:
        noted("names", ", ".join(names[:12]) + (" ..." if len(names) > 12 else ""))
    if name is None:
        return items
    found = [one for one in items if one.name == name]
    if not found:
        raise InputError(
            f"{path}: no line is called {name!r}. Names are {', '.join(names[:12]) or 'absent'}; "
            "leave name= out to read all lines."
        )
    return found


def _scale(found: Features, positive: str | None, length_unit: str | None, what: str) -> float:
    """Metres of elevation per unit of z."""
    what = f"{found.path.name}: {what}"
    sign = agreed_sign(found.positive, positive, what)
    return sign * agreed_scale(found.length_unit, length_unit, "m", what)
