"""Pieces of a cut grid: runs of triangles, and half-edges around an edge of a curve."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

n = 7
COLOURS = plt.get_cmap("tab20").colors


def corners_of(place, row):
    """Corners of a triangle of a strip: two places for each cell, diagonals rising."""
    j = place // 2
    square = np.array([[j, row], [j + 1, row], [j + 1, row + 1], [j, row + 1]], dtype=float)
    return square[[0, 2, 3]] if place % 2 == 0 else square[[0, 1, 2]]


def is_cut(corners):
    """Whether the curve of the picture passes through a triangle."""
    side = corners[:, 0] - (2.6 + 0.45 * corners[:, 1])
    return side.min() < 0 < side.max()


figure = plt.figure(figsize=(11, 4.4), layout="constrained")
ax = figure.add_subplot(1, 2, 1)
run = 0
for row in range(n - 1):
    open_run = False
    for place in range(2 * (n - 1)):
        corners = corners_of(place, row)
        if is_cut(corners):
            ax.fill(*corners.T, facecolor="none", edgecolor="tab:red", lw=1.3, zorder=3)
            open_run = False
            continue
        if not open_run:
            run, open_run = run + 1, True
        middle = corners.mean(axis=0)
        ax.fill(*corners.T, facecolor=COLOURS[run % 20], edgecolor="white", lw=0.6, alpha=0.55)
        ax.text(*middle, str(place), ha="center", va="center", fontsize=6, color="0.35")
line = np.array([0.0, n - 1.0])
ax.plot(2.6 + 0.45 * line, line, color="black", lw=2, zorder=4)
ax.text(2.6 + 0.45 * line[1], line[1] + 0.12, "curve", ha="center")
ax.set_title("runs (one colour each), places in them, and cut triangles (red)")
ax.set_aspect("equal")
ax.set_axis_off()

ax = figure.add_subplot(1, 2, 2, projection="3d", computed_zorder=False)
edge = np.array([[0, 0, 0], [0, 2, 0]], dtype=float)
angles = np.radians([8, 75, 172, 262])
names = ("Top", "F1", "Top", "F1")
for k, (angle, name) in enumerate(zip(angles, names, strict=True)):
    tip = np.array([1.6 * np.cos(angle), 1.0, 1.6 * np.sin(angle)])
    colour = "tab:olive" if name == "Top" else "tab:blue"
    face = Poly3DCollection([[*edge, tip]], facecolor=colour, edgecolor="black", alpha=0.45)
    ax.add_collection3d(face)
    start, end = (0.12 * tip + 0.88 * edge[i] for i in (0, 1))
    start, end = (start, end) if k % 2 else (end, start)
    ax.quiver(*start, *(0.86 * (end - start)), color="tab:red", arrow_length_ratio=0.16, lw=2)
    ax.text(*(1.12 * tip), f"{name}, half-edge {k}", ha="center", fontsize=8)
    nearer = 0.5 * (angle + angles[(k + 1) % 4] + (2 * np.pi if k == 3 else 0))
    ax.text(0.75 * np.cos(nearer), 1.0, 0.75 * np.sin(nearer), f"cell {k + 1}", ha="center")
ax.plot(*edge.T, color="black", lw=3, zorder=8)
ax.set(xlim=(-1.6, 1.6), ylim=(-0.2, 2.2), zlim=(-1.6, 1.6))
ax.view_init(elev=18, azim=-62)
ax.set_box_aspect((3.2, 2.4, 3.2), zoom=1.25)
ax.set_axis_off()
ax.set_title("a ring: the half-edges around an edge of a curve, by angle")
figure.savefig("docs/pictures/pieces.png", dpi=80)
