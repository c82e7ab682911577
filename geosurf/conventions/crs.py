"""Coordinate reference systems: read the declaration of an input, and compare two.

Nothing is converted here; `geosurf.reproject` does that. Systems in feet or degrees are refused,
since easting and northing are metres. An array declares its system in
``attrs["crs"]``, in the variable that its CF attribute ``grid_mapping`` names, or in a coordinate
``spatial_ref`` or ``crs``, as rioxarray writes it. geosurf does not guess whether an EPSG code and
a name mean the same system; it warns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from geosurf.conventions.machine import install_line, is_installed
from geosurf.errors import InputError, warn_of

# attributes of a CF grid mapping that hold a whole reference system, the clearest first
WHOLE = ("epsg_code", "epsg", "crs_wkt", "spatial_ref", "esri_pe_string", "projected_crs_name")
PLACES = ("spatial_ref", "crs")
# Plain codes, PROJ texts, URNs and addresses of the OGC; a vertical system after "+" is ignored.
EPSG = re.compile(
    r"(?:\+init=)?(?:urn:ogc:def:crs:|https?://www\.opengis\.net/def/crs/)?"
    r"epsg[:/](?:[\d.]*[:/])?(\d+)(?:\+\d+)?",
    re.IGNORECASE,
)
CODE = re.compile(r'\[\s*"EPSG"\s*,\s*"?(\d+)"?', re.IGNORECASE)
LENGTH = re.compile(r'UNIT\s*\[\s*"[^"]*"\s*,\s*((?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)', re.IGNORECASE)
# names of EPSG such as "NAD83 / Texas North Central (ftUS)", and texts of PROJ
FEET = re.compile(r"\(ft\w*\)|\+units=(?:us-)?ft\b|\+to_meter=0?\.304", re.IGNORECASE)
# codes of systems in metres: UTM, and large national grids; pyproj knows all others
METRIC = re.compile(
    r"32[2-7](?:[0-5]\d|6[01])|258\d\d|230[2-3]\d|269\d\d|283[4-5]\d|784[6-9]|785\d|2056|2154|2180|"
    r"2193|27700|28992|3006|3035|3067|31370|3146[6-9]|3857"
)
GEOGRAPHIC = re.compile(
    r"(?:GEOG(?:CS|CRS)|GEODCRS)\s*\[|.*\+proj=(?:longlat|latlong)\b"
    r"|.*(?:OGC|CRS)[:\w.]*:?CRS(?:84|83|27)\Z",
    re.IGNORECASE,
)
DEGREES, DEGREE = {4326, 4258, 4269, 4267, 4979}, 0.0174532925199433  # the codes most in use
VERTICAL = re.compile(r"VERT(?:_CS|CRS|ICALCRS)\s*\[", re.IGNORECASE)
PROJECTED = re.compile(r"(?:PROJCS|PROJCRS|PROJECTEDCRS|GEOGCS|GEOGCRS|GEODCRS)\s*\[", re.I)


def crs_of(
    value: Any, variables: Mapping[Any, Any] | None = None, *, any_unit: bool = False
) -> str | None:
    """Return the coordinate reference system that an array or dataset declares, or None.

    Parameters
    ----------
    value : DataArray, Dataset or anything
    variables : mapping, optional
        Where the grid mapping of an array is looked up; default: among its own coordinates.
    any_unit : bool, default False
        Take systems in feet and degrees, too.

    Returns
    -------
    str or None
        A text such as ``"EPSG:32631"``; a long description that has an EPSG code as that code.

    Raises
    ------
    InputError
        If two declarations contradict each other, or if the system is in feet or degrees.

    Examples
    --------
    >>> import geosurf as gs
    >>> top = gs.synthetic.graben(n=9).horizons["Top"]
    >>> crs_of(top), crs_of(top.assign_attrs(crs="EPSG:32631"))
    (None, 'EPSG:32631')
    >>> crs_of(top.assign_coords(spatial_ref=0).assign_attrs(crs="EPSG:32631"))
    'EPSG:32631'
    """
    # Attributes before grid mappings: what a user set by hand counts most.
    declared = [str(one).strip() for one in _declared(value, variables)]
    if not any_unit:
        for text in declared:
            refuse_other_units(text, _title(value))
    systems = [_text(text) for text in declared if text]
    for other in systems[1:]:
        if are_same(systems[0], other) is False:
            raise InputError(
                f"{_title(value)} declares two coordinate reference systems: {label(systems[0])} "
                f"and {label(other)}. Keep the right one, as in attrs['crs'] = "
                f"{label(systems[0])!r}, and drop the grid mapping."
            )
    return systems[0] if systems else None


def are_same(text: str, other: str) -> bool | None:
    """Return whether two texts mean one reference system; None if they cannot be compared.

    Examples
    --------
    >>> are_same("EPSG:32631", "urn:ogc:def:crs:EPSG::32631")
    True
    >>> are_same("EPSG:32631", "epsg:23031"), are_same("EPSG:32631", "UTM zone 31")
    (False, None)
    """
    (kind, first), (kind_of_other, second) = _kind_and_key(text), _kind_and_key(other)
    return first == second if kind == kind_of_other else None


def epsg_of(crs: str) -> int | None:
    """Return the EPSG code of a reference system, or None where its text has none.

    Examples
    --------
    >>> epsg_of("urn:ogc:def:crs:EPSG::23031"), epsg_of("UTM zone 31")
    (23031, None)
    """
    kind, key = _kind_and_key(crs)
    return int(key) if kind == "code" else None


def label(crs: str) -> str:
    """Return a reference system in a few words, for messages.

    Examples
    --------
    >>> label('PROJCS["ED50 / UTM zone 31N",GEOGCS["ED50"],UNIT["metre",1]]')
    'ED50 / UTM zone 31N'
    """
    # The name of a description in WKT is its first text in quotes.
    name = re.match(r'\w+\s*\[\s*"([^"]*)"', crs)
    text = " ".join((name[1] if name else crs).split())
    return text if len(text) <= 60 else text[:57] + "..."


def refuse_other_units(crs: str | None, where: str) -> None:
    """Refuse a system in feet or degrees, and one whose unit cannot be told without pyproj."""
    metres = _metres(crs) if crs else 1.0
    if math.isnan(metres):
        raise InputError(
            f"{where}: the unit of {label(str(crs))} is not known without pyproj: coordinates may "
            f"be in feet. Install it: {install_line('pyproj')}."
        )
    if abs(metres - 1.0) > 1e-9:
        unit = "degrees" if metres < 0.1 else "feet" if 0.3 < metres < 0.31 else f"{metres:g} m"
        raise InputError(
            f"{where}: coordinates are in {unit} ({label(str(crs))}); geosurf takes metres. "
            "Convert them to a projected system, as in gs.reproject(data, 'EPSG:32614'), or "
            "files by ogr2ogr -t_srs EPSG:32614 or gdalwarp -t_srs EPSG:32614."
        )
    vertical = VERTICAL.search(str(crs)) if crs else None
    stated = LENGTH.findall(_bracketed(str(crs)[vertical.start() :])) if vertical else []
    up = float(stated[-1]) if stated else 1.0
    if abs(up - 1.0) > 1e-9:
        raise InputError(
            f"{where}: the vertical part of {label(str(crs))} is in units of "
            f"{up:g} m; geosurf takes metres. Convert elevations, and give a "
            "system without a vertical part."
        )


@lru_cache(maxsize=256)
def _metres(crs: str) -> float:
    """Metres of one unit of easting; 1 where neither the text nor pyproj states a unit.

    NaN where pyproj would have to be asked and is not installed.
    """
    start = PROJECTED.search(crs)
    if start:
        factors = LENGTH.findall(_bracketed(crs[start.start() :]))
        return DEGREE if GEOGRAPHIC.match(start[0]) else float(factors[-1]) if factors else 1.0
    if FEET.search(crs):
        return 0.3048
    code = epsg_of(crs)
    if code in DEGREES or GEOGRAPHIC.match(crs):
        return DEGREE
    if code is None or METRIC.fullmatch(str(code)):
        return 1.0
    if not is_installed("pyproj"):
        return math.nan
    system = proj_system(f"EPSG:{code}")
    return system.axis_info[0].unit_conversion_factor if system and system.axis_info else 1.0


def proj_system(crs: str) -> Any:
    """Return a system as pyproj has it; None if pyproj does not know it, or is not installed."""
    if not is_installed("pyproj"):
        return None
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    try:
        return CRS.from_user_input(crs)
    except CRSError:
        return None


def _bracketed(text: str) -> str:
    """A description up to the bracket that closes it: without the vertical part of a compound."""
    depth = 0
    for match in re.finditer(r'"[^"]*"|\[|\]', text):
        depth += {"[": 1, "]": -1}.get(match[0], 0)
        if match[0] == "]" and not depth:
            return text[: match.end()]
    return text


def refuse_other_crs(name: str, crs: str | None, others: Mapping[str, str]) -> None:
    """Refuse a surface in another unit or reference system than those before it."""
    refuse_other_units(crs, repr(name))
    for other, known in others.items():
        # Only a proven difference is refused; None means that they cannot be compared.
        if crs is not None and are_same(crs, known) is False:
            raise InputError(
                f"{name!r} is in {label(crs)}, but {other!r} is in {label(known)}. Convert one of "
                f"them, as in gs.reproject({name}, {label(known)!r}), or correct attrs['crs'] if "
                "both are in the same system."
            )


def warn_of_unclear_crs(known: Mapping[str, str]) -> None:
    """Warn of the first system that cannot be compared with another."""
    names = list(known)
    for name in names[1:]:
        if are_same(known[names[0]], known[name]) is None:
            warn_of(
                "crs",
                name,
                f"{name!r} declares the coordinate reference system {label(known[name])!r} "
                f"and {names[0]!r} {label(known[names[0]])!r}. geosurf cannot compare them "
                "and treats both as the same system.",
                "If they are the same, give both the same code: attrs['crs'] = 'EPSG:...'. "
                "If not, convert one of them.",
            )
            return


# ---- declarations ----------------------------------------------------------------------


def _declared(value: Any, variables: Mapping[Any, Any] | None) -> list[Any]:
    """Every declaration of an object, the plainest first."""
    attrs = getattr(value, "attrs", {})
    # An attribute of the array itself, then what its variables refer to.
    declared = [attrs.get("crs")]
    if variables is None:
        # `variables` is much faster than making a DataArray of each
        if hasattr(type(value), "data_vars"):
            variables = value.variables
            declared += [variables[key].attrs.get("crs") for key in value.data_vars]
        else:
            variables = getattr(getattr(value, "coords", None), "variables", {})
    named = [_mapping_named_by(value)]
    if hasattr(type(value), "data_vars"):
        named += [_mapping_named_by(variables[key]) for key in value.data_vars]
    # Named mappings first, then the usual names; each variable once.
    for key in dict.fromkeys([*filter(None, named), *PLACES]):
        # A grid mapping is a variable without dimensions; others of that name are data.
        if key in variables and getattr(variables[key], "ndim", 1) == 0:
            declared.append(_of_mapping(variables[key].attrs))
    return [one for one in declared if one is not None]


def _mapping_named_by(value: Any) -> str | None:
    """Name of the variable that holds the grid mapping, from ``grid_mapping = "crs: x y"``."""
    # xarray moves the attribute to `encoding` when it reads a file.
    for words in (getattr(value, "attrs", {}), getattr(value, "encoding", {})):
        text = words.get("grid_mapping")
        if isinstance(text, str) and text.strip():
            return text.split()[0].rstrip(":")
    return None


def _of_mapping(attrs: Mapping[Any, Any]) -> Any:
    """Return the reference system of a grid mapping, or its parameters as a text."""
    # One attribute may describe the whole system; parameters alone are compared as text.
    for key in WHOLE:
        value = attrs.get(key)
        if value is not None and str(value).strip():
            return f"EPSG:{value}" if key.startswith("epsg") and str(value).isdigit() else value
    if "grid_mapping_name" not in attrs:
        return None
    words = (f"{key}={attrs[key]}" for key in sorted(map(str, attrs)))
    return f"grid mapping {', '.join(words)}"


# ---- comparison ------------------------------------------------------------------------


def _text(text: str) -> str:
    """A declaration; a long one with an EPSG code as that code."""
    kind, key = _kind_and_key(text)
    return f"EPSG:{key}" if kind == "code" and not EPSG.fullmatch(text) else text


def _kind_and_key(text: str) -> tuple[str, str]:
    """Return how a reference system is written, and what is compared."""
    match = EPSG.fullmatch(text)
    # A number alone is an EPSG code, as many files write it.
    if match or text.isdigit():
        return "code", str(int(match[1] if match else text))
    if "[" in text:
        start = PROJECTED.search(text)
        # of a compound system, the horizontal one
        horizontal = text[start.start() :] if start else text
        code = _own_code(horizontal)
        return ("code", str(int(code))) if code else ("description", _letters(label(horizontal)))
    return "name", _letters(text)


def _own_code(text: str) -> str | None:
    """EPSG code of a description itself, not one of its parts (ellipsoid, unit, method ...)."""
    depth = 0
    # Brackets are counted: the identifier of the system itself is at depth 1, those of its parts
    # are deeper.
    for match in re.finditer(r'"[^"]*"|\[|\]|(?:AUTHORITY|ID)\s*(?=\[)', text, re.IGNORECASE):
        if match[0] == "[":
            depth += 1
        elif match[0] == "]":
            depth -= 1
            if depth == 0:
                return None
        elif depth == 1 and match[0][0] != '"':
            code = CODE.match(text, match.end())
            if code:
                return code[1]
    return None


# Spelling differs between programs: case, spaces and punctuation are ignored.
def _letters(text: str) -> str:
    return re.sub(r"[\W_]+", "", text).lower()


def _title(value: Any) -> str:
    name = getattr(value, "name", None)
    return f"array {name!r}" if name else "an input"
