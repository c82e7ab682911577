"""Bounds of chunks in a file next to their store, or in geosurf's cache where that is read-only.

A file is used only if its key is that of the store: the names, sizes and times of its files, what
is done to its values, and the form of the bounds. Damaged files and those of others are made again.
"""

from __future__ import annotations

import hashlib
import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.files.atomic import write_whole
from geosurf.files.sealed import read_own, sealed, unsealed
from geosurf.kernels.compile.cache_folder import cache_root
from geosurf.model.chunk_store import ChunkBounds, Store
from geosurf.model.store_files import StoreFiles

_FORM = f"geosurf bounds of chunks 1 {list(ChunkBounds.__dataclass_fields__)}"
_ARRAYS = ("boxes", "blocks", "starts", "in_use", "last_rows", "last_cols", "holes", "of_map")
_LARGEST = 1 << 32
_SUFFIX = ".geosurf-bounds"


def key_of_store(
    store: Store, axes: tuple[np.ndarray | Store, np.ndarray | Store]
) -> tuple[str, Path, StoreFiles] | None:
    """Return what identifies the values of a store, where to keep bounds, and its files.

    None if they are not known.
    """
    try:
        both = [axis.data for axis in axes if isinstance(axis, Store)]
        parts = [_sources(data) for data in (store.data, *both)]
        if not all(parts):
            return None
        sources = list(dict.fromkeys(path for part in parts for path in part))
        files = StoreFiles.of(own for _, own in sources)
    except OSError:
        return None  # the store is not a folder or file of this machine
    digest = hashlib.sha256(f"{_FORM} {files.state}".encode())
    digest.update(f"{store.data.name} {store.shape} {store.turned} {store.scale!r}".encode())
    for array in (store.row_starts, store.col_starts, *axes):
        if isinstance(array, Store):
            digest.update(f"{array.data.name} {array.scale!r}".encode())
        else:
            digest.update(np.ascontiguousarray(array).tobytes())
    first = sources[0][0]
    name = "".join(c if c.isalnum() or c in "-_." else "_" for c in store.name)
    return digest.hexdigest(), first.with_name(f"{first.name}.{name}{_SUFFIX}"), files


def load_bounds(place: Path, key: str) -> ChunkBounds | None:
    """Return bounds that an earlier session kept under a key, or None."""
    for path in _places(place, key):
        try:
            payload = unsealed(key, read_own(path, _LARGEST))
        except OSError:
            continue
        if payload is not None:  # its checksum is right: what follows was written by `save_bounds`
            with np.load(io.BytesIO(payload), allow_pickle=False) as found:
                falling, rising = found["counts"].tolist()
                arrays = {key: found[key] for key in _ARRAYS}
                return ChunkBounds(n_triangles=(falling, rising), **arrays)
    return None


def save_bounds(place: Path, key: str, bounds: ChunkBounds) -> None:
    """Keep bounds next to their store, else in the cache; without either they are made again."""
    buffer = io.BytesIO()
    counts = np.array(bounds.n_triangles, dtype=np.int64)
    arrays = {key: getattr(bounds, key) for key in _ARRAYS}
    np.savez(buffer, allow_pickle=False, counts=counts, **arrays)
    data = sealed(key, buffer.getvalue())
    for path in _places(place, key):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(path, data, 0o644)
            return
        except OSError:
            continue


def _places(place: Path, key: str) -> list[Path]:
    """Files in which bounds may be: next to the store, then in the cache."""
    try:
        return [place, cache_root() / "bounds" / f"{key}{_SUFFIX}"]
    except OSError:
        return [place]


def _sources(data: Any) -> list[tuple[Path, Path]]:
    """Stores that a Dask array reads, and the files of its values; empty if some are not known."""
    found: list[tuple[Path, Path]] = []
    if not hasattr(data, "dask"):
        return found
    for name, layer in data.dask.layers.items():
        if not str(name).startswith("original-"):  # xarray calls what it has opened so
            continue
        for value in layer.values():
            path = _path_of(value)
            if path is None:
                return []
            found.append(path)
    return sorted(set(found))


def _path_of(value: Any) -> tuple[Path, Path] | None:
    """The path behind wrappers of xarray, of a Zarr store in a folder or of a file.

    The files of a Zarr array are a folder of their own, so that others in its store may change.
    """
    value = getattr(value, "value", value)  # Dask wraps data
    while hasattr(value, "array"):
        value = value.array
    zarr = getattr(value, "_array", None)
    root = getattr(getattr(zarr, "store", None), "root", None)
    name = getattr(getattr(value, "datastore", None), "_filename", None)
    path = root if root is not None else name
    if not isinstance(path, str | os.PathLike) or not Path(path).exists():
        return None
    own = "" if root is None else str(getattr(zarr, "path", ""))
    return Path(path), Path(path) / own if own else Path(path)


__all__ = ["key_of_store", "load_bounds", "save_bounds"]
