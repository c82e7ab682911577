"""Draw on a map where virtual walls meet the horizon: dashed, in the colours of their faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, real_numbers
from geosurf.errors import InputError
from geosurf.model.compartments import fault_of
from geosurf.render import furniture, palette
from geosurf.render.layers import Entry

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes

Lines = Mapping[str, Sequence[np.ndarray]]
HOW = "give lines of shape (n, 2) or (n, 3) [m] by name of the wall"


def draw_virtual_walls(
    sheet: furniture.Sheet, axes: Axes, virtual: Lines, faults: Sequence[str]
) -> list[Entry]:
    """Draw virtual walls on the map; return the entry of the legend.

    Parameters
    ----------
    sheet : furniture.Sheet
    axes : Axes
        Of the map.
    virtual : mapping of str to sequence of ndarray of float64, each (n, 3)
        Lines of each virtual wall on the horizon [m].
    faults : sequence of str
        Names of all faults, for their colours.
    """
    virtual = check_lines(virtual)
    width = 1.8 * sheet.layout.unit * 72.0 / furniture.DPI
    shown = []
    for name, lines in virtual.items():
        fault = fault_of(name)
        colour = palette.fault(faults.index(fault)) if fault in faults else palette.INK
        for line in lines:
            # a white line below: dashes are seen on all colours of the elevation
            x, y = line[:, :2].T
            axes.plot(x, y, color=palette.PAPER, linewidth=1.8 * width, zorder=2.4)
            axes.plot(x, y, color=colour, linewidth=width, dashes=(4.0, 1.6), zorder=2.5)
        if len(lines):
            shown.append(fault)
    if not shown:
        return []
    words = counted(len(shown), "virtual wall")
    return [Entry(words.capitalize(), palette.INK, "of " + ", ".join(shown), "dashes")]


def check_lines(virtual: Any) -> Lines:
    """Return lines by name of the wall, or raise an InputError."""
    if not isinstance(virtual, Mapping):
        raise InputError(f"virtual_walls is {virtual!r}; {HOW}.")
    found: dict[str, list[np.ndarray]] = {}
    for name, lines in virtual.items():
        try:
            found[str(name)] = [real_numbers(line) for line in lines]
        except (TypeError, ValueError) as error:
            raise InputError(f"virtual_walls of {name!r} are not lines; {HOW}.") from error
        for line in found[str(name)]:
            if line.ndim != 2 or line.shape[1] not in (2, 3) or not np.isfinite(line).all():
                raise InputError(f"virtual_walls of {name!r} are not lines; {HOW}.")
    return found


__all__ = ["draw_virtual_walls"]
