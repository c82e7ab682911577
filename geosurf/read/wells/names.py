"""Usual names of the columns of well paths: lower case, letters and digits only."""

from __future__ import annotations

from geosurf.read.tops import USUAL as OF_TOPS

USUAL: dict[str, tuple[str, ...]] = {
    "well": (*OF_TOPS["well"], "wlbwellborename"),
    "x": OF_TOPS["x"],
    "y": OF_TOPS["y"],
    "z": (*OF_TOPS["z"], "tvdmsl"),
    "md": ("md", "mdepth", "mdrkb", "mdmsl", "measureddepth", "mdkb"),
    "inclination": ("inc", "incl", "inclination", "deviation", "devi", "dev", "incdeg", "incldeg"),
    "azimuth": (
        "azi", "azim", "azimuth", "azimgn", "azigrid", "azimuthgn", "azimuthgrid", "gridazimuth",
        "azideg",
    ),
}  # fmt: skip
HORIZON = OF_TOPS["horizon"]


__all__ = ["HORIZON", "USUAL"]
