"""What becomes of horizons in blocks without data: refused, continued, or pinched out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geosurf.conventions import did_you_mean, known_names
from geosurf.errors import InputError

PINCH_OUT, LOWER, UPPER = "pinch out", "lower", "upper"
WAYS = (PINCH_OUT, LOWER, UPPER)
HOW = (
    "Give True to continue horizons from the neighbouring block, 'lower' or 'upper' to pinch them "
    "out onto the horizon below or above, or {horizon: one of these}"
)


def filling_by_horizon(fill: Any, horizons: Sequence[str]) -> dict[str, bool | str]:
    """
    Return what becomes of each horizon: False, True, or the horizon that it is pinched out onto.

    Parameters
    ----------
    fill : bool, str, mapping of str to bool or str, or None
    horizons : sequence of str
        Youngest first.

    Raises
    ------
    InputError
        For another value, an unknown horizon, or two that would be pinched out onto each other.

    Examples
    --------
    >>> filling_by_horizon("lower", ["Top", "Base"])
    {'Top': 'Base', 'Base': False}
    >>> filling_by_horizon({"Base": "upper"}, ["Top", "Base"])
    {'Top': False, 'Base': 'Top'}
    """
    # One word counts for all horizons; a mapping names some.
    given = fill if isinstance(fill, Mapping) else dict.fromkeys(horizons, fill)
    found: dict[str, bool | str] = dict.fromkeys(horizons, False)
    for name, way in given.items():
        if name not in found:
            raise InputError(
                f"fill_empty_blocks names {name!r}, which is not a horizon. The horizons are "
                f"{known_names(horizons, name)}"
            )
        if way is None or isinstance(way, bool):
            found[name] = bool(way)
            continue
        if way not in WAYS:
            raise InputError(f"fill_empty_blocks is {way!r}. {HOW}.{did_you_mean(way, WAYS)}")
        # Horizons are ordered youngest first: the one above comes before.
        at = horizons.index(name) + (-1 if way == UPPER else 1)
        if 0 <= at < len(horizons):
            found[name] = horizons[at]
        # Asked for this horizon: an error. Asked for all: the outermost horizon stays as it is.
        elif isinstance(fill, Mapping):
            where = "above" if way == UPPER else "below"
            raise InputError(
                f"fill_empty_blocks: no horizon lies {where} {name!r}, so it cannot be pinched out "
                f"there. Give {LOWER if way == UPPER else UPPER!r}."
            )
    # Each would wait for the other to be built first.
    for name, onto in found.items():
        if isinstance(onto, str) and found[onto] == name:
            raise InputError(
                f"fill_empty_blocks would pinch out {name!r} and {onto!r} onto each other. Change "
                "one of them."
            )
    return found


def in_order(filling: Mapping[str, bool | str]) -> list[str]:
    """Return the horizons, each after the one that it is pinched out onto.

    Examples
    --------
    >>> in_order({"Top": "Base", "Base": False})
    ['Base', 'Top']
    """
    done: list[str] = []
    # Each pass adds the horizons whose neighbour is done; chains end, since none points back.
    while len(done) < len(filling):
        done += [
            name
            for name, onto in filling.items()
            if name not in done and (isinstance(onto, bool) or onto in done)
        ]
    return done
