"""Counts and tags of a binary Gmsh file, checked before meshio believes them.

meshio makes arrays as long as a file says that they are, and one as long as the largest tag of a
node: one spoiled byte asks for gigabytes. What a file announces has to be in it; the format
(Gmsh reference manual, MSH 2.2 and 4.1) lets tags be sparse, but not for nothing.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError

LARGEST_TAG = 10_000_000  # in files with fewer bytes than that
POINT = 24  # bytes: x, y, z


def refuse_wrong_counts(path: Path, data: bytes) -> None:
    """
    Refuse a binary Gmsh file with more nodes than bytes, or tags that no mesh of its size has.

    Parameters
    ----------
    path : pathlib.Path
        For the message.
    data : bytes
        Of the whole file; text is passed over, as its numbers are no longer than they look.

    Raises
    ------
    FormatError
    """
    head = re.match(rb"\s*\$MeshFormat\s+([24])\.\d+\s+1\s+([48])\s", data)
    start = re.search(rb"^\$Nodes[ \t\r]*\n", data, re.M)
    if head is None or start is None:
        return
    if head[1] == b"4":
        tags = _tags_of_blocks(path, data, start.end(), int(head[2]))
    else:
        tags = _tags_of_rows(path, data, start.end())
    limit = max(LARGEST_TAG, len(data))
    if len(tags) and int(tags.max()) > limit:
        raise FormatError(
            f"{path}: a node has the tag {int(tags.max())}, which is more than a mesh of "
            f"{len(tags)} nodes should need ({limit}). The file is damaged, or its nodes are to be "
            "numbered anew; export it again."
        )


def _tags_of_blocks(path: Path, data: bytes, at: int, size: int) -> np.ndarray:
    """Tags of the nodes of version 4: blocks of tags, then points."""
    word = f"<u{size}"
    _, n_node, *_ = _numbers(path, data, at, word, 4)
    _refuse_more(path, data, at, n_node, size + POINT)
    at += 4 * size
    found: list[np.ndarray] = [np.empty(0, dtype=np.uint64)]
    n_found = 0
    while n_found < n_node:
        (n,) = _numbers(path, data, at + 12, word, 1)
        at += 12 + size
        _refuse_more(path, data, at, n, size + POINT)
        found.append(np.frombuffer(data, word, n, at).astype(np.uint64))
        at += n * (size + POINT)
        n_found += n
    return np.concatenate(found)


def _tags_of_rows(path: Path, data: bytes, at: int) -> np.ndarray:
    """Tags of the nodes of version 2: rows of a tag and a point, their number as text."""
    end = data.find(b"\n", at)
    text = data[at:end].strip()
    n_node = int(text) if text.isdigit() else 0
    row = np.dtype([("tag", "<i4"), ("point", "<f8", 3)])
    _refuse_more(path, data, end + 1, n_node, row.itemsize)
    return np.frombuffer(data, row, n_node, end + 1)["tag"].astype(np.int64)


def _numbers(path: Path, data: bytes, at: int, word: str, n: int) -> list[int]:
    """Some numbers at a place of the file."""
    _refuse_more(path, data, at, n, np.dtype(word).itemsize)
    return [int(value) for value in np.frombuffer(data, word, n, at)]


def _refuse_more(path: Path, data: bytes, at: int, n: int, size: int) -> None:
    """Refuse to read `n` things of `size` bytes where the file does not have them."""
    left = max(len(data) - at, 0)
    if n * size > left:
        raise FormatError(
            f"{path}, byte {at}: {n} entries are announced in section $Nodes, and the file has "
            f"room for {left // size}. It is damaged or cut short; export it again."
        )
