"""A horizon that gridding smeared across a fault, torn there: map and section."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import geosurf as gs

world = gs.synthetic.torn("normal")
grid = world.horizons["Top"]
sheet = gs.tear_horizon(grid, world.faults, name="Top", trim=2)
faults = {fault.name: fault for fault in sheet.faults}
east, north = grid.easting, grid.northing
box = (east[0] + 50, east[-1] - 50, north[0] + 50, north[-1] - 50, -2050, -1500)
scene = gs.Scene({"Top": sheet}, faults, tuple(float(side) for side in box))
middle = float(north.mean())
section = scene.section([(box[0], middle), (box[1], middle)])

figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8), layout="constrained")
top = scene.patches.surface("Top")
colours = left.tripcolor(
    *top.vertices[:, :2].T, top.triangles, top.vertices[:, 2], shading="gouraud"
)
figure.colorbar(colours, ax=left, label="elevation [m]")
for wall, colour in (("+", "tab:red"), ("-", "black")):
    for line in sheet.cuts["F1"].cutoffs[wall]:
        left.plot(*line[:, :2].T, color=colour, lw=1.5)
left.set(title="sheet: the gap is the heave", xlabel="easting [m]", ylabel="northing [m]")
left.set_aspect("equal")

right.plot(
    east, grid.sel(northing=middle, method="nearest"), "o", ms=4, color="0.6", label="grid, smeared"
)
for name, colour in (("Top", "tab:blue"), ("F1", "tab:red")):
    surface = scene.patches.surface(name)
    corners = [
        (box[0], middle, -2100),
        (box[1], middle, -2100),
        (box[1], middle, -1400),
        (box[0], middle, -1400),
    ]
    plane = gs.TriSurface("section", "surface", corners, [[0, 1, 2], [0, 2, 3]])
    cut = gs.intersect_surfaces([surface, plane])
    for i, line in enumerate(cut.curves):
        right.plot(*cut.points[line][:, [0, 2]].T, color=colour, label=None if i else name)
right.set(xlim=(600, 1300), ylim=(-1840, -1720))
right.set(title=f"section at northing {middle:g} m", xlabel="easting [m]", ylabel="elevation [m]")
right.legend()
figure.savefig("docs/pictures/sheets.png", dpi=90)
