"""Checks of arguments of the wrong kind: each raises an error of one or two sentences.

Front doors look at what they are given before anything is computed; names in place of surfaces,
words in place of numbers and folders in place of files are refused here, with the same messages.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import CONVERSION_ERRORS, is_number, real_numbers
from geosurf.errors import InputError

SIDES = ("west", "east", "south", "north", "bottom", "top")
ORDER = f"({', '.join(SIDES)})"


def expect(value: Any, kind: type | tuple[type, ...], takes: str, how: str) -> None:
    """
    Refuse what is of another kind than is taken.

    Parameters
    ----------
    value : object
    kind : type or tuple of type
    takes : str
        Who takes what: ``"carve_units takes Patches"``.
    how : str
        Where such a thing comes from, or what to do.

    Raises
    ------
    InputError

    Examples
    --------
    >>> expect("Top", dict, "a scene takes a mapping", "give {name: ...}")
    Traceback (most recent call last):
    geosurf.errors.InputError: a scene takes a mapping, not str; give {name: ...}.
    """
    # One message for every front door: who takes what, and where it comes from.
    if not isinstance(value, kind):
        raise InputError(f"{takes}, not {type(value).__name__}; {how}.")


def path_of(path: Any, what: str) -> Path:
    """
    Return a path, or raise an error for anything else.

    Raises
    ------
    InputError

    Examples
    --------
    >>> path_of("out/view.png", "a picture").suffix
    '.png'
    >>> path_of(5, "a picture")
    Traceback (most recent call last):
    geosurf.errors.InputError: a picture: 5 is not a path. Give text or a pathlib.Path.
    """
    # Numbers would open file descriptors.
    if isinstance(path, str | os.PathLike):
        try:
            # objects with __fspath__ may return bytes or raise what they like: paths are text here
            text = os.fspath(path)
        except (TypeError, ValueError, *CONVERSION_ERRORS):
            text = ""
        # Characters that no file system takes; the system's own message would name no argument.
        if isinstance(text, str) and text and "\0" not in text and _is_encodable(text):
            return Path(text)
    # What gets here is no text, or text that no file system takes.
    raise InputError(f"{what}: {path!r} is not a path. Give text or a pathlib.Path.")


def name_of(name: Any, what: str) -> str:
    """
    Return a name as text, or raise an error. Integers are names, too.

    Raises
    ------
    InputError

    Examples
    --------
    >>> name_of(7, "horizon")
    '7'
    >>> name_of(["F1"], "fault")
    Traceback (most recent call last):
    geosurf.errors.InputError: the name of a fault must be text, not ['F1'].
    """
    # booleans are ints, and never meant as a name
    if isinstance(name, str | int | np.integer) and not isinstance(name, bool):
        # Subclasses of text, such as those of numpy, become plain text.
        text = name if type(name) is str else str(name)
        if _is_encodable(text):
            return text
        raise InputError(
            f"the name of a {what}, {text!r}, has characters that files cannot store. Use "
            "Unicode letters."
        )
    raise InputError(f"the name of a {what} must be text, not {name!r}.")


def _is_encodable(text: str) -> bool:
    """Whether text can be written: halves of a surrogate pair cannot."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def number_of(value: Any, what: str, hint: str = "give one finite number") -> float:
    """
    Return one finite number, or raise an error.

    Raises
    ------
    InputError

    Examples
    --------
    >>> number_of("25", "reach", "give metres")
    Traceback (most recent call last):
    geosurf.errors.InputError: reach is '25'; give metres.
    """
    if not is_number(value):
        raise InputError(f"{what} is {value!r}; {hint}.")
    return float(value)


def flag_of(value: Any, what: str) -> bool:
    """
    Return a boolean, or raise an error for anything else.

    Raises
    ------
    InputError

    Examples
    --------
    >>> flag_of("no", "refine")
    Traceback (most recent call last):
    geosurf.errors.InputError: refine must be True or False, not 'no'.
    """
    # 0 and 1 are taken as flags; 2, None and texts are slips
    if isinstance(value, bool | np.bool_) or (type(value) is int and value in (0, 1)):
        return bool(value)
    raise InputError(f"{what} must be True or False, not {value!r}.")


def box_of_sides(box: Any) -> np.ndarray:
    """
    Return a model box as an array, or raise an error that names the wrong side.

    Parameters
    ----------
    box : (west, east, south, north, bottom, top)
        World coordinates [m], elevation positive up.

    Returns
    -------
    ndarray of float64, shape (6,)

    Raises
    ------
    InputError
        If these are not six finite numbers, or a low side is not below its high side.

    Examples
    --------
    >>> box_of_sides((0, 9, 0, 9, -100, -200))
    Traceback (most recent call last):
    geosurf.errors.InputError: box: bottom (-100) is not less than top (-200). The order is (west, east, south, north, bottom, top). Elevation is positive up, so depths are negative.
    """  # noqa: E501 - a message
    from geosurf.kernels.exact.predicates import MAX_COORDINATE  # not for all who import the nouns

    try:
        limits = real_numbers(box)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"box: expected six numbers, found {box!r}. Give {ORDER} in metres."
        ) from error
    # The shape before the values: a message on one value would hide the wrong number of them.
    if limits.shape != (6,):
        raise InputError(
            f"box: found shape {limits.shape}, expected six numbers. Give {ORDER} in metres."
        )
    for side, value in zip(SIDES, limits.tolist(), strict=True):
        if not np.isfinite(value):
            raise InputError(f"box: {side} is {value}. Give six finite numbers {ORDER} in metres.")
        if abs(value) > MAX_COORDINATE:
            raise InputError(
                f"box: {side} is {value:g} m, but coordinates are limited to "
                f"{MAX_COORDINATE:g} m. Give the box that the model fills, {ORDER} in metres."
            )

    # a box without room divides nothing: refused here rather than as an empty model
    for low, high in ((0, 1), (2, 3), (4, 5)):
        if not limits[low] < limits[high]:
            hint = " Elevation is positive up, so depths are negative." if low == 4 else ""
            raise InputError(
                f"box: {SIDES[low]} ({limits[low]:g}) is not less than {SIDES[high]} "
                f"({limits[high]:g}). The order is {ORDER}.{hint}"
            )
    return limits


def listed(values: Any, takes: str, how: str) -> Sequence[Any]:
    """
    Return values as a tuple, or raise an error if they cannot be iterated.

    Raises
    ------
    InputError

    Examples
    --------
    >>> listed(5, "intersect_surfaces takes surfaces", "give a list")
    Traceback (most recent call last):
    geosurf.errors.InputError: intersect_surfaces takes surfaces, not int; give a list.
    """
    try:
        return tuple(values)
    except (TypeError, ValueError, *CONVERSION_ERRORS) as error:
        raise InputError(f"{takes}, not {type(values).__name__}; {how}.") from error


def outline_of(box: Sequence[float] | np.ndarray, aoi: Any = None) -> np.ndarray:
    """Corners (n, 2) of an area of interest, else of a box, counter-clockwise from south-west."""
    w, e, s, n = box[:4]
    ring = [(w, s), (e, s), (e, n), (w, n)]
    return np.array(ring if aoi is None else aoi, dtype=np.float64)
