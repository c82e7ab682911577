"""Fingerprints: hashes of what the inputs of a scene hold."""

from __future__ import annotations

import hashlib
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions.crs import crs_of
from geosurf.model import FaultSticks, Sheet, TriSurface
from geosurf.model.surfaces import Sector

_PART = 1 << 24  # bytes of a file that are read at once
_LONG = 1 << 20  # bytes of an array that is shortened before it is hashed
_LANES = 2048  # numbers of 64 bits to which it is shortened: they stay in the nearest cache


def fingerprint(value: Any, strangers: list[Any] | None = None) -> str:
    """
    Return a hash of what an input of a scene holds.

    Parameters
    ----------
    value : path, TriSurface, Sheet, FaultSticks, xarray object, arrays, or anything else
        Files count by path and content; any other object by its identity.
    strangers : list, optional
        Gets what counted by its identity, which means something while it is held only.

    Returns
    -------
    str

    Examples
    --------
    >>> one, two = (TriSurface("F1", "fault", np.eye(3), [[0, 1, 2]]) for _ in range(2))
    >>> fingerprint(one) == fingerprint(two) != fingerprint(one.renamed("F2"))
    True
    """
    digest = hashlib.sha256()
    _add(digest, value, [] if strangers is None else strangers)
    return digest.hexdigest()


def _add(digest: Any, value: Any, strangers: list[Any]) -> None:
    """Add one input to a hash, with the lengths and kinds that separate its parts."""
    if isinstance(value, Sheet):
        # a sheet is its torn mesh; reports and cut-offs follow from it
        if value.mesh is not None:
            _add(digest, value.surface, strangers)
            return
        # the lattice, and the triangles at its faults: the mesh follows from them
        digest.update(f"{value.name} {value.crs}".encode())
        _add(digest, TriSurface(value.name, "horizon", lattice=value.lattice), strangers)
        _add(digest, (value.divided, value.copies, value.ghosts, value.outer), strangers)
        for sector in value.sectors:
            _add_sector(digest, sector, strangers)
        for key, array in sorted((value.walls or {}).items()):
            digest.update(f"wall of {key}".encode())
            _add(digest, array, strangers)
        if value.extrapolated is not None:
            _add(digest, value.extrapolated, strangers)
    elif isinstance(value, str | Path):
        # by path and content: a file that changes is another input
        path = Path(value)
        name = str(path.resolve()).encode()
        digest.update(f"{len(name)} ".encode() + name)
        _add_file(digest, path)
    elif isinstance(value, TriSurface):
        digest.update(f"{value.name} {value.role} {value.crs}".encode())
        if value.lattice is None:
            _add(digest, (value.vertices, value.triangles), strangers)
        else:  # as a lattice: its triangles need not be made
            grid = value.lattice
            digest.update(f"{grid.rising} {grid.reverse}".encode())
            _add(digest, (grid.easting, grid.northing, grid.elevation), strangers)
        for one in value.sectors:
            _add_sector(digest, one, strangers)
        for key, array in sorted(value.vertex_data.items()):
            digest.update(key.encode())
            _add(digest, array, strangers)
    elif isinstance(value, FaultSticks):
        digest.update(f"{value.crs}".encode())
        _add(digest, tuple(value.sticks), strangers)
    elif hasattr(value, "to_dict") and hasattr(value, "coords"):
        # attributes count, since they may hold unit, direction and reference system
        # of coordinates the arrays alone: labels cost more than what they label
        coords = getattr(value.coords, "variables", value.coords)
        arrays = {**getattr(value, "data_vars", {"": value}), **coords}
        _add_attrs(digest, value.attrs)
        digest.update(f"{crs_of(value)}".encode())
        for key, array in arrays.items():
            digest.update(f"{key} {array.dims}".encode())
            _add_attrs(digest, array.attrs)
            _add(digest, array.values, strangers)
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(f"{value.dtype} {value.shape}".encode())

        # after kind and shape: equal bytes may mean different numbers
        content = np.ascontiguousarray(value)
        digest.update(content if content.nbytes < _LONG else _shortened(content))
        # without the module there are none, and loading it takes a while
        if "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray):
            _add(digest, np.ma.getmaskarray(value), strangers)
    elif isinstance(value, tuple | list):
        # the length first, so that (a, b), c and a, (b, c) differ
        digest.update(f"{type(value).__name__} {len(value)}".encode())
        digest.update(getattr(value, "crs", "").encode())  # of a `PlainMesh`
        for part in value:
            _add(digest, part, strangers)
    elif isinstance(value, int | float | np.number):
        digest.update(repr(value).encode())
    else:
        # nothing is known of it: it stands for itself as long as it is held
        strangers.append(value)
        digest.update(f"{id(value)}".encode())


def _shortened(array: np.ndarray) -> bytes:
    """Many bytes as a few that a slow hash can take: at the speed of memory.

    Each number of a lane is mixed into the state of the lane by a map that is one-to-one, so that
    arrays which differ in one number of a lane have different states. States of lanes that differ
    in more numbers are equal in one of 2**64 cases.
    """
    from geosurf.kernels.lattices.decimate import AT_ONCE, mix_into

    content = array.reshape(-1).view(np.uint8)
    step = 8 * AT_ONCE * _LANES
    mixed = content.nbytes // step * step
    state = np.arange(_LANES)
    with np.errstate(over="ignore"):  # products are meant to overflow; Python itself warns of it
        mix_into(state, content[:mixed].view(np.int64))
    return state.tobytes() + content[mixed:].tobytes()


def _add_sector(digest: Any, sector: Sector, strangers: list[Any]) -> None:
    digest.update(f"{sector.faults} {sector.front} {sector.rising}".encode())
    _add(digest, (sector.corner, sector.step, sector.elevation), strangers)


def _add_file(digest: Any, path: Path) -> None:
    """Add the content of a file, a part at a time; of a store, names, sizes and times of files."""
    if path.is_dir():
        for folder, _, names in sorted(os.walk(path)):
            for name in sorted(names):
                state = (Path(folder) / name).stat()
                digest.update(f"{folder} {name} {state.st_size} {state.st_mtime_ns} ".encode())
    elif path.is_file():
        with path.open("rb") as file:
            while part := file.read(_PART):
                digest.update(part)
    else:
        digest.update(b"missing")


def _add_attrs(digest: Any, attrs: Any) -> None:
    digest.update(repr(sorted((str(k), str(v)) for k, v in attrs.items())).encode())
