"""The textbook's steps for two triangles, and the four cases of how they meet."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import geosurf as gs

P = np.array([[0, 0, 0], [24, 0, 0], [0, 24, 0]], dtype=float)
Q = np.array([[6, 8, -9], [22, 4, 9], [-2, 4, 9]], dtype=float)
COLOURS = {"P": "tab:olive", "Q": "tab:blue"}


def draw(ax, p, q, points, zoom=1.6):
    """Both triangles, and in red what they have in common."""
    for corners, colour in ((p, COLOURS["P"]), (q, COLOURS["Q"])):
        ax.add_collection3d(
            Poly3DCollection([corners], facecolor=colour, edgecolor="black", alpha=0.35)
        )
    if len(points) > 2:
        ax.add_collection3d(Poly3DCollection([points], facecolor="tab:red", alpha=0.8, zorder=5))
    elif len(points):
        ax.plot(*points.T, "o-", color="tab:red", lw=3, ms=5, zorder=6)
    ax.set(xlim=(-6, 28), ylim=(-12, 26), zlim=(-10, 12))
    ax.view_init(elev=28, azim=-62)
    ax.set_box_aspect((34, 38, 22), zoom=zoom)
    ax.set_proj_type("ortho")
    ax.set_axis_off()


contact = gs.intersect_triangles(P, Q, steps=True)
steps = contact.steps
figure = plt.figure(figsize=(11, 4.2), layout="constrained")
ax = figure.add_subplot(1, 3, 1, projection="3d", computed_zorder=False)
draw(ax, P, Q, np.empty((0, 3)))
for name, corners, heights in (("p", P, steps.heights[0]), ("q", Q, steps.heights[1])):
    for number, (corner, height) in enumerate(zip(corners, heights, strict=True), start=1):
        out = corner + 0.12 * (corner - corners.mean(axis=0))
        ax.text(*out, f"{name}$_{number}$ {height:+.0f}", ha="center", va="center", zorder=9)
ax.set_title("1. heights over the other plane", fontsize=10)

ax = figure.add_subplot(1, 3, 2, projection="3d", computed_zorder=False)
draw(ax, P, Q, np.empty((0, 3)))
ends = steps.cut_points[0][0] + np.outer([-25, 30], steps.direction)
ax.plot(*ends.T, color="0.3", lw=1, zorder=4)
for points, name in zip(steps.cut_points, "PQ", strict=True):
    ax.plot(*points.T, "o", color=COLOURS[name], mec="black", ms=7, zorder=8)
ax.set_title("2. cut points on the common line", fontsize=10)

ax = figure.add_subplot(1, 3, 3)
for level, (name, (low, high)) in enumerate(zip("PQ", steps.intervals, strict=True)):
    ax.plot([low, high], [2 - level] * 2, "o-", color=COLOURS[name], mec="black", lw=5)
    ax.text(high + 1, 2 - level, f"$I_{name}$", va="center")
ax.plot(steps.overlap, [0, 0], "o-", color="tab:red", lw=5)
ax.text(steps.overlap[1] + 1, 0, "common", va="center")
ax.set(ylim=(-0.8, 2.8), yticks=[], xlabel="place along the line [m]")
ax.margins(x=0.2)
ax.spines[["left", "top", "right"]].set_visible(False)
ax.set_title("3. intervals on the common line", fontsize=10)
figure.savefig("docs/pictures/textbook.png", dpi=80)

CASES = {  # of Lo and Wang, in their order
    "1. a point inside,\non an edge of the other": ((6, 6, -6), (2, 4, 10), (22, 7, 10)),
    "2. both points\non edges of one": ((9, -9, -6), (9, 40, -6), (9, 12, 12)),
    "3. a point\non a corner": ((24, 0, 0), (26, 8, 9), (30, -4, 8)),
    "4. an overlap\nin one plane": ((6, 6, 0), (26, 10, 0), (8, -8, 0)),
}
figure = plt.figure(figsize=(11, 3.2), layout="constrained")
for number, (title, corners) in enumerate(CASES.items(), start=1):
    second = np.array(corners, dtype=float)
    ax = figure.add_subplot(1, 4, number, projection="3d", computed_zorder=False)
    draw(ax, P, second, np.asarray(gs.intersect_triangles(P, second).points))
    ax.set_title(title, fontsize=10)
figure.savefig("docs/pictures/four_cases.png", dpi=80)
