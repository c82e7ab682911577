"""How two triangles can meet: twelve cases, each found by `intersect_triangles`."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import geosurf as gs

BASE = np.array([[0, 0, 0], [24, 0, 0], [0, 24, 0]], dtype=float)
CASES = {  # the second triangle; the first is always BASE
    "apart": ((5, 5, 2), (14, 4, 9), (4, 14, 9)),
    "corner on corner": ((24, 0, 0), (30, 6, 9), (34, -6, 6)),
    "corner on edge": ((12, 0, 0), (8, -9, 8), (18, -9, 8)),
    "corner on face": ((7, 7, 0), (3, 3, 12), (14, 6, 12)),
    "edge across edge": ((12, -6, -6), (12, 6, 6), (20, -14, 6)),
    "edge on edge": ((4, 0, 0), (18, 0, 0), (11, -6, 12)),
    "edge in the face": ((3, 4, 0), (12, 8, 0), (6, 5, 12)),
    "corner through the face": ((6, 6, -6), (2, 4, 10), (12, 9, 10)),
    "each through the other": ((9, 8, -9), (9, -12, 8), (10, 10, 10)),
    "through a corner": ((-8, -8, -8), (18, 18, -8), (5, 5, 16)),
    "in one plane, touching": ((13, 0, 0), (7, -11, 0), (20, -8, 0)),
    "in one plane, overlapping": ((6, 6, 0), (26, 10, 0), (8, -8, 0)),
}

figure = plt.figure(figsize=(11, 7.5), layout="constrained")
for number, (title, corners) in enumerate(CASES.items()):
    second = np.array(corners, dtype=float)
    contact = gs.intersect_triangles(BASE, second)
    ax = figure.add_subplot(3, 4, number + 1, projection="3d", computed_zorder=False)
    for corners_of, colour in ((BASE, "tab:olive"), (second, "tab:blue")):
        face = Poly3DCollection([corners_of], facecolor=colour, edgecolor="black", alpha=0.4)
        ax.add_collection3d(face)
    points = np.asarray(contact.points)
    if len(points) > 2:
        ax.add_collection3d(Poly3DCollection([points], facecolor="tab:red", alpha=0.8, zorder=5))
    elif len(points):
        ax.plot(*points.T, "o-", color="tab:red", lw=3, ms=5, zorder=6)
    ax.set(xlim=(-6, 28), ylim=(-12, 26), zlim=(-8, 12))
    ax.set_title(f"{title}\n{contact.kind}, {len(points)} points", fontsize=10)
    ax.view_init(elev=32, azim=-62)
    ax.set_box_aspect((34, 38, 20), zoom=1.6)
    ax.set_axis_off()
figure.savefig("docs/pictures/triangle_contacts.png", dpi=80)
