"""The voxel search after Lo and Wang, in a section: from the global box to the candidates."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Rectangle

rng = np.random.default_rng(4)
x = np.linspace(0, 100, 41)
horizon = np.column_stack([x, 30 + 4 * np.sin(x / 13) + rng.normal(0, 0.4, len(x))])
z = np.linspace(2, 62, 22)
fault = np.column_stack([42 + 0.35 * (z - 30) + 0.004 * (z - 30) ** 2, z])


def boxes(line):
    """Lower and upper corners of the boxes of all segments."""
    return np.minimum(line[:-1], line[1:]), np.maximum(line[:-1], line[1:])


low = np.maximum(horizon.min(0), fault.min(0))
high = np.minimum(horizon.max(0), fault.max(0))
size = 4.0
shape = np.ceil((high - low) / size).astype(int)


def voxels_of(line):
    """Voxels that the box of each segment meets: a set for each segment."""
    found = []
    for below, above in zip(*boxes(line), strict=True):
        if (above < low).any() or (below > high).any():
            found.append(set())
            continue
        first = np.clip((below - low) // size, 0, shape - 1).astype(int)
        last = np.clip((above - low) // size, 0, shape - 1).astype(int)
        found.append(
            {(i, j) for i in range(first[0], last[0] + 1) for j in range(first[1], last[1] + 1)}
        )
    return found


of_horizon, of_fault = voxels_of(horizon), voxels_of(fault)
shared = set().union(*of_horizon) & set().union(*of_fault)

figure, axes = plt.subplots(1, 3, figsize=(11, 4), layout="constrained", sharey=True)
titles = (
    "1. the box that both surfaces share",
    "2. voxels that hold triangles of both",
    "3. candidates and their contact",
)
for step, (ax, title) in enumerate(zip(axes, titles, strict=True)):
    for line, found, colour in ((horizon, of_horizon, "tab:olive"), (fault, of_fault, "tab:red")):
        for segment, voxels in enumerate(found):
            near = (voxels & shared) if step == 2 else voxels
            ends = line[segment : segment + 2].T
            ax.plot(
                *ends, "-o", ms=3, lw=2.2 if near else 1, color=colour, alpha=1 if near else 0.35
            )
    ax.add_patch(Rectangle(low, *(high - low), fill=False, lw=1.5))
    if step:
        for i, j in np.ndindex(*shape):
            both = (i, j) in shared
            corner = low + size * np.array([i, j])
            face = "tab:blue" if both else "none"
            ax.add_patch(
                Rectangle(corner, size, size, facecolor=face, edgecolor="0.7", lw=0.6, alpha=0.5)
            )
    ax.set_title(title)
    ax.set_aspect("equal")
    ax.set_axis_off()
    ax.set(xlim=(low[0] - 12, high[0] + 12), ylim=(low[1] - 9, high[1] + 9))
figure.savefig("docs/pictures/voxels.png", dpi=80)
