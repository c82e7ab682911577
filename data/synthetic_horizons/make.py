"""Write the synthetic worlds of `geosurf.synthetic` as small CF NetCDF files.

Run it from anywhere: ``python data/synthetic_horizons/make.py``. It writes one
folder per world, one file per horizon and fault, and the README beside itself.
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from geosurf import synthetic
from geosurf.synthetic import World

HERE = Path(__file__).resolve().parent

WORLDS = (
    synthetic.tilted_planes(n=33),
    synthetic.graben(n=33),
    synthetic.noisy(n=33),
    synthetic.dome_and_flat_fault(n=65),
    synthetic.egg_box(n=97),
    synthetic.listric(n=65),
    synthetic.faulted_reservoir(n=101),
)

INTRODUCTION = """# Synthetic horizons and faults

Worlds whose curves and volumes are known, as CF NetCDF (NetCDF 4): one folder per world, one
file per horizon and fault. All coordinates are metres, elevation positive up, in a local frame
without CRS. A horizon is `elevation` over `(northing, easting)`; a fault is `easting`,
`northing` and `elevation` over `(down_dip, along_strike)`.

This file and all data beside it are written by `make.py` from `geosurf.synthetic`; do not edit
them by hand. To read a horizon: `geosurf.read_horizon("tilted_planes/Top.nc")`.

In the tables, a side such as `F1+` is the one into which the normal of the fault points: the
hanging wall. Volumes of several pieces in one zone on the same sides are added up. Worlds of
planes are met exactly by their triangles; of curved worlds, these are the limits for ever finer
grids.
"""


def write_world(world: World, folder: Path) -> list[Path]:
    """Write all grids of a world and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name, da in world.horizons.items():
        ds = da.rename("elevation").to_dataset()
        files.append(_write(ds, world, name, folder))
    for name, ds in world.faults.items():
        files.append(_write(ds, world, name, folder))
    return files


def _write(ds: xr.Dataset, world: World, name: str, folder: Path) -> Path:
    ds = ds.drop_attrs(deep=False).assign_attrs(
        Conventions="CF-1.11",
        title=f"{name} of {world.name}",
        long_name=name,
        comment=world.formula,
    )
    grids = {str(key): {"zlib": True, "complevel": 6} for key in ds.data_vars}
    plain = {str(key): {"_FillValue": None} for key in ds.variables}
    encoding = {key: value | grids.get(key, {}) for key, value in plain.items()}
    path = folder / f"{name}.nc"
    ds.to_netcdf(path, engine="h5netcdf", encoding=encoding)
    return path


def describe(world: World) -> str:
    """Return the section of the README about one world."""
    box = ", ".join(f"{value:g}" for value in world.box)
    lines = [
        f"## {world.name}",
        "",
        world.formula,
        "",
        f"Box (west, east, south, north, bottom, top): {box}.",
        "",
    ]
    truth = world.truth
    bounds = truth.get("volume_bounds", {})
    if "volumes" in truth:
        head = "of the planes without noise, and bounds " if bounds else ""
        lines += [f"| zone | sides | volume {head}[m3] |", "|---|---|---|"]
        for (zone, sides), value in truth["volumes"].items():
            low, high = bounds.get((zone, sides), (None, None))
            span = "" if low is None else f" ({low!r} to {high!r})"
            lines.append(f"| {zone} | {', '.join(sides)} | {value!r}{span} |")
        lines.append("")
    if "curve_length" in truth:
        lines += ["| horizon | fault | length of the curves in the box [m] |", "|---|---|---|"]
        lines += [f"| {h} | {f} | {value!r} |" for (h, f), value in truth["curve_length"].items()]
        kind = "closed" if truth["closed"] else "open"
        lines += ["", f"Curves between horizons and faults: {truth['n_curve']}, {kind}.", ""]
    if "splits" in truth:
        alone = [name for name, splits in truth["splits"].items() if splits]
        inside = [name for name, splits in truth["splits"].items() if not splits]
        lines += [
            f"Divides the model by itself: {', '.join(alone)}. Dies inside: {', '.join(inside)}.",
            "",
        ]
    return "\n".join(lines)


def main(folder: Path = HERE) -> None:
    """Write everything."""
    for world in WORLDS:
        write_world(world, folder / world.name)
    sections = [INTRODUCTION, *(describe(world) for world in WORLDS)]
    (folder / "README.md").write_text("\n".join(sections).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
