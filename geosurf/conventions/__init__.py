"""Axes, signs, units and the local frame: rules that every module follows.

- Axes are right-handed; coordinates are metres; elevation is positive up. Readers convert depths.
- A gridded horizon is an `xarray.DataArray` with dims ``("northing", "easting")``: the first runs
  north and the second east, unless the grid is rotated.
- One diagonal splits all cells of a grid: see `rising_diagonal`.
- Geometry is computed in a local frame: world coordinates minus one origin. The origin is a
  multiple of 1024 m along each horizontal axis, so that the subtraction is exact.

================ ================================================================
``axes``         dimensions of grids, sign of elevation, length units, the diagonal rule
``crs``          coordinate reference systems: read, compare, name
``checks``       checks of what users pass in: words, numbers, objects of other packages
``text``         counts, places, lengths, areas and volumes in messages
``running``      what is running, on one line, where somebody watches
``card``         what notebooks show of an object: a title and a table
``machine``      memory that is free; packages that not every installation has
``palette``      colours of units, horizons and faults; of pictures
================ ================================================================
"""

from geosurf.conventions.axes import (
    FAULT_DIMS,
    HORIZON_DIMS,
    METRES_PER_UNIT,
    elevation_sign,
    metres_of,
    metres_per_unit,
    rising_diagonal,
)
from geosurf.conventions.checks import (
    CONVERSION_ERRORS,
    FRAME_STEP,
    checked_points,
    first_given,
    frame_origin,
    is_number,
    is_whole,
    is_word,
    real_numbers,
    shift_is_exact,
)
from geosurf.conventions.text import (
    area_text,
    area_texts,
    check_name,
    check_word,
    counted,
    did_you_mean,
    grouped,
    known_names,
    length_text,
    number_text,
    place,
    shared_name,
    toml_key,
    volume_text,
)

# Stages write `from geosurf.conventions import ...`, so that files of this room may change.
__all__ = [
    "CONVERSION_ERRORS",
    "FAULT_DIMS",
    "FRAME_STEP",
    "HORIZON_DIMS",
    "METRES_PER_UNIT",
    "area_text",
    "area_texts",
    "check_name",
    "check_word",
    "checked_points",
    "counted",
    "did_you_mean",
    "elevation_sign",
    "first_given",
    "frame_origin",
    "grouped",
    "is_number",
    "is_whole",
    "is_word",
    "known_names",
    "length_text",
    "metres_of",
    "metres_per_unit",
    "number_text",
    "place",
    "real_numbers",
    "rising_diagonal",
    "shared_name",
    "shift_is_exact",
    "toml_key",
    "volume_text",
]
