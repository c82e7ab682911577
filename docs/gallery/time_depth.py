"""One line through a model in time and in depth: fast rock lies beside slow rock at the fault."""

import matplotlib.pyplot as plt

import geosurf as gs

world = gs.synthetic.torn("normal", n=81)
horizons = {"Top": world.horizons["Top"], "Base": world.horizons["Top"] - 90.0}
horizons = {name: one.assign_attrs(units="ms", positive="up") for name, one in horizons.items()}
velocity = {"above Top": 1900.0, "Top/Base": 3400.0, "below Base": 2600.0}
faults = {"F1": gs.triangulate_fault(world.faults["F1"], name="F1")}  # a mesh: minus ms
depth = gs.Scene(horizons, faults, time="two-way", velocity=velocity, tear=True)

west, east, south, north = depth.box[:4]
line = [(west, 0.5 * (south + north)), (east, 0.5 * (south + north))]
figure, axes = plt.subplots(1, 2, figsize=(14, 5))
for scene, ax in zip((depth.in_time(), depth), axes, strict=True):
    scene.plot.section(line, ax=ax, title="In time" if scene.time else "In depth")
figure.savefig("docs/pictures/time_depth.png", dpi=100)
