"""Maps of 1000 x 1000 nodes and a million triangles: processor time and memory, next to peers."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import geosurf as gs
from benchmarks.formats.memory import read_memory
from benchmarks.formats.peers import Peers
from benchmarks.formats.subjects import grid_of, mesh_of

N_MAP, N_MESH, N_SMALL, REPEAT = 1000, 708, 150, 3  # nodes along a side
# suffix -> what is written, how it is read back, the package next to it, asked [s]
ASKED: dict[str, tuple[str, str, float | None]] = {
    ".irapasc": ("read_horizon", "xtgeo", 0.6),
    ".gri": ("read_horizon", "xtgeo", None),
    ".zmap": ("read_horizon", "xtgeo", 0.3),
    ".cps3": ("read_horizon", "", None),
    ".asc": ("read_horizon", "rioxarray", None),
    ".xyz": ("read_points", "xtgeo", 1.0),
    ".nc": ("read_horizon", "rioxarray", None),
    ".ts": ("read_fault", "opengeode", 3.0),
    ".vtp": ("read_fault", "pyvista", None),
    ".glb": ("read_fault", "pyvista", None),
}
TURNED = (".irapasc", ".gri", ".xyz", ".nc")


@dataclass
class Timing:
    """
    One format.

    Attributes
    ----------
    suffix, peer : str
    write, read : float
        Processor time [s], the best of some.
    memory, read_memory : float
        Largest memory that numpy and Python took while writing, over that of the arrays; and
        what a process of its own grew by while it read.
    peer_read : float or None
        Processor time of the other package for the same file [s].
    asked : float or None
        For writing and reading together [s].
    """

    suffix: str
    peer: str
    write: float
    read: float
    memory: float
    read_memory: float
    peer_read: float | None = None
    asked: float | None = None


def timings(peers: Peers, folder: Path, scale: float = 1.0) -> list[Timing]:
    """Write and read a large object in each format; `scale` shortens its sides."""
    n = max(10, int(scale * N_MAP))
    maps = {turn: grid_of(n, n, turn) for turn in (0.0, 30.0)}
    mesh = mesh_of(max(10, int(scale * N_MESH)))
    found, tasks = [], []
    for suffix, (function, peer, asked) in ASKED.items():
        surface = function == "read_fault"
        turn = 30.0 if suffix in TURNED else 0.0
        obj = mesh if surface else maps[turn]
        path = folder / f"large{suffix}"
        read = _reading(function, path, surface or suffix == ".nc")
        write_time = _best(lambda obj=obj, path=path: gs.write(obj, path))
        memory = _memory(obj, lambda obj=obj, path=path: gs.write(obj, path))
        small = folder / f"small{suffix}"
        gs.write(mesh_of(N_SMALL) if surface else grid_of(N_SMALL, N_SMALL, turn), small)
        read_peak = read_memory(function, small, path, **_words(surface or suffix == ".nc"))
        found.append(Timing(suffix, peer, write_time, _best(read), memory, read_peak, asked=asked))
        tasks.append((peer, path))
    known = [k for k, (peer, _) in enumerate(tasks) if peer in peers.home]
    for k, answer in zip(known, peers.read([tasks[k] for k in known], REPEAT), strict=True):
        found[k].peer_read = answer.get("seconds")
    return found


def _reading(function: str, path: Path, stated: bool) -> Callable[[], object]:
    return lambda: getattr(gs, function)(path, **_words(stated))


def _words(stated: bool) -> dict[str, str]:
    """The words that a reader needs for a file that does not state its direction."""
    return {} if stated else {"positive": "up"}


def _best(run: Callable[[], object]) -> float:
    """Smallest processor time of some calls [s]."""
    found = []
    for _ in range(REPEAT):
        start = time.process_time()
        run()
        found.append(time.process_time() - start)
    return min(found)


def _memory(obj: Any, run: Callable[[], object]) -> float:
    """Peak of a call, over the size of the arrays."""
    if hasattr(obj, "triangles"):
        size = obj.vertices.nbytes + obj.triangles.nbytes
    else:
        size = obj.nbytes + sum(axis.nbytes for axis in obj.coords.values())
    tracemalloc.start()
    try:
        run()
        return tracemalloc.get_traced_memory()[1] / size
    finally:
        tracemalloc.stop()


__all__ = ["Timing", "timings"]
