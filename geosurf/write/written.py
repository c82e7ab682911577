"""What was written, and what the format could not hold."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

SMALLEST = 1e-6  # smaller differences than this [m] are not listed

# what a format may lose -> what it means
LOSSES = {
    "precision": "coordinates or values were rounded",
    "crs": "the coordinate reference system is not in the file",
    "direction": "the file does not state whether z is elevation or depth",
    "unit": "the file does not state the unit of z",
    "name": "names are not in the file, or not all of them",
    "undefined": "nodes without value are not in the file",
    "grid": "rows and columns of a grid are not in the file, or not as they were",
    "data": "numbers or words of vertices, lines or cells are not in the file",
    "topology": "which corners are the same vertex is not in the file",
    "other": "see the sentence",
}


@dataclass(frozen=True)
class Loss:
    """
    Something that a format could not hold.

    Attributes
    ----------
    what : str
        A key of `geosurf.write.written.LOSSES`: ``"precision"``, ``"crs"``, ``"direction"`` ...
    sentence : str
        What was lost, and what to do about it.
    metres : float or None
        Largest difference [m] of a coordinate or value, where rounding is the loss.
    """

    what: str
    sentence: str
    metres: float | None = None

    def __str__(self) -> str:
        return self.sentence


class Written(list[Path]):
    """Paths of the files written, and what the format could not hold.

    Attributes
    ----------
    lost : tuple of Loss
        One for each thing that the files do not hold, or that their reader needs to know.
    notes : tuple of str
        The sentences of the same.
    largest_difference : float
        Of coordinates and values [m]; 0 where all differences are below 1e-6 m.

    Examples
    --------
    >>> Written([Path("top.gri")], [Loss("precision", "Values were rounded by up to 0.1 m.", 0.1)])
    top.gri
      precision: Values were rounded by up to 0.1 m.
    """

    def __init__(self, paths: Iterable[Path], lost: Iterable[Loss | str] = ()) -> None:
        super().__init__(paths)
        self.lost = tuple(one if isinstance(one, Loss) else Loss("other", one) for one in lost)

    @property
    def notes(self) -> tuple[str, ...]:
        """One sentence for each loss."""
        return tuple(one.sentence for one in self.lost)

    @property
    def largest_difference(self) -> float:
        """Largest difference of coordinates and values [m]."""
        return max((one.metres for one in self.lost if one.metres is not None), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the same in words and numbers that JSON holds."""
        return {"files": [str(path) for path in self], "lost": [asdict(one) for one in self.lost]}

    def __repr__(self) -> str:
        more = f" and {len(self) - 1} more files" if len(self) > 2 else ""
        files = [str(self[0]) + more] if more else [str(path) for path in self]
        return "\n".join([*files, *(f"  {one.what}: {one.sentence}" for one in self.lost)])


def precision_lost(metres: float, what: str) -> list[Loss]:
    """Return a loss for a rounding, or nothing for one that nobody can measure.

    Examples
    --------
    >>> precision_lost(0.25, "Nodes were moved"), precision_lost(1e-9, "Nodes were moved")
    ([Loss(what='precision', sentence='Nodes were moved by up to 0.25 m.', metres=0.25)], [])
    """
    if not metres > SMALLEST:
        return []
    return [Loss("precision", f"{what} by up to {metres:.3g} m.", float(metres))]
