"""How messages, reports and the command line write names, counts, places and sizes."""

from __future__ import annotations

import difflib
import json
import math
from collections.abc import Iterable
from typing import Any, TypeVar

from geosurf.conventions.axes import vertical_words
from geosurf.conventions.checks import is_word
from geosurf.errors import InputError

Key = TypeVar("Key")
Value = TypeVar("Value")


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """Return ' Did you mean ...?' for a misspelt word, or '' if no known word is close.

    Examples
    --------
    >>> did_you_mean("horizns", ["horizons", "faults"])
    " Did you mean 'horizons'?"
    >>> did_you_mean("owc", ["OWC", "GOC"])
    " Did you mean 'OWC'?"
    """
    close = closest(word, known)
    return "" if close is None else f" Did you mean {close!r}?"


def closest(word: Any, known: Iterable[str]) -> str | None:
    """Return the known word that a misspelt one is close to, or None."""
    names = list(map(str, known))
    close = difflib.get_close_matches(str(word), names, n=1)
    if not close:  # upper and lower case count first, then they do not
        plain = {name.casefold(): name for name in reversed(names)}
        close = [
            plain[match] for match in difflib.get_close_matches(str(word).casefold(), plain, n=1)
        ]
    return close[0] if close else None


def check_word(
    value: Any,
    known: Iterable[str],
    refusal: str,
    more: str = "",
    error: type[Exception] = InputError,
) -> None:
    """Raise an error for what is no known word; after the refusal it names the one that is meant.

    Examples
    --------
    >>> check_word("dow", ("up", "down"), "positive is 'dow'.")
    Traceback (most recent call last):
    geosurf.errors.InputError: positive is 'dow'. Did you mean 'down'?
    """
    if not is_word(value, known):
        raise error(f"{refusal}{did_you_mean(value, known)}{more}")


def known_names(known: Iterable[str], word: Any = None) -> str:
    """Return names that exist as a list, the first ones of many, and which of them is meant.

    Examples
    --------
    >>> known_names(["Top", "Base"], "Tpo")
    "['Top', 'Base']. Did you mean 'Top'?"
    >>> known_names(["Top", "Base"], "F1")
    "['Top', 'Base']."
    >>> known_names(map(str, range(500)))[-25:]
    "'18', '19'] and 480 more."
    """
    names = list(map(str, known))
    few = names if len(names) <= 30 else names[:20]
    more = "" if len(few) == len(names) else f" and {len(names) - len(few)} more"
    return f"{few}{more}.{'' if word is None else did_you_mean(word, names)}"


def check_name(name: Any, known: Iterable[str], refusal: str, more: str = "") -> None:
    """Raise an error for a name that nothing has; after the refusal those that exist are listed.

    Examples
    --------
    >>> check_name("Tpo", ["Top", "Base"], "no horizon is called 'Tpo'. The horizons are")
    Traceback (most recent call last):
    geosurf.errors.InputError: no horizon is called 'Tpo'. The horizons are ['Top', 'Base']. \
Did you mean 'Top'?
    """
    if not is_word(name, known):
        raise InputError(f"{refusal} {known_names(known, name)}{more}")


def grouped(pairs: Iterable[tuple[Key, Value]]) -> dict[Key, list[Value]]:
    """Return the values of each key, both in their order.

    Examples
    --------
    >>> grouped([("F1", "up"), ("F2", "down"), ("F1", "down")])
    {'F1': ['up', 'down'], 'F2': ['down']}
    """
    groups: dict[Key, list[Value]] = {}
    for key, value in pairs:
        groups.setdefault(key, []).append(value)
    return groups


def counted(n: int, word: str) -> str:
    """Return a number with its noun, in the plural where the number asks for it.

    Examples
    --------
    >>> counted(1, "curve"), counted(0, "fault"), counted(2, "patch")
    ('1 curve', '0 faults', '2 patches')
    """
    # "patches", "branches": the only irregular plurals in messages.
    ending = "" if n == 1 else "es" if word.endswith("ch") else "s"
    return f"{n} {word}{ending}"


def toml_key(name: str) -> str:
    """
    Return a name as a key of TOML, for what users are advised to type.

    Examples
    --------
    >>> toml_key("F1"), toml_key("F2 north")
    ('F1', '"F2 north"')
    """
    plain = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    return name if plain else json.dumps(name, ensure_ascii=False)


