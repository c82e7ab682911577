"""Follow one grid from its file to units: ``python -m benchmarks.walk``.

Which rooms and files of the package does the walk enter? How often does it return to a room that it
has left? A room is a package below geosurf, or a module that lies next to them. Only Python is
followed; compiled kernels are not. Runs on any checkout: ``PYTHONPATH=<checkout> python walk.py``.
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

import geosurf as gs

PACKAGE = Path(gs.__file__).parent
COMMON = {"errors", "warning", "conventions", "model", "kernels", "crs", "__init__"}


class Walk:
    """Records the room of each call that leaves the room of its caller."""

    def __init__(self) -> None:
        self.rooms: list[str] = []
        self.files: Counter[str] = Counter()

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        """Take one event of the interpreter."""
        if event != "call":
            return
        path = Path(frame.f_code.co_filename)
        if PACKAGE not in path.parents:
            return
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if parts[0] in COMMON:
            return
        self.files["/".join(parts)] += 1
        if not self.rooms or self.rooms[-1] != parts[0]:
            self.rooms.append(parts[0])


def walk() -> Walk:
    """From two grid files and a fault file to volumes of units."""
    world = gs.synthetic.graben(n=21)
    with tempfile.TemporaryDirectory() as folder:
        paths = {}
        for name, data in {**world.horizons, **world.faults}.items():
            paths[name] = Path(folder) / f"{name}.nc"
            data.to_netcdf(paths[name], engine="h5netcdf")
        found = Walk()
        for _ in range(2):  # imports are not followed
            horizons = {name: gs.read_horizon(paths[name]) for name in world.horizons}
            faults = {name: gs.read_fault(paths[name]) for name in world.faults}
            found = Walk()
            sys.setprofile(found)
            try:
                horizons = {name: gs.read_horizon(paths[name]) for name in world.horizons}
                scene = gs.Scene(horizons, faults, world.box)
                scene.volumes  # noqa: B018 - asking computes
            finally:
                sys.setprofile(None)
    return found


def main() -> None:
    """Print what was entered."""
    found = walk()
    visits = Counter(found.rooms)
    returns = sum(visits.values()) - len(visits)
    sys.stdout.write(
        f"{len(visits)} rooms, {len(found.files)} files; rooms entered {sum(visits.values())} "
        f"times, {returns} of them again\n"
    )
    for room, count in visits.most_common():
        files = sorted(name for name in found.files if name.split("/")[0] == room)
        sys.stdout.write(f"{room:14} {count:5}  {', '.join(n.split('/', 1)[-1] for n in files)}\n")


if __name__ == "__main__":
    main()
