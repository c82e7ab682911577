"""How a key of a scenario is declared."""

from __future__ import annotations

from dataclasses import MISSING, field
from typing import Any

from geosurf.scenario import values


def key(meaning: str, check: values.Check, *, unit: str = "", default: Any = MISSING) -> Any:
    """Declare one key: what it means, how its value is checked, and its default."""
    # Read by the parser for checks and by `page` for the documentation.
    metadata = {"meaning": meaning, "check": check, "unit": unit}
    if default is MISSING:
        return field(metadata=metadata)
    return field(default=default, metadata=metadata)
