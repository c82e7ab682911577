"""Layers of a zone: proportional, or of one thickness, parallel to its top or base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import is_number, known_names
from geosurf.errors import InputError

MOST_LAYERS = 10_000
PARALLEL = ("top", "base")
_EXAMPLE = (
    'Give a number of layers, layers={"Top/Base": 10}, or a thickness, '
    'layers={"Top/Base": {"thickness": 5, "parallel": "top"}}.'
)


@dataclass(frozen=True)
class Layers:
    """How a zone is divided.

    Attributes
    ----------
    count : int or None
        Proportional layers; None for layers of one thickness.
    thickness : float
        [m]
    parallel : {"", "top", "base"}
    """

    count: int | None
    thickness: float = 0.0
    parallel: str = ""

    def boundaries(self, thickness: np.ndarray) -> np.ndarray:
        """Depth of the boundaries below the top of the zone [m], (n_layer + 1, ...)."""
        if self.count is not None:
            share = np.linspace(0.0, 1.0, self.count + 1)
            return share.reshape(-1, *[1] * thickness.ndim) * thickness

        # as many layers as the thickest place needs; they pinch out elsewhere
        largest = float(thickness.max(initial=0.0))
        n = max(1, int(np.ceil(largest / self.thickness - 1e-9)))
        if n > MOST_LAYERS:
            raise InputError(
                f"layers of {self.thickness:g} m in a zone of up to {largest:.1f} m are {n} "
                f"layers; the limit is {MOST_LAYERS}. Choose a larger thickness."
            )
        depth = self.thickness * np.arange(n + 1.0).reshape(-1, *[1] * thickness.ndim)
        depth[-1] = np.inf
        from_top = np.minimum(depth, thickness)
        return from_top if self.parallel == "top" else thickness - from_top[::-1]


def layers_of(layers: Any, zones: Sequence[str], between: Sequence[str]) -> dict[str, Layers]:
    """
    Return the layers of each zone of a grid, from the top down.

    Parameters
    ----------
    layers : int or mapping
        As users give it; see `build_grid`.
    zones : sequence of str
        All zones of the model, from the top down.
    between : sequence of str
        Those between two horizons, to which one number for all refers.

    Returns
    -------
    dict of str to Layers

    Raises
    ------
    InputError
        For unknown zones, zones between which one is left out, or layers that are not understood.
    """
    if not isinstance(layers, Mapping):
        if not between:
            raise InputError(f"no zone lies between two horizons. {_EXAMPLE}")
        layers = dict.fromkeys(between, layers)
    for name in layers:
        if name not in zones:
            raise InputError(
                f"layers has no zone {name!r} to divide. Zones are {known_names(zones, name)}"
            )
    rows = sorted(zones.index(name) for name in layers)
    if not rows:
        raise InputError(f"layers is empty. {_EXAMPLE}")
    missing = [zones[k] for k in range(rows[0], rows[-1]) if k not in rows]
    if missing:
        raise InputError(
            f'layers leaves out {missing[0]!r}, between zones that it has. Add "{missing[0]}": 1.'
        )
    return {zones[k]: _one(zones[k], layers[zones[k]]) for k in rows}


def _one(zone: str, given: Any) -> Layers:
    """Layers of one zone."""
    if is_number(given) and float(given) == int(given) and 1 <= given <= MOST_LAYERS:
        return Layers(int(given))
    if isinstance(given, Mapping) and set(given) == {"thickness", "parallel"}:
        size, way = given["thickness"], given["parallel"]
        if is_number(size) and np.isfinite(size) and size > 0 and way in PARALLEL:
            return Layers(None, float(size), way)
    raise InputError(f"layers of zone {zone!r} are {given!r}. {_EXAMPLE}")