def number_text(value: float, digits: int = 3) -> str:
    """Return a number as people read it: rounded, and grouped by spaces from five digits on.

    Parameters
    ----------
    value : float
    digits : int, default 3
        Significant digits; digits before the decimal point are never dropped.

    Returns
    -------
    str

    Examples
    --------
    >>> number_text(5931870.4), number_text(1291), number_text(0.123456), number_text(-2.50)
    ('5 931 870', '1291', '0.123', '-2.5')
    >>> number_text(1.5e-7), number_text(19000.44, 6)
    ('1.5e-07', '19 000.4')
    """
    if not math.isfinite(value):
        return str(value)
    size = abs(value)
    # Small numbers keep significant digits, large ones all digits before the point.
    if size < 10**digits:
        text = f"{value:.{digits}g}"
        # Rounding may lead to an exponent: 999.9 in three digits is 1e+03.
        text = text if "e" not in text or size < 1.0 else f"{value:.0f}"
        whole, point, rest = text.partition(".")
        if round(size) < 10_000:
            return text
        return f"{int(whole):,}".replace(",", " ") + point + rest
    grouping = "," if round(size) >= 10_000 else ""
    return f"{value:{grouping}.0f}".replace(",", " ")


def length_text(metres: float, digits: int = 3) -> str:
    """Return a length with its unit, for messages: metres, and kilometres from 1000 m on.

    Examples
    --------
    >>> length_text(12.345), length_text(12748.0)
    ('12.3 m', '12.7 km')
    """
    in_km = abs(metres) >= 1e3
    return (
        f"{number_text(metres / 1e3, digits)} km" if in_km else f"{number_text(metres, digits)} m"
    )


def area_text(square_metres: float, digits: int = 3) -> str:
    """Return an area with its unit, for messages: m², and km² from 0.1 km² on.

    Examples
    --------
    >>> area_text(2500.0), area_text(3.5e6)
    ('2500 m²', '3.5 km²')
    """
    (text,) = area_texts([square_metres], digits)
    return text


def area_texts(square_metres: Iterable[float], digits: int = 3) -> list[str]:
    """Return areas of one table or legend, all in the unit of the largest one.

    Examples
    --------
    >>> area_texts([3.5e6, 2500.0])
    ['3.5 km²', '0.0025 km²']
    >>> area_texts([2500.0, 12.5])
    ['2500 m²', '12.5 m²']
    """
    areas = list(square_metres)
    if vertical_words()[1] == "ms":  # upright areas: what is a picture of times has no others
        return [f"{number_text(area, digits)} m·ms" for area in areas]
    # One unit for a whole table, so that rows can be compared.
    if max(map(abs, areas), default=0.0) >= 1e5:
        return [f"{number_text(area / 1e6, digits)} km²" for area in areas]
    return [f"{number_text(area, digits)} m²" for area in areas]


def shared_name(named: Iterable[tuple[str, str]]) -> str:
    """Return a message on the first name that two inputs have; empty if each has its own.

    Parameters
    ----------
    named : iterable of (str, str)
        Kind and name of each input: ``("fault", "F1")``. Results are requested by name.

    Examples
    --------
    >>> shared_name([("horizon", "Top"), ("fault", "F1"), ("fault", "Top")])
    "'Top' is the name of a horizon and of a fault; rename one."
    """
    seen: dict[str, str] = {}
    for kind, name in named:
        if name in seen:
            other = f"another {kind}" if seen[name] == kind else f"a {kind}"
            return f"{name!r} is the name of a {seen[name]} and of {other}; rename one."
        seen[name] = kind
    return ""


def volume_text(cubic_metres: float, digits: int = 3) -> str:
    """Return a volume with its unit, for messages: m³, and million m³ from one million on.

    Examples
    --------
    >>> volume_text(84.52e6), volume_text(12500.0), volume_text(1.2345e10)
    ('84.5 million m³', '12 500 m³', '12 345 million m³')
    """
    if vertical_words()[1] == "ms":
        return f"{number_text(cubic_metres, digits)} m²·ms"
    if abs(cubic_metres) >= 1e6:
        return f"{number_text(cubic_metres / 1e6, digits)} million m³"
    return f"{number_text(cubic_metres, digits)} m³"


def place(point: Iterable[float]) -> str:
    """Return a position as people read it, for messages: decimetres, or millimetres below 1000 m.

    Parameters
    ----------
    point : iterable of float
        Easting and northing, or easting, northing and elevation [m].

    Returns
    -------
    str

    Examples
    --------
    >>> place((456000.125, 6780000.5, -2000))
    '(E 456 000.1, N 6 780 000.5, elevation -2000 m)'
    >>> place((4.0, 0.5))
    '(E 4, N 0.5)'
    """
    east, north, *elevation = (_coordinate_text(float(value)) for value in point)
    what, unit = ("elevation", "m") if vertical_words()[1] == "m" else ("time", "ms")
    height = f", {what} {elevation[0]} {unit}" if elevation else ""
    return f"(E {east}, N {north}{height})"


def _coordinate_text(value: float) -> str:
    """One coordinate [m], without zeros at its end, grouped by spaces from five digits on."""
    if not math.isfinite(value):
        return str(value)
    # Spaces group digits, as readers of every country understand them.
    grouping = "," if abs(value) >= 10_000 else ""
    text = f"{value:{grouping}.{1 if abs(value) >= 1000 else 3}f}".replace(",", " ")
    text = text.rstrip("0").rstrip(".")
    # Rounding may leave a minus in front of zero.
    return "0" if text == "-0" else text
