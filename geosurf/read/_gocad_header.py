"""The header of a GOCAD object: name, coordinate system, properties.

Keys know no case. The names of the axes give their order; AXIS_UNIT follows the same order. A
coordinate system called ``Default``, ``Unknown`` or ``... Local`` is ignored.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError, InputError
from geosurf.read._common import agreed_scale, agreed_sign, integer, is_number, number

DIRECTIONS = {"elevation": "up", "depth": "down"}
# what axes are called, lower case: x, y, z
AXES = (
    ("x", "e", "east", "easting"),
    ("y", "n", "north", "northing"),
    ("z", "elevation", "altitude", "height", "depth", "tvd", "tvdss"),
)
DEPTHS = ("depth", "tvd", "tvdss")
NO_SYSTEM = ("", "default", "local", "none", "unknown")  # last word of its name
COUNT_OF_AXES = 3


@dataclass
class Header:
    """The header of one object, as it is written before the vertices."""

    name: str | None = None
    positive: str | None = None
    axis_names: list[str] = field(default_factory=list)
    axis_units: list[str] = field(default_factory=list)
    system: dict[str, str] = field(default_factory=dict)
    inside: bool = False  # of the coordinate system
    properties: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    no_data: list[float] = field(default_factory=list)

    def take_brace_line(self, text: str) -> None:
        """Take the name from ``name: F1``, also from ``{NAME: "F1"}``."""
        key, colon, value = text.strip().strip("{}").partition(":")
        value = value.strip().strip('"').strip()
        if colon and key.strip().lower() == "name" and value:
            self.name = value

    def take_line(self, path: Path, i: int, words: list[str]) -> None:
        """Read one line that is not a vertex or triangle; most have no effect here."""
        key, rest = words[0].upper(), words[1:]

        # NAME means the system's inside its block, and the object's elsewhere
        if key.startswith("GOCAD_") and key.endswith("COORDINATE_SYSTEM"):
            self.inside = True
        elif key.startswith("END_") and key.endswith("COORDINATE_SYSTEM"):
            self.inside = False
        elif self.inside and key in ("NAME", "PROJECTION", "DATUM"):
            self.system[key] = " ".join(" ".join(rest).split())
        elif key == "ZPOSITIVE":
            self.positive = _direction(path, i, rest)
        elif key in ("AXIS_NAME", "AXIS_UNIT"):
            if len(rest) != COUNT_OF_AXES:
                raise FormatError(
                    f"{path}, line {i}: {key} has {len(rest)} words, expected 3 (x, y, z). "
                    "Correct that line."
                )
            setattr(self, key.lower() + "s", [word.strip() for word in rest])
        elif key == "PROPERTIES":
            self.properties = [word.strip() for word in rest]
        elif key == "ESIZES":
            self.sizes = [integer(word, path, i, "size of a property") for word in rest]
        elif key == "NO_DATA_VALUES":
            self.no_data = [
                number(word, path, i, "no-data value") if is_number(word) else np.nan
                for word in rest
            ]

    def property_sizes(self, path: Path, line: int) -> list[int]:
        """Values per property; 1 each unless ESIZES differs."""
        sizes = self.sizes or [1] * len(self.properties)
        if len(sizes) != len(self.properties) or min(sizes, default=1) < 1:
            raise FormatError(
                f"{path}: the surface that begins on line {line} has {len(self.properties)} "
                f"PROPERTIES but ESIZES {sizes}; each property needs one positive size. "
                "Correct the header."
            )
        return sizes

    def order(self, what: str) -> list[int]:
        """Column of x, of y and of z among the three of a vertex."""
        names = [word.lower() for word in self.axis_names]
        known = [next((k for k in range(3) if name in AXES[k]), None) for name in names]
        # Each axis is named once: columns may come in any order.
        if sorted(k for k in known if k is not None) == [0, 1, 2]:
            return [known.index(k) for k in range(COUNT_OF_AXES)]

        # some axes known, others not: in their usual order they may stay, otherwise it is a guess
        if any(k not in (None, at) for at, k in enumerate(known)):
            raise FormatError(
                f"{what}: AXIS_NAME is {self.axis_names}, so the order of x, y and z is "
                'unclear. Write AXIS_NAME "X" "Y" "Z", in the order of the columns.'
            )
        return [0, 1, 2]

    def to_metres(
        self, points: np.ndarray, positive: str | None, length_unit: str | None, what: str
    ) -> np.ndarray:
        """Points (n, 3) in the order x, y, z: metres, elevation up."""
        order = self.order(what)

        # an axis called depth, without a word on its direction, could be meant either way
        deep = self.axis_names[order[2]].lower() in DEPTHS if self.axis_names else False
        if self.positive is None and positive is None and deep:
            raise InputError(
                f"{what}: the third axis is called {self.axis_names[order[2]]!r}, and "
                "ZPOSITIVE is missing. Pass positive='down' for depths or positive='up' for "
                "elevations."
            )
        direction = positive if positive is not None or self.positive is not None else "up"
        sign = agreed_sign(self.positive, direction, what)
        # Units in the order x, y, z; the argument of the caller counts for z alone.
        stated = [self.axis_units[k] for k in order] if self.axis_units else [None] * 3
        requested = (None, None, length_unit)  # a caller's word is that of elevations
        pairs = zip(stated, requested, strict=True)
        scale = np.array([agreed_scale(*pair, "m", what) for pair in pairs])
        world: np.ndarray = points[:, order] * scale * [1.0, 1.0, sign]
        return world

    @property
    def crs(self) -> str | None:
        """The coordinate reference system: its name, else its datum and projection."""
        name, projection, datum = (
            _named(self.system.get(key, "")) for key in ("NAME", "PROJECTION", "DATUM")
        )
        return name or " / ".join(word for word in (datum, projection) if word) or None


def _named(text: str) -> str:
    """Return the name of a system, or nothing where it names none."""
    # "GOCAD Local" and the like name no system
    last = (text.split() or [""])[-1].lower()
    return "" if last in NO_SYSTEM else text


def _direction(path: Path, i: int, rest: list[str]) -> str:
    direction = DIRECTIONS.get(rest[0].lower()) if rest else None
    if direction is None:
        raise FormatError(
            f"{path}, line {i}: ZPOSITIVE is {' '.join(rest)!r}, expected Elevation or Depth. "
            "Correct that line."
        )
    return direction
