"""The one way from a path to its bytes: regular files only, and memory that a file may ask for.

A file of some kilobytes can announce gigabytes: chunks of HDF5, compressed blocks, counts in a
header. Readers compare what is announced with `limit_of` the file before they unpack it. What
libraries raise for damaged files becomes one error here.

A dataset of HDF5 may declare any shape (a fill value stands for what is not stored), chunks larger
than itself, chunks that unpack to more than a chunk, texts that are referred to a million times,
and data in other files. Such arrays are refused, or ignored if they are not numeric.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import re
import stat
import sys
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from geosurf.conventions.machine import free_memory
from geosurf.errors import FormatError, GeosurfError, InputError
from geosurf.lazy import h5py

ALLOWANCE = 256 << 20  # bytes of memory that any file may ask for
MULTIPLE = 64  # bytes of memory for each byte of a file
BUDGET = "GEOSURF_READ_MEMORY"  # the word that sets another limit
SCALES = {"": 0, "K": 10, "M": 20, "G": 30, "T": 40}
KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def damaged(words: str) -> FormatError:
    """
    Return the error of a file that does not follow its format: what and where, and a remedy.

    Examples
    --------
    >>> print(damaged("top.irap, line 7: found 'x', expected a number"))
    top.irap, line 7: found 'x', expected a number. Correct that line or export the file again.
    """
    if ", line " in words:
        return FormatError(f"{words}. Correct that line or export the file again.")
    return FormatError(f"{words}. The file is damaged or incomplete; export it again.")


def unreadable(words: str) -> FormatError:
    """Return the error of a file that a library does not read: it need not be damaged."""
    how = "The file is damaged, or has parts that are not read; export it in another format."
    return FormatError(f"{words}. {how}")


@contextlib.contextmanager
def reading_with(
    path: Path, library: str, opened_as: str = "", printed: io.StringIO | None = None
) -> Iterator[None]:
    """Make one error of what a library raises for a damaged file: anything, or the end of Python.

    `opened_as` is the name by which the library opened the file; messages have its path. What was
    `printed` meanwhile says more than the error.
    """
    try:
        yield
    except GeosurfError:
        raise
    except (Exception, SystemExit) as error:
        reason = " ".join((printed.getvalue() if printed else "").split())
        reason = reason or f"{type(error).__name__}: {error}"
        reason = reason.replace(opened_as or str(path), path.name)
        raise unreadable(f"{path}: {library} cannot read it ({reason[:300]})") from error


def is_zarr(path: str | Path) -> bool:
    """Return whether a path is a folder with a Zarr group.

    Examples
    --------
    >>> is_zarr("/")
    False
    """
    with contextlib.suppress(OSError):  # the name is too long for a file
        return any((Path(path) / mark).is_file() for mark in ("zarr.json", ".zgroup", ".zmetadata"))
    return False


def size_of_store(path: Path) -> int:
    """Return the bytes of all files in a folder."""
    return sum(
        (Path(folder) / name).stat().st_size for folder, _, names in os.walk(path) for name in names
    )


@contextlib.contextmanager
def opened(path: Path) -> Iterator[tuple[BinaryIO, int]]:
    """
    Open a regular file, whatever the path becomes meanwhile.

    Parameters
    ----------
    path : pathlib.Path

    Yields
    ------
    (binary file, int)
        Open for reading, and its size in bytes.

    Raises
    ------
    InputError
        If it cannot be opened, or is a pipe, a device or a folder, which are never waited for.
    """
    # Without O_NONBLOCK a named pipe would wait for a writer for ever.
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, flags | getattr(os, "O_NOCTTY", 0))
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error

    # the open file is asked, not the path, which another process may change in between
    kept = os.fstat(handle)
    if not stat.S_ISREG(kept.st_mode):
        os.close(handle)
        kind = next((word for is_it, word in KINDS if is_it(kept.st_mode)), "something else")
        remedy = (
            "Give the path of a file in it, or of a Zarr store, which has a zarr.json or .zgroup."
            if stat.S_ISDIR(kept.st_mode)
            else "Copy the data to a file and read that."
        )
        raise InputError(f"{path}: this is {kind}, expected a regular file. {remedy}")
    with os.fdopen(handle, "rb") as file:
        yield file, kept.st_size


def read_bytes(path: Path) -> bytes:
    """Return the content of a regular file, or the reason why there is none."""
    # One byte more than expected shows that the file has grown meanwhile.
    with opened(path) as (file, size):
        refuse_beyond_memory(path, size)
        data = read_some(path, file, size + 1)
    check_size(path, size, len(data))
    return data


def refuse_beyond_memory(path: Path, size: int) -> None:
    """Refuse a file that is larger than the memory that is free."""
    # a machine with little free memory still reads what every file may ask for
    free = free_memory()
    if free is not None and size > max(free, ALLOWANCE):
        raise InputError(
            f"{path}: the file has {_megabytes(size)}, but only {_megabytes(free)} of "
            "memory are free. Split the file, or read it on a larger machine."
        )


def read_some(path: Path, file: BinaryIO, n: int) -> bytes:
    """Return the next `n` bytes of an open file, or fewer at its end."""
    try:
        return file.read(n)
    except OSError as error:
        raise _unreadable(path, error) from error


def check_size(path: Path, size: int, n_read: int) -> None:
    """Refuse a file that changed while it was read, or is empty."""
    if n_read != size:
        raise InputError(
            f"{path}: the file grew from {size} to {n_read} bytes or more while geosurf "
            "read it. Read it again when it is complete."
        )
    if not size:
        raise damaged(f"{path}: the file is empty (0 bytes)")


def same_file(path: Path, file: BinaryIO) -> str:
    """Return a name by which a library opens the very file that is open here.

    On Linux that is its descriptor; elsewhere the path, which others could exchange meanwhile.
    """
    name = f"/proc/self/fd/{file.fileno()}"
    return name if sys.platform == "linux" and Path(name).exists() else str(path)


def limit_of(size: int) -> int:
    """
    Return how many bytes of memory the reader of a file of `size` bytes may take.

    Raises
    ------
    InputError
        If the environment variable GEOSURF_READ_MEMORY is not a size.

    Examples
    --------
    >>> limit_of(1000) == 256 * 2**20, limit_of(10**8) == 64 * 10**8
    (True, True)
    """
    # the limit grows with the file, so that large files need no setting
    text = os.environ.get(BUDGET, "").strip()
    if not text:
        return max(ALLOWANCE, MULTIPLE * size)
    match = re.fullmatch(r"([0-9]{1,15})\s*([KMGT]?)(?:i?B)?", text, re.IGNORECASE)
    if match is None:
        raise InputError(
            f"the environment variable {BUDGET} is {text!r}, expected a size such as {BUDGET}=4GB."
        )
    return int(match[1]) << SCALES[match[2].upper()]


def refuse_large(path: Path, needed: int, size: int, what: str) -> None:
    """
    Refuse what takes more memory than a file of that size may ask for, or than is free.

    Parameters
    ----------
    path : pathlib.Path
    needed : int
        Bytes of memory that the reader would take.
    size : int
        Bytes of the file.
    what : str
        What announces them: "variable 'z' of 20000 x 20000 values".

    Raises
    ------
    FormatError
    """
    limit = limit_of(size)
    if needed > limit:
        # whole gigabytes, rounded up: a value that the user can type
        more = max(1, -(-needed >> 30))
        raise FormatError(
            f"{path}: {what} needs {_megabytes(needed)} of memory, but the limit for a file of "
            f"{size} bytes is {_megabytes(limit)}. If the file is correct, set the environment "
            f"variable {BUDGET}={more}GB."
        )

    # The limit protects from small files that announce much; free memory, from large ones.
    free = free_memory() if needed > ALLOWANCE else None
    if free is not None and needed > free:
        raise FormatError(
            f"{path}: {what} needs {_megabytes(needed)} of memory, but only {_megabytes(free)} "
            "are free. Thin out the data, or read them on a larger machine."
        )


def _unreadable(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return InputError(f"{path}: cannot be read ({reason}). Check the path.")


def _megabytes(n: int) -> str:
    return f"{n / 2**20:,.0f} MB".replace(",", " ")


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
            node = group.get(name)
            if node is None or (node.id in seen):  # a link to nothing, or a circle
                continue
            seen.add(node.id)
            if isinstance(node, h5py.Group):
                todo.append(node)
            elif isinstance(node, h5py.Dataset):
                # texts and references are left out: a few bytes of them may stand for gigabytes
                if node.size is not None and node.size > 1 and node.dtype.kind not in "fiub":
                    passed_over.append(str(name))
                    continue
                if node.is_virtual or node.external:
                    raise FormatError(
                        f"{path}: the values of {node.name!r} are in other files. Copy them into "
                        "one file."
                    )
                if (node.size or 0) > stays:
                    stored, parts = int(node.id.get_storage_size() > 0), 1
                    if node.chunks:
                        sides = zip(node.shape, node.chunks, strict=True)
                        stored = int(node.id.get_num_chunks())
                        parts = math.prod(-(-n // step) for n, step in sides)
                    refuse_empty(path, str(name), node.shape, stored, parts)
                    continue
                # Bytes of all variables together, since xarray may load each of them.
                total += _bytes_of(path, node, size)
                what = f"variable {name!r} of {' x '.join(map(str, node.shape or ())) or 1} values"
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
