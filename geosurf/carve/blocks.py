"""Units of one zone -> blocks, named by the faults that separate them.

A fault separates two units of a zone if one of them touches only its front (``+``, the side
its normal points into: the hanging wall of a dipping fault) and the other only its back
(``-``). Whether they face each other does not matter: throw may bring other zones between.
"""

from __future__ import annotations

import numpy as np

from geosurf.carve.cells import Cells
from geosurf.carve.zones import owned_by
from geosurf.model import Patches

WHOLE = "whole"


def _touched(cells: Cells, sides: np.ndarray, fault: int, n_unit: int) -> np.ndarray:
    """Whether each unit touches front and back of a fault, bool (n_unit, 2); slits apart."""
    rows = owned_by(cells, fault)
    rows = rows[sides[rows, 0] != sides[rows, 1]]
    touched = np.zeros((n_unit, 2), dtype=bool)
    for side in range(2):
        units = sides[rows, side]
        touched[units[units >= 0], side] = True
    return touched


def name_blocks(
    patches: Patches,
    cells: Cells,
    sides: np.ndarray,
    zone: np.ndarray,
    volume: np.ndarray,
    faults: list[int],
) -> list[str]:
    """Block name of each unit; the same in every zone for the same sides of faults.

    Units that no fault tells apart are numbered by falling volume: ``F1+ #2``.
    """
    words: list[list[str]] = [[] for _ in zone]
    for fault in faults:
        touched = _touched(cells, sides, fault, len(zone))
        front = touched[:, 0] & ~touched[:, 1]
        back = touched[:, 1] & ~touched[:, 0]
        for k in np.unique(zone):
            mine = zone == k
            if (front & mine).any() and (back & mine).any():
                for u in np.flatnonzero(mine & (front | back)):
                    words[u].append(patches.names[fault] + ("+" if front[u] else "-"))
    names = [" ".join(word) if word else WHOLE for word in words]
    groups: dict[tuple[int, str], list[int]] = {}
    for u, name in enumerate(names):
        groups.setdefault((int(zone[u]), name), []).append(u)
    for (_, name), units in groups.items():
        for rank, u in enumerate(sorted(units, key=lambda u: -volume[u])[1:], start=2):
            names[u] = f"{name} #{rank}"
    return names


def block_order(name: str) -> tuple[str, int]:
    """Key that sorts block names: ``F1+``, ``F1+ #2``, ... ``F1+ #10``."""
    base, _, rank = name.partition(" #")
    return base, int(rank or 1)
