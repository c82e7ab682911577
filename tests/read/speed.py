"""How long readers take for one map of 1000 x 1000 nodes, and how much memory they take with it.

``python -m tests.read.speed [size]`` prints a table: processor time (user and system, the best of
three), so that other programs on the machine count little. Rotated by 30 degrees where the format
has rotation. With xtgeo installed, its reader runs in turn with geosurf's, in the same process.
"""

from __future__ import annotations

import struct
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import geosurf as gs

TURN = 30.0
STEP = (25.0, 12.5)
ORIGIN = (461000.0, 5932000.0)
# format of xtgeo for the same file
PEERS = {"irap": "irap_ascii", "irap binary": "irap_binary", "zmap": "zmap_ascii",
         "ijxyz": "ijxyz"}  # fmt: skip


def surface(n: int) -> np.ndarray:
    """Elevations (n, n) with four decimals."""
    x, y = np.meshgrid(np.linspace(0, 9, n), np.linspace(0, 9, n))
    return np.round(-1600 + 50 * np.sin(x) * np.cos(0.7 * y) + 9 * np.sin(7 * x), 4)


def nodes(n: int, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Easting and northing of each node (n, n)."""
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    along, across = np.meshgrid(np.arange(n) * STEP[0], np.arange(n) * STEP[1])
    return ORIGIN[0] + along * cos - across * sin, ORIGIN[1] + along * sin + across * cos


def lines(z: np.ndarray, per_line: int = 5) -> str:
    """Values as text."""
    words = [f"{v:.4f}" for v in z.ravel().tolist()]
    return (
        "\n".join(" ".join(words[k : k + per_line]) for k in range(0, len(words), per_line)) + "\n"
    )


def columns(*parts: np.ndarray) -> str:
    """Rows of text, one for each node."""
    table = np.stack([part.ravel() for part in parts], axis=1)
    return "".join(" ".join(f"{v:.10g}" for v in row) + "\n" for row in table.tolist())


def files(folder: Path, n: int) -> Iterator[tuple[str, bool, Path]]:
    """Name of each format, whether the map in it is rotated, and its file."""
    z = surface(n)
    x, y = nodes(n, TURN)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    east, north = ORIGIN[0] + STEP[0] * (n - 1), ORIGIN[1] + STEP[1] * (n - 1)
    sides = (ORIGIN[0], east, ORIGIN[1], north)
    corner = f"{ORIGIN[0]} {east} {ORIGIN[1]} {north}\n"
    head = f"{n} {STEP[1]} {STEP[0]}\n"
    irap = f"-996 {head}{corner}{n} {TURN} {ORIGIN[0]} {ORIGIN[1]}\n0 0 0 0 0 0 0\n"
    gxf = (
        f"#POINTS\n{n}\n#ROWS\n{n}\n#PTSEPARATION\n{STEP[0]}\n#RWSEPARATION\n{STEP[1]}\n#XORIGIN\n"
        f"{ORIGIN[0]}\n#YORIGIN\n{ORIGIN[1]}\n#ROTATION\n{TURN}\n#GRID\n"
    )
    zmap = (
        f"@map, GRID, 5\n15, -99999, , 4, 1\n{n}, {n}, {', '.join(map(str, sides))}\n0, 0, 0\n@\n"
    )
    cps = (
        "FSASCI 0 1 COMPUTED 0 1.0E30 0\nFSATTR 0 0\nFSLIMI "
        f"{corner.strip()} -9999 9999\nFSNROW {n} {n}\nFSXINC {STEP[0]} {STEP[1]}\n-> map\n"
    )
    esri = (
        f"ncols {n}\nnrows {n}\nxllcenter {ORIGIN[0]}\nyllcenter {ORIGIN[1]}\ndx {STEP[0]}\n"
        f"dy {STEP[1]}\nNODATA_value -9999\n"
    )
    vision = (
        "# Type: scattered data\n# Field: 1 x\n# Field: 2 y\n# Field: 3 z meters\n"
        f"# Field: 4 column\n# Field: 5 row\n# Grid_size: {n} x {n}\n"
        f"# Grid_space: {','.join(map(str, sides))}\n# End:\n"
    )
    flat_x, flat_y = nodes(n, 0.0)
    from_north = z[::-1].T
    surfer = struct.pack(
        "<2i8d", n, n, ORIGIN[0], ORIGIN[1], STEP[0], STEP[1], -9999, 9999, 0, 1.70141e38
    )
    surfer = b"DSRB" + struct.pack("<ii", 4, 2) + b"GRID" + struct.pack("<i", 72) + surfer
    storm = f"STORMGRID_BINARY\n\n{n} {n} {STEP[0]} {STEP[1]}\n{corner}"
    sgrid = f"GOCAD SGrid 1\nAXIS_N {n} {n} 1\nPOINTS_FILE sgrid@@\nEND\n"
    (folder / "sgrid@@").write_bytes(np.stack([x, y, z], axis=-1).astype(">f4").tobytes())

    texts: dict[str, tuple[bool, Callable[[], str | bytes]]] = {
        "irap": (True, lambda: irap + lines(z)),
        "gxf": (True, lambda: gxf + lines(z)),
        "ijxyz": (True, lambda: columns(i + 1, j + 1, np.round(x, 2), np.round(y, 2), z)),
        "sgrid": (True, lambda: sgrid),
        "zmap": (False, lambda: zmap + lines(from_north)),
        "cps3": (False, lambda: cps + lines(from_north)),
        "esri": (False, lambda: esri + lines(z[::-1])),
        "earthvision": (False, lambda: vision + columns(flat_x, flat_y, z, j + 1, i + 1)),
        "storm": (False, lambda: storm.encode() + z.astype(">f8").tobytes()),
        "surfer": (False, lambda: surfer + b"DATA" + struct.pack("<i", 8 * n * n)
                   + z.astype("<f8").tobytes()),
    }  # fmt: skip
    for name, (rotated, make) in texts.items():
        path = folder / f"{name}.map"
        content = make()
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        yield name, rotated, path

    # formats that only libraries write
    top = gs.read_horizon(folder / "irap.map", positive="up", name="map")
    for name, suffix in (("irap binary", ".gri"), ("netcdf", ".nc"), ("geotiff", ".tif")):
        path = (folder / "map").with_suffix(suffix)
        if name != "geotiff":
            gs.write(top, path)
        elif not _write_tif(path, z):
            continue
        yield name, True, path


def _write_tif(path: Path, z: np.ndarray) -> bool:
    """Write a GeoTIFF; False without rasterio."""
    try:
        import rasterio
    except ImportError:
        return False
    place = rasterio.Affine.translation(*ORIGIN) @ rasterio.Affine.rotation(TURN)
    place = place @ rasterio.Affine.scale(*STEP)
    words = {"driver": "GTiff", "count": 1, "dtype": "float32", "compress": "lzw"}
    height, width = z.shape
    with rasterio.open(path, "w", width=width, height=height, transform=place, **words) as file:
        file.write(z.astype("float32"), 1)
    return True


def best(*readers: Callable[[], Any]) -> list[float]:
    """Least processor time of each reader in three rounds, one after the other [s]."""
    times = [[] for _ in readers]
    for _ in range(3):
        for spent, read in zip(times, readers, strict=True):
            start = time.process_time()
            read()
            spent.append(time.process_time() - start)
    return [min(spent) for spent in times]


def main(n: int) -> None:
    """Print the table."""
    try:
        import xtgeo
    except ImportError:
        xtgeo = None
    out = sys.stdout.write
    out(f"{n} x {n} nodes, arrays of {8 * n * n / 2**20:.0f} MB, processor time\n\n")
    out("| format | rotated | file [MB] | time [s] | peak memory [MB] | xtgeo [s] |\n")
    out("|---|---|---|---|---|---|\n")
    with tempfile.TemporaryDirectory() as name:
        for kind, rotated, path in files(Path(name), n):
            words = {} if kind in ("netcdf", "sgrid") else {"positive": "up"}

            def own(path: Path = path, words: dict[str, str] = words) -> Any:
                return gs.read_horizon(path, **words)

            readers = [own]
            if xtgeo is not None and kind in PEERS:
                readers.append(
                    lambda path=path, kind=kind: xtgeo.surface_from_file(path, fformat=PEERS[kind])
                )
            try:
                times = best(*readers)
            except gs.errors.DependencyError as error:
                out(f"| {kind} | | | | | {error} |\n")
                continue
            tracemalloc.start()
            own()
            peak = tracemalloc.get_traced_memory()[1] / 2**20
            tracemalloc.stop()
            size = path.stat().st_size / 2**20
            peer = f"{times[1]:.2f}" if len(times) > 1 else ""
            turned = "yes" if rotated else "no"
            out(f"| {kind} | {turned} | {size:.0f} | {times[0]:.2f} | {peak:.0f} | {peer} |\n")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
