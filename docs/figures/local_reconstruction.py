"""What the cut of one triangle looks like: before, its curves, and the pieces that replace it."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import geosurf as gs

rng = np.random.default_rng(2)
n = 9
x, y = np.meshgrid(np.linspace(0, 8, n), np.linspace(0, 8, n))
nodes = np.column_stack([x.ravel(), y.ravel(), 0.5 * np.sin(x.ravel()) * np.cos(y.ravel())])
cells = [
    (j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i)
    for j in range(n - 1)
    for i in range(n - 1)
]
triangles = np.array([t for a, b, c, d in cells for t in ((a, b, c), (a, c, d))])
horizon = gs.TriSurface("Top", "horizon", nodes, triangles)
fault = gs.TriSurface(
    "F1", "fault",
    [[1.7, -1, -3], [6.3, 9, -3], [7.3, 9, 3], [2.7, -1, 3]], [[0, 1, 2], [0, 2, 3]],
)  # fmt: skip
curves = gs.intersect_surfaces([horizon, fault])
patches = gs.rebuild_surfaces([horizon, fault])
cut = patches.surface("Top")

figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained")
axes[0].triplot(*nodes[:, :2].T, triangles, color="0.4", lw=0.8)
axes[0].set_title(f"1. the horizon: {horizon.n_triangle} triangles")

axes[1].triplot(*nodes[:, :2].T, triangles, color="0.8", lw=0.8)
for line in curves.curves:
    axes[1].plot(*curves.points[line][:, :2].T, "o-", color="tab:red", ms=4)
axes[1].set_title("2. its curve with the fault")

old = {tuple(sorted(map(tuple, nodes[corners]))) for corners in triangles}
new = [
    corners
    for corners in cut.triangles
    if tuple(sorted(map(tuple, cut.vertices[corners]))) not in old
]
axes[2].triplot(*nodes[:, :2].T, triangles, color="0.85", lw=0.8)
axes[2].tripcolor(*cut.vertices[:, :2].T, np.array(new), np.ones(len(new)), cmap="Blues", vmax=3)
axes[2].triplot(*cut.vertices[:, :2].T, np.array(new), color="tab:blue", lw=1)
axes[2].set_title(f"3. {len(new)} new triangles along it")
for ax in axes:
    ax.set_aspect("equal")
    ax.set_axis_off()
figure.savefig("docs/pictures/local_reconstruction.png", dpi=80)
