"""An unconformity: it erodes a fold below, and younger layers lap onto it."""

import numpy as np
import xarray as xr

import geosurf as gs

east = np.linspace(0, 4000, 81)
x, y = np.meshgrid(east, east)
fold = 180 * np.sin(2 * np.pi * (x + 0.4 * y) / 5200)


def horizon(elevation):
    """Elevations over northing and easting, as geosurf expects them."""
    coords = {"northing": east, "easting": east}
    return xr.DataArray(
        elevation, coords, ("northing", "easting"), attrs={"units": "m", "positive": "up"}
    )


horizons = {  # youngest first
    "Top": horizon(-1340 - 0.01 * x),
    "Marker": horizon(-1460 - 0.01 * x),
    "Unconformity": horizon(-1800 + 0.09 * (x - 2000)),
    "Sand": horizon(-1760 + fold),
    "Base": horizon(-1900 + fold),
}
scene = gs.Scene(
    horizons, box=(0, 4000, 0, 4000, -2200, -1200), column={"Unconformity": "discontinuous"}
)
scene.plot.view(path="docs/pictures/column.png", show=["units"], include="all", size=(960, 600))
