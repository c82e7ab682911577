"""The keys of ``[wells]``."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.declare import key
from geosurf.scenario.fault_keys import length_unit_key, positive_key


@values.check('a list of files such as ["W1.dev", "W2.dev"], relative to the scenario')
def listed_files(at: values.KeyPath, value: Any) -> tuple[Path, ...] | None:
    """Files, each once."""
    if not isinstance(value, list) or not value or any(value.count(one) > 1 for one in value):
        return None
    return tuple(values.file(at.inside(str(k + 1)), one) for k, one in enumerate(value))


@dataclass(frozen=True, kw_only=True)
class WellsInput:
    """``[wells]``: paths of wells. They are drawn on all pictures, and `wells.csv` has the units
    that each goes through. See [file formats](formats.md#paths-of-wells).
    """

    files: tuple[Path, ...] = key(
        "Well traces of Petrel, wells of RMS or ResInsight, LAS, or tables; each may have several "
        "wells.",
        listed_files,
    )
    heads: Path | None = key(
        "A table with `Well`, `X`, `Y` and `KB` (elevation of the drill floor), for wells that "
        "have measured depths and directions only.",
        values.file,
        default=None,
    )
    positive: str | None = positive_key()
    length_unit: str | None = length_unit_key()


__all__ = ["WellsInput"]
