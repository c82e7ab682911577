"""Keys of a scenario about zones: ``[zones]``, from thickness, and ``[seal]``, by their shale."""

# ruff: noqa: RUF009 - `key` makes a dataclasses.field

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from geosurf.scenario import values
from geosurf.scenario.values import key

# ---- zone keys ----------------------------------------
# Zones from thickness: ``[zones]``.


OF_ZONES = (
    "Zones from thickness, see [zones from thickness](guides/zones.md): each makes a horizon, "
    "`base Upper` unless `base` or `top` names it."
)


@values.check(
    "tables by zone, such as `[zones.Upper]` with below or above, thickness, and base, top or kind"
)
def zones_by_name(at: values.KeyPath, value: Any) -> Any:
    """Zones by name; a text is the file of a thickness map."""
    if not isinstance(value, dict) or not all(isinstance(one, dict) for one in value.values()):
        return None
    found = {name: dict(one) for name, one in value.items()}
    for name, one in found.items():
        if isinstance(one.get("thickness"), str):
            place = at.inside(name).inside("thickness")
            one["thickness"] = values.file(place, one["thickness"])
    return found


# ---- seal keys ----------------------------------------
# The keys of ``[seal]``.


@values.check(
    'a number, or a table of these by zone, such as `{"Top/Base" = 0.2, elsewhere = 0.7}`'
)
def by_zone(at: values.KeyPath, value: Any) -> Any:
    """A number, or numbers by zone, whose names are checked when all zones are known."""
    if not isinstance(value, dict):
        return values.not_negative(at, value)
    return {zone: values.not_negative(at.inside(zone), one) for zone, one in value.items()} or None


@dataclass(frozen=True, kw_only=True)
class SealInput:
    """``[seal]``: what faults hold, as `seal.csv`: a row for each pair of units across a fault.
    See [fault seal](guides/fault_seal.md).
    """

    vshale: Any = key("Shale of the zones, fractions.", by_zone)
    shale: float = key("From which Vshale a zone is shale.", values.share, default=0.4)
    density_contrast_kg_m3: float | None = key(
        "Density of water less that of hydrocarbon, for column heights.",
        values.above_zero,
        unit="kg/m³",
        default=None,
    )
    seabed_m: float = key(
        "Elevation from which burial depth counts.", values.number, unit="m", default=0.0
    )
    closures_sgr: float | None = key(
        "Least shale gouge ratio with which faults hold in `closures.csv`, where reservoir faces "
        "reservoir. Left out: as `output.closures` says.",
        values.share,
        default=None,
    )
    permeability_md: Any = key(
        "Of the cells of `[grid]`: `grid_multipliers.inc` then has MULTX, MULTY and MULTZ.",
        by_zone,
        unit="mD",
        default=None,
    )
