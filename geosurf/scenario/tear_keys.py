"""Of all keys: ``[tear]`` and ``[[throws]]``, which tear horizons at their faults."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.declare import key
from geosurf.sheets.faults import DIRECTIONS


@dataclass(frozen=True, kw_only=True)
class TearSettings:
    """``[tear]``: horizons that were picked or gridded across their faults are torn there. The
    report has the details. Leave the table out for horizons as they are. See
    [tearing](guides/tearing.md).
    """

    horizons: tuple[str, ...] = key("Horizons to tear. Left empty: all.", values.names, default=())
    trim_cells: str | float | dict[str, Any] = key(
        "Ignore data closer to a fault than this: at least one and a half times the half width of "
        "the smear. By default it is estimated for each fault from data that are held out.",
        values.trim,
        unit="cells of the grid",
        default="auto",
    )
    noise_m: float | None = key(
        "Standard deviation of the noise; 0 to meet all other data. Left out: estimated.",
        values.not_negative,
        unit="m",
        default=None,
    )
    fill_empty_blocks: bool | str | dict[str, Any] = key(
        "What becomes of horizons in blocks without data: `false` refuses, `true` continues them "
        'from the neighbouring block, `"lower"` and `"upper"` pinch them out onto the horizon '
        "below or above.",
        values.filling,
        default=False,
    )


@dataclass(frozen=True, kw_only=True)
class ThrowInput:
    """One ``[[throws]]``: throw of a fault, for horizons that are still continuous. The youngest
    fault comes first. Give one of `throw_m`, `profile_m`, `elliptic_m`; see
    [tearing](guides/tearing.md).
    """

    fault: str = key("The fault, as it is after extension and truncation.", values.text)
    horizons: tuple[str, ...] = key(
        "Horizons that it moves. Left empty: all.", values.names, default=()
    )

    # exactly one of these three
    throw_m: float | None = key(
        "The same throw everywhere; below 0 for a reverse fault.",
        values.number,
        unit="m",
        default=None,
    )
    profile_m: tuple[tuple[float, float], ...] | None = key(
        "Distance along the mean strike, from the fault's first end by the right-hand rule, and "
        "throw.",
        values.profile,
        unit="m",
        default=None,
    )
    elliptic_m: float | None = key(
        "Largest throw of a fault that dies at its tips.", values.number, unit="m", default=None
    )

    # the ellipse; what is left out follows from the fault
    half_length_m: float | None = key(
        "With `elliptic_m`: from the middle to the tips along strike. Left out: as the fault is.",
        values.above_zero,
        unit="m",
        default=None,
    )
    half_height_m: float | None = key(
        "With `elliptic_m`: from the middle to the upper and lower tip. Left out: throw does not "
        "change with elevation.",
        values.above_zero,
        unit="m",
        default=None,
    )
    centre_along_m: float | None = key(
        "With `elliptic_m`: distance along the mean strike at which throw is largest, from the "
        "fault's first end by the right-hand rule. Left out: the middle of the fault.",
        values.number,
        unit="m",
        default=None,
    )
    centre_elevation_m: float | None = key(
        "With `half_height_m`: elevation at which throw is largest. Left out: the middle of the "
        "fault.",
        values.number,
        unit="m",
        default=None,
    )

    # how the throw is shared between the walls, and where it ends
    hanging_wall: float = key(
        "Share of the throw by which the hanging wall moves down; the footwall moves up by the "
        "remainder.",
        values.share,
        default=1.0,
    )
    direction: str = key(
        "Whether walls move down the local dip of the fault, or everywhere across its mean strike.",
        values.one_of(*DIRECTIONS),
        default="local",
    )
    reach_m: float | None = key(
        "Distance across strike over which the movement dies away. Left out: never.",
        values.above_zero,
        unit="m",
        default=None,
    )
