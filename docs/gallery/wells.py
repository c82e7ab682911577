"""A vertical section with wells that miss the horizons by up to 25 m."""

from field import SIZE, scene

wells = {"A-1": (700, 25.0), "A-2": (2150, -15.0), "A-3": (3600, 20.0), "A-4": (5100, -20.0)}
names = scene.horizon_names
tops = {
    "well": [well for well in wells for _ in names],
    "horizon": [name for _ in wells for name in names],
    "easting": [east for east, _ in wells.values() for _ in names],
    "northing": [2000.0] * len(wells) * len(names),
    "elevation": [0.0] * len(wells) * len(names),
}
exact = scene.misfit(tops).model.values  # where the horizons are
off = [miss for _, miss in wells.values() for _ in names]
drilled = scene.replace(tops=tops | {"elevation": exact - off})
line = [(0, 2000), (6000, 2000)]  # easting, northing [m]
drilled.plot.section(line, path="docs/pictures/wells.png", size=SIZE)
