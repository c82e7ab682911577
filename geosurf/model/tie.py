"""How horizons are tied to well tops: range and tolerance, and what a tie did."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from geosurf.conventions import did_you_mean, is_number, length_text
from geosurf.errors import InputError
from geosurf.model.base import Noun

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
        if key not in ("range", "tolerance"):
            guess = did_you_mean(key, ("range", "tolerance"))
            raise InputError(f"tie has no option {key!r}.{guess} {HOW}.")
        if not (is_number(value) and value > 0):
            raise InputError(f"tie: {key} is {value!r}, expected metres above 0. {HOW}.")

    # what was left out takes its default; `assumed` says that the range was nobody's choice
    values = {key: float(value) for key, value in tie.items()}
    return TieSettings(**values, assumed="range" not in values)
