"""How horizons are torn at faults: as they were picked, or by throw."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from geosurf.conventions import check_name, is_number
from geosurf.errors import InputError

# ---- as picked ----------------------------------------


@dataclass(frozen=True)
class TearSettings:
    """
    How horizons are torn that were picked or gridded across their faults: see `tear_horizon`.

    Attributes
    ----------
    trim : "auto", float or dict of str to float
        [cells]
    noise : float or None
        [m]
    keep_outliers : bool
    horizons : tuple of str
        Those that are torn; empty: all.
    """

    trim: Any = "auto"
    noise: float | None = None
    keep_outliers: bool = False
    horizons: tuple[str, ...] = ()


_WORDS = tuple(one.name for one in fields(TearSettings))


def tear_settings(tear: Any, faults: Collection[str]) -> TearSettings | None:
    """
    Return how horizons are torn, not checked yet; None if they are not.

    Examples
    --------
    >>> tear_settings(3.0, ["F1"]).trim, tear_settings({"trim": 3.0, "noise": 0.0}, ["F1"]).noise
    (3.0, 0.0)
    """
    if tear is None or tear is False or isinstance(tear, TearSettings):
        return tear or None
    if isinstance(tear, Mapping) and tear and all(k in _WORDS and k not in faults for k in tear):
        return TearSettings(**{**tear, "horizons": tuple(tear.get("horizons", ()))})
    return TearSettings("auto" if tear is True else tear)


# ---- by throw ----------------------------------------

_OF_THROW = ("throw", "horizons", "reach", "hanging_wall", "direction")


@dataclass(frozen=True, eq=False)
class FaultThrow:
    """
    The throw of a fault, for horizons that are still continuous: see `throw_horizon`.

    Attributes
    ----------
    fault : str
    throw : object
        In any form that `throw_horizon` takes.
    horizons : tuple of str
        Those that it moves; empty: all that the fault reaches.
    reach : float or None
    hanging_wall : float
    direction : {"local", "mean"}
    """

    fault: str
    throw: Any
    horizons: tuple[str, ...] = ()
    reach: float | None = None
    hanging_wall: float = 1.0
    direction: str = "local"

    def largest(self, length: float) -> float:
        """Return the largest throw [m]; a function is asked along the length of its fault [m].

        Examples
        --------
        >>> FaultThrow("F1", [[0.0, 10.0], [900.0, -30.0]]).largest(900.0)
        30.0
        """
        throw = getattr(self.throw, "largest", self.throw)  # of an ellipse
        if hasattr(throw, "dims"):
            throw = throw.values
        elif callable(throw):
            throw = throw(np.linspace(0.0, length, 257))
        values = np.asarray(throw, dtype=np.float64)
        is_profile = values.ndim == 2 and not hasattr(self.throw, "dims")
        return float(np.nanmax(np.abs(values[:, 1] if is_profile else values)))

    def times(self, factor: float) -> FaultThrow:
        """Return the same with its throw multiplied, in the form that it has.

        Examples
        --------
        >>> FaultThrow("F1", [[0.0, 10.0], [900.0, 30.0]]).times(2.0).throw.tolist()
        [[0.0, 20.0], [900.0, 60.0]]
        """
        throw: Any = self.throw
        if hasattr(throw, "largest"):  # an ellipse
            made: Any = replace(throw, largest=throw.largest * factor)
        elif callable(throw) and not hasattr(throw, "dims"):
            made = _Times(throw, factor)
        elif is_number(throw) or hasattr(throw, "dims"):  # an array keeps its coordinates
            made = throw * factor
        else:  # pairs of distance and throw
            made = np.asarray(throw, dtype=np.float64) * np.array([1.0, factor])
        return replace(self, throw=made)


@dataclass(frozen=True)
class _Times:
    """A function of the distance along strike, multiplied; other processes can be sent it."""

    throw: Any
    factor: float

    def __call__(self, along: np.ndarray) -> np.ndarray:
        """Throw [m] at distances along strike [m]."""
        return np.asarray(self.throw(along)) * self.factor


def throws_of(throws: Any) -> tuple[FaultThrow, ...]:
    """
    Return throws, the youngest fault first, as `Scene` takes them.

    Examples
    --------
    >>> throws_of({"F1": 60.0, "F2": {"throw": 40.0, "horizons": ["Top"]}})[1].horizons
    ('Top',)
    """
    if throws is None:
        return ()
    if not isinstance(throws, Mapping):
        if isinstance(throws, tuple | list) and all(isinstance(one, FaultThrow) for one in throws):
            return tuple(throws)
        raise InputError(
            f"throws is a {type(throws).__name__}; give a mapping {{fault: throw}}, as in "
            '{"F1": 60.0}, or {"F1": {"throw": 60.0, "horizons": ["Top"], "reach": 900.0}}.'
        )
    listed = []
    for fault, given in throws.items():
        words = given if isinstance(given, Mapping) else {"throw": given}
        if "throw" not in words or not words.keys() <= set(_OF_THROW):
            raise InputError(
                f"throws[{fault!r}] has {', '.join(map(repr, words))}; give throw, and if needed "
                f"{', '.join(_OF_THROW[1:])}."
            )
        listed.append(FaultThrow(fault, **{**words, "horizons": tuple(words.get("horizons", ()))}))
    return tuple(listed)


# ---- checks ----------------------------------------


def check_tears(
    tear: TearSettings | None,
    throws: Sequence[FaultThrow],
    faults: Sequence[str],
    horizons: Sequence[str],
) -> None:
    """Refuse trims that are none, names that a scene does not have, and horizons torn twice."""
    _check_names("throws", "fault", [throw.fault for throw in throws], faults)
    for throw in throws:
        _check_names(f"throws[{throw.fault!r}]", "horizon", throw.horizons, horizons)
    if tear is None:
        return
    trims = tear.trim
    values = list(trims.values()) if isinstance(trims, Mapping) else [trims]
    if not values or not all(
        (isinstance(value, str) and value == "auto") or (is_number(value) and value > 0)
        for value in values
    ):
        raise InputError(
            f'tear is {trims!r}; give True, "auto", a trim in cells above 0, or {{fault: cells}}.'
        )
    _check_names("tear", "fault", trims if isinstance(trims, Mapping) else (), faults)
    _check_names("tear", "horizon", tear.horizons, horizons)
    for throw in throws:
        for name in throw.horizons or horizons:
            if name in (tear.horizons or horizons):
                raise InputError(
                    f"horizon {name!r} is torn twice: by tear, and by the throw of "
                    f"{throw.fault!r}. "
                    'Name the horizons of each, as in tear={"horizons": [...]} and '
                    'throws={"F1": {"throw": 60.0, "horizons": [...]}}.'
                )


def _check_names(what: str, kind: str, names: Iterable[str], known: Sequence[str]) -> None:
    for name in names:
        refusal = f"{what} names {name!r}, which is not a {kind} of the scene. The {kind}s are"
        check_name(name, known, refusal)
