"""What an HDF5 file announces, looked at before any of its arrays is read.

A dataset of some bytes may declare any shape (a fill value stands for what is not stored), chunks
larger than itself, chunks that unpack to more than a chunk, texts that are referred to a million
times, and data in other files. Such arrays are refused, or ignored if they are not numeric.
"""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.errors import FormatError
from geosurf.read._guard import ALLOWANCE, damaged, refuse_large

if TYPE_CHECKING:  # pragma: no cover - types only
    import h5py

DEFLATE, LARGEST_RATIO = 1, 1032  # filter of zlib, and how much it can pack
COPIES = 5  # of an array in 64 bits that are there at a time, from the file to the surface


def refuse_bombs(path: Path, file: h5py.File, size: int, stays: float = math.inf) -> list[str]:
    """
    Refuse what takes more memory than a file of that size may ask for.

    Parameters
    ----------
    path : pathlib.Path
        For messages.
    file : h5py.File
        Open for reading.
    size : int
        Bytes of the file.
    stays : float
        Arrays of more values than this are read in parts: they take no memory.

    Returns
    -------
    list of str
        Names of arrays of texts and other things that are not numeric and are not read.

    Raises
    ------
    FormatError
    """
    import h5py

    # Walk through all groups; hard links can make circles, so each object is visited once.
    passed_over, total, todo, seen = [], 0, [file["/"]], set()
    while todo:
        group = todo.pop()
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise FormatError(
                    f"{path}: {name!r} is a link to another file, {link.filename!r}. geosurf "
                    "does not follow such links. Copy the data into one file."
                )
            found = group.get(name)
            if found is None or (found.id in seen):  # a link to nothing, or a circle
                continue
            seen.add(found.id)
            if isinstance(found, h5py.Group):
                todo.append(found)
            elif isinstance(found, h5py.Dataset):
                # texts and references are left out: a few bytes of them may stand for gigabytes
                if found.size is not None and found.size > 1 and found.dtype.kind not in "fiub":
                    passed_over.append(str(name))
                    continue
                if found.is_virtual or found.external:
                    raise FormatError(
                        f"{path}: the values of {found.name!r} are in other files. Copy them into "
                        "one file."
                    )
                if (found.size or 0) > stays:
                    stored, parts = int(found.id.get_storage_size() > 0), 1
                    if found.chunks:
                        sides = zip(found.shape, found.chunks, strict=True)
                        stored = int(found.id.get_num_chunks())
                        parts = math.prod(-(-n // step) for n, step in sides)
                    refuse_empty(path, str(name), found.shape, stored, parts)
                    continue
                # Bytes of all variables together, since xarray may load each of them.
                total += _bytes_of(path, found, size)
                what = f"variable {name!r} of {' x '.join(map(str, found.shape or ())) or 1} values"
                refuse_large(path, COPIES * total, size, what)
    return passed_over


def _bytes_of(path: Path, data: Any, size: int) -> int:
    """Bytes in 64 bits of a dataset, or of a chunk that is larger."""
    # A chunk is unpacked whole, even if the dataset uses a corner of it.
    values, chunk = int(data.size or 0), math.prod(map(int, data.chunks or ()))
    if data.chunks:
        _refuse_packed(path, data, chunk * data.dtype.itemsize, size)
    return max(values, chunk) * max(8, int(data.dtype.itemsize))


def refuse_empty(path: Path, name: str, shape: tuple[int, ...], stored: int, parts: int) -> None:
    """
    Refuse a large array of which nearly nothing is stored: reading its fill value takes hours.

    Raises
    ------
    FormatError
        If fewer than a thousandth of its parts are there.
    """
    if stored * 1000 < parts:
        size = " x ".join(map(str, shape))
        raise FormatError(
            f"{path}: variable {name!r} announces {size} values, but only {stored} of its {parts} "
            "chunks are stored. Check that the file is complete, or export only the part that has "
            "data."
        )


def _refuse_packed(path: Path, data: Any, chunk: int, size: int) -> None:
    """Refuse chunks that unpack to more than a chunk has."""
    # filters in the order in which they pack; two of zlib multiply their ratios
    filters = data.id.get_create_plist()
    kinds = [filters.get_filter(k)[0] for k in range(filters.get_nfilters())]
    if kinds.count(DEFLATE) > 1:
        raise FormatError(
            f"{path}: {data.name!r} is compressed {kinds.count(DEFLATE)} times. Compress it "
            "once only."
        )

    # zlib packs by 1032 at most: what is stored bounds what comes out.
    if kinds[-1:] != [DEFLATE] or data.id.get_storage_size() * LARGEST_RATIO <= ALLOWANCE:
        return
    for k in range(data.id.get_num_chunks()):
        stored = data.id.get_chunk_info(k)
        if stored.filter_mask or stored.size * LARGEST_RATIO <= ALLOWANCE or stored.size > size:
            continue  # not compressed, too small to do harm, or beyond the end
        _, packed = data.id.read_direct_chunk(stored.chunk_offset)
        unpack = zlib.decompressobj()
        length = 0
        while packed and not unpack.eof and length <= chunk:
            length += len(unpack.decompress(packed, 1 << 24))
            packed = unpack.unconsumed_tail
        if length > chunk:
            raise damaged(
                f"{path}: a chunk of {data.name!r} unpacks to more than its {chunk} bytes"
            )
