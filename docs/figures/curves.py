"""From contacts to curves: points on faces, the polyline, and curves of more than one loop."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import geosurf as gs


def sheet(name, role, x, y, z):
    """A surface of triangles over rows and columns of places."""
    n_row, n_col = z.shape
    node = np.arange(n_row * n_col).reshape(n_row, n_col)
    a, b, c, d = (node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1])
    triangles = np.concatenate(
        [np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)]
    )
    places = np.stack(np.broadcast_arrays(x, y, z), axis=-1).reshape(-1, 3)
    return gs.TriSurface(name, role, places, triangles)


axis = np.linspace(0, 100, 13)
x, y = np.meshgrid(axis, axis)
top = sheet("Top", "horizon", x, y, 6 * np.sin(x / 22) + 4 * np.cos(y / 17))
down = np.linspace(-30, 30, 7)
along, depth = np.meshgrid(axis, down)
fault = sheet("F1", "fault", 48 + 0.4 * depth + 6 * np.sin(along / 25), along, depth)
curves = gs.intersect_surfaces([top, fault])
cut = gs.rebuild_surfaces([top, fault]).surface("Top")
(line,) = curves.between("Top", "F1")

figure, axes = plt.subplots(1, 3, figsize=(11, 3.9), layout="constrained", sharey=True)
for step, (ax, title) in enumerate(
    zip(
        axes,
        ("1. points recorded on faces", "2. the polyline", "3. local reconstruction"),
        strict=True,
    )
):
    old = top if step < 2 else cut
    ax.triplot(*old.vertices[:, :2].T, old.triangles, color="0.75", lw=0.7)
    if step == 2:
        kept = {str(np.sort(corners, axis=0)) for corners in top.vertices[top.triangles]}
        every = old.vertices[old.triangles]
        new = old.triangles[[str(np.sort(corners, axis=0)) not in kept for corners in every]]
        ax.triplot(*old.vertices[:, :2].T, new, color="tab:blue", lw=0.9)
    ax.plot(*line[:, :2].T, "-" if step == 1 else "o", color="tab:red", ms=3.5, lw=2)
    if step == 2:
        ax.plot(*line[:, :2].T, "-", color="tab:red", lw=1)
    ax.set_title(title)
    ax.set_aspect("equal")
    ax.set(xlim=(22, 78), ylim=(20, 76))
    ax.set_axis_off()
figure.savefig("docs/pictures/polyline.png", dpi=80)

# ---- three surfaces, several loops, a surface with itself
second = sheet("F2", "fault", along, 62 - 0.3 * depth - 0.25 * along, depth)
fine = np.linspace(0, 100, 41)
hills = sheet(
    "Hills", "horizon", fine, fine[:, None], 9 * np.outer(np.cos(fine / 12), np.cos(fine / 10))
)
level = sheet("OWC", "contact", x[::12, ::12], y[::12, ::12], np.full((2, 2), 4.1))
turn, height = np.meshgrid(np.linspace(-1.45, 1.45, 25), np.linspace(-9, 9, 5))
loop = turn**2 - 1  # a path that crosses itself where this is 0
folded = sheet("F3", "fault", 36 * loop, 36 * turn * loop + 0.4 * height, height)

figure = plt.figure(figsize=(11, 3.9), layout="constrained")
ax = figure.add_subplot(1, 3, 1)
ax.triplot(*top.vertices[:, :2].T, top.triangles, color="0.85", lw=0.6)
three = gs.intersect_surfaces([top, fault, second])
for pair, colour in ((("Top", "F1"), "tab:red"), (("Top", "F2"), "tab:blue"), (("F1", "F2"), "k")):
    for part in three.between(*pair):
        ax.plot(*part[:, :2].T, color=colour, lw=2, label=" and ".join(pair))
ax.legend(loc="lower left", fontsize=8)
ax.set_title("three surfaces, curves by pairs")

ax = figure.add_subplot(1, 3, 2)
ax.triplot(*hills.vertices[:, :2].T, hills.triangles, color="0.9", lw=0.3)
loops = gs.intersect_surfaces([hills, level])
for part, closed in zip(loops.between("Hills", "OWC"), loops.closed, strict=True):
    ax.plot(*part[:, :2].T, color="tab:red" if closed else "tab:orange", lw=2)
ax.set_title("several curves, closed (red) and open")

ax3 = figure.add_subplot(1, 3, 3, projection="3d", computed_zorder=False)
corners = folded.vertices[folded.triangles]
ax3.add_collection3d(Poly3DCollection(corners, facecolor="tab:olive", ec="0.4", lw=0.4, alpha=0.5))
for part in gs.intersect_surfaces([folded], self_intersections=True).between("F3", "F3"):
    ax3.plot(*part.T, color="tab:red", lw=3, zorder=6)
ax3.set(xlim=(-38, 40), ylim=(-60, 60), zlim=(-12, 12))
ax3.view_init(elev=40, azim=-35)
ax3.set_box_aspect((78, 120, 24), zoom=1.1)
ax3.set_title("a surface that meets itself")
for one in (*figure.axes[:2],):
    one.set_aspect("equal")
for one in figure.axes:
    one.set_axis_off()
figure.savefig("docs/pictures/loops.png", dpi=80)
