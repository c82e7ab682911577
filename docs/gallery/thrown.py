"""Continuous horizons, moved by the throw of their faults: an ellipse, a listric fault, a Y."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import geosurf as gs

cases = {
    "an elliptic fault": ("normal", {"F1": gs.EllipticThrow(60.0, half_length=600.0)}, {}),
    "reverse drag, reach 700 m": ("normal", {"F1": 60.0}, {"reach": 700.0}),
    "Y: F2 ends on F1": ("Y", {"F2": 50.0, "F1": 80.0}, {}),
}
figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
for ax, (title, (kind, throw, options)) in zip(axes, cases.items(), strict=True):
    world = gs.synthetic.faulted(kind)
    sheet = gs.throw_horizon(world.horizons["Top"], world.faults, throw, name="Top", **options)
    faults = {fault.name: fault for fault in sheet.faults}
    scene = gs.Scene({"Top": sheet}, faults, world.box)
    top = scene.patches.surface("Top")
    colours = ax.tripcolor(*top.vertices[:, :2].T, top.triangles, top.vertices[:, 2])
    figure.colorbar(colours, ax=ax, label="elevation [m]", shrink=0.8)
    ax.set(title=title, xlabel="easting [m]", ylabel="northing [m]")
    ax.set_aspect("equal")
figure.savefig("docs/pictures/sheets_throw.png", dpi=90)
