"""The result of one realisation, and the bytes that it is stored as until its region is full."""

from __future__ import annotations

import io
import json
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from geosurf.errors import InputError


class UnitKey(NamedTuple):
    """The name of a unit, and what it is a part of."""

    name: str
    zone: str
    block: str
    contact: str


class PairKey(NamedTuple):
    """A fault and the zones on both of its sides."""

    fault: str
    hanging_zone: str
    foot_zone: str


@dataclass(frozen=True, eq=False)
class Record:
    """
    Volumes, drawn numbers and maps of one realisation.

    Attributes
    ----------
    volumes : dict of UnitKey to float
        [m3]; empty if the realisation failed.
    numbers : dict of str to float
        Drawn value of each parameter.
    maps : ndarray of float32, shape (n_layer, n_row, n_col), or None
        Thickness of each layer [m], 0 where it is absent.
    reason : str
        Why it failed; empty if it did not.
    realization : int
    juxtaposed : dict of PairKey to float
        Area of contact of zones across faults [m2]; with maps only.
    n_torn, n_searched : int
        Horizons that were torn as picked, and how many of them the plan of the base case did not
        close.
    n_warning : int
        How many different warnings there were.

    Examples
    --------
    >>> record = Record({UnitKey("above Top", "above Top", "whole", ""): 5.0}, {"throw F1": 31.5})
    >>> twin = Record.from_bytes(record.to_bytes())
    >>> twin.volumes == record.volumes, twin.numbers
    (True, {'throw F1': 31.5})
    """

    volumes: dict[UnitKey, float]
    numbers: dict[str, float] = field(default_factory=dict)
    maps: np.ndarray | None = None
    reason: str = ""
    realization: int = -1
    n_warning: int = 0
    juxtaposed: dict[PairKey, float] = field(default_factory=dict)
    n_torn: int = 0
    n_searched: int = 0

    @classmethod
    def failed(cls, numbers: dict[str, float], reason: str) -> Record:
        """Return the record of a realisation that could not be built."""
        # Reasons are shown in tables: one line.
        return cls({}, numbers, None, " ".join(reason.split()) or "no reason is given")

    def numbered(self, realization: int, n_warning: int) -> Record:
        """Return the same with its number and warnings."""
        return replace(self, realization=realization, n_warning=n_warning)

    def to_bytes(self) -> bytes:
        """Return the record as the content of a file."""
        # Names and texts as JSON, numbers as arrays.
        head = {
            "units": [list(key) for key in self.volumes],
            "parameters": list(self.numbers),
            "reason": self.reason,
            "realization": self.realization,
            "n_warning": self.n_warning,
            "pairs": list(map(list, self.juxtaposed)),
            "torn": [self.n_torn, self.n_searched],
        }
        arrays: dict[str, Any] = {
            "head": np.frombuffer(json.dumps(head).encode(), dtype=np.uint8),
            "volumes": np.array([*self.volumes.values()], dtype=np.float64),
            "numbers": np.array([*self.numbers.values()], dtype=np.float64),
            "areas": np.array([*self.juxtaposed.values()], dtype=np.float64),
        }
        if self.maps is not None:
            arrays["maps"] = self.maps
        file = io.BytesIO()
        # Without pickles: reading a record runs no code.
        np.savez(file, allow_pickle=False, **arrays)
        return file.getvalue()

    @classmethod
    def from_bytes(cls, data: bytes) -> Record:
        """Return the record that a file holds."""
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            head = json.loads(arrays["head"].tobytes())
            keys = [UnitKey(*key) for key in head["units"]]
            pairs = [PairKey(*key) for key in head["pairs"]]
            return cls(
                dict(zip(keys, arrays["volumes"].tolist(), strict=True)),
                dict(zip(head["parameters"], arrays["numbers"].tolist(), strict=True)),
                arrays.get("maps", None),
                head["reason"], head["realization"], head["n_warning"],
                dict(zip(pairs, arrays["areas"].tolist(), strict=True)), *head["torn"],
            )  # fmt: skip


def expect_ensemble(result: Any, who: str) -> None:
    """Refuse what is not the result of an ensemble."""
    if not {"volume", "status", "drawn"} <= set(getattr(result, "data_vars", ())):
        raise InputError(
            f"{who} takes the results of an ensemble, not {type(result).__name__}. Pass what "
            "run_ensemble or open_ensemble returns."
        )
