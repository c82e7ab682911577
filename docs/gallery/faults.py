"""Three faults as picked, extended and truncated, and the blocks that they divide."""

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import geosurf as gs


def fault(easting, northing, elevation):
    """Nodes of a fault over (down_dip, along_strike) [m]."""
    names, dims = ("easting", "northing", "elevation"), ("down_dip", "along_strike")
    nodes = np.broadcast_arrays(easting, northing, elevation)
    found = xr.Dataset(
        {name: (dims, part, {"units": "m"}) for name, part in zip(names, nodes, strict=True)}
    )
    found["elevation"].attrs["positive"] = "up"
    return found


box = (0, 3000, 0, 3000, -1600, -600)
z = np.linspace(-800, -1450, 12)[:, None]
down = -800 - z
s, t = np.linspace(300, 2700, 25), np.linspace(1300, 1700, 5)
picked = {
    "F1": fault(800 + 0.8 * down + 0.0008 * down**2, s, z),  # listric
    "F2": fault(2100 - 0.9 * down[:6], s, z[:6]),  # antithetic
    "F3": fault(np.linspace(1250, 1600, 8), 1500 + 0.4 * down[:5], z[:5]),
}
given = gs.Scene({}, picked, box)
sealed = given.replace(
    extend=True,
    truncations={
        "F2": ("F1", "hanging wall", True),
        "F3": (("F1", "hanging wall", True), ("F2", "hanging wall", True)),
    },
)

with TemporaryDirectory() as folder:
    size = (800, 520)
    files = [
        given.plot.view(path=f"{folder}/given.png", size=size, clip=False),
        sealed.plot.view(path=f"{folder}/sealed.png", size=size),
        sealed.plot.view(path=f"{folder}/blocks.png", show=["units"], exploded=0.2, size=size),
    ]
    figure, axes = plt.subplots(1, 3, figsize=(14, 3.2), layout="constrained")
    titles = ("as picked", "extended and truncated", "the blocks")
    for ax, file, title in zip(axes, files, titles, strict=True):
        ax.imshow(plt.imread(file)[40:-20, :590])  # without its legend
        ax.set_title(title)
        ax.axis("off")
    figure.savefig(Path("docs/pictures/faults.png"), dpi=90)
