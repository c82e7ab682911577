"""Counts and tags of a Gmsh file, checked before meshio makes room for them.

meshio makes arrays as long as a file announces, and one as long as the largest tag of a
node: one spoiled byte asks for gigabytes. What a file announces has to be in it; the format
(Gmsh reference manual, MSH 2.2 and 4.1) allows sparse tags, which must not be wasteful.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError

LARGEST_TAG = 10_000_000  # in files with fewer bytes than that
POINT = 24  # bytes: x, y, z
ROW = np.dtype([("tag", "<i4"), ("point", "<f8", 3)])


def refuse_wrong_counts(path: Path, data: bytes) -> None:
    """
    Refuse a Gmsh file with more nodes than bytes, or tags that no mesh of its size has.

    Parameters
    ----------
    path : pathlib.Path
        For the message.
    data : bytes
        Of the whole file, binary or text.

    Raises
    ------
    FormatError
    """
    _refuse_tag_lines(path, data)

    # version, ascii (0) or binary (1), and bytes of a whole number
    head = re.match(rb"\s*\$MeshFormat\s+([24])\.(\d+)\s+([01])\s+([48])\s", data)
    start = re.search(rb"^\$Nodes[ \t\r]*\n", data, re.M)
    if head is None or start is None:
        return

    # Each layout puts node tags elsewhere: text, blocks of rows (4.0), blocks (4.x) or rows (2.x).
    if head[3] == b"0":
        end = data.find(b"$EndNodes", start.end())
        words = data[start.end() : end if end >= 0 else None].split()
        tags = _tags_of_words(path, words, (head[1] + head[2][:1]).decode())
    elif head[1] + head[2] == b"40":
        tags = _tags_of_blocks_of_rows(path, data, start.end())
    elif head[1] == b"4":
        tags = _tags_of_blocks(path, data, start.end(), int(head[4]))
    else:
        tags = _tags_of_rows(path, data, start.end())

    # meshio allocates up to the largest tag: a sparse one in a small file is damage
    limit = max(LARGEST_TAG, len(data))
    if len(tags) and int(tags.max()) > limit:
        raise FormatError(
            f"{path}: a node has the tag {int(tags.max())}, but a mesh of {len(tags)} nodes "
            f"may use tags up to {limit} only. The file is damaged, or its nodes need new "
            "numbers; export it again."
        )


def _refuse_tag_lines(path: Path, data: bytes) -> None:
    """Refuse more lines of strings, numbers and counts before data than there are in the file."""
    for match in re.finditer(rb"\$((?:Node|Element|ElementNode)Data)[^\n]*\n", data):
        # Three lists follow each other: strings, reals, integers, each after a line with its
        # length.
        at = match.end()
        for _ in range(3):
            end = data.find(b"\n", at)

            # a length, then as many lines; what is left bounds how many there may be
            text = data[at : max(end, at)].strip()
            try:
                n = int(text)  # as meshio takes it: with signs and underscores, too
            except ValueError:
                n = 0
            left = data.count(b"\n", at)
            if n > left:
                raise FormatError(
                    f"{path}: {n} lines are announced in section ${match[1].decode()}, and the "
                    f"file has {left} left. It is damaged or truncated; export it again."
                )
            for _ in range(max(n, 0) + 1):
                at = data.find(b"\n", at) + 1 or len(data)


def _tags_of_words(path: Path, words: list[bytes], version: str) -> np.ndarray:
    """Tags of the nodes of a text: in rows, in blocks of rows (4.0), or before the points (4.1)."""
    found: list[bytes] = []
    if version[0] == "2":
        found = words[1::4]
    else:
        # version 4: the section's counts, then blocks of four words and their nodes
        at = 4 if version == "41" else 2
        while at + 4 <= len(words):
            n = _count(path, words[at + 3])
            if 4 * n > len(words) - at - 4:
                raise FormatError(
                    f"{path}: {n} nodes are announced in section $Nodes, and it has "
                    f"{len(words) - at - 4} numbers left. It is damaged or truncated; export "
                    "it again."
                )
            found += (
                words[at + 4 : at + 4 + n]
                if version == "41"
                else words[at + 4 : at + 4 + 4 * n : 4]
            )
            at += 4 + 4 * n

        # meshio makes an array of the section's own count, however many nodes follow
        if len(words) > 1 and _count(path, words[1]) != len(found):
            raise FormatError(
                f"{path}: {int(words[1])} nodes are announced in section $Nodes, and its blocks "
                f"have {len(found)}. It is damaged or truncated; export it again."
            )
    return np.array([_count(path, word) for word in found], dtype=np.int64)


def _count(path: Path, word: bytes) -> int:
    """A number of things or a tag, as a text."""
    if not re.fullmatch(rb"[0-9]{1,18}", word):
        raise FormatError(
            f"{path}: found {word[:40].decode('latin-1')!r} in section $Nodes, expected a count or "
            "a tag. The file is damaged; export it again."
        )
    return int(word)


def _tags_of_blocks(path: Path, data: bytes, at: int, size: int) -> np.ndarray:
    """Tags of the nodes of version 4: blocks of tags, then points."""
    word = f"<u{size}"

    # Four words open the section; the second one is the number of nodes.
    _, n_node, *_ = _numbers(path, data, at, word, 4)

    # all announced nodes have to fit into what is left of the file
    _refuse_more(path, data, at, n_node, size + POINT)
    at += 4 * size

    found: list[np.ndarray] = [np.empty(0, dtype=np.uint64)]
    n_found = 0
    while n_found < n_node:
        # Entity dimension, entity tag, a flag (three int32), then the number of nodes of the block.
        (n,) = _numbers(path, data, at + 12, word, 1)
        at += 12 + size
        _refuse_more(path, data, at, n, size + POINT)
        found.append(np.frombuffer(data, word, n, at).astype(np.uint64))
        # Tags first, then as many points.
        at += n * (size + POINT)
        n_found += n
    return np.concatenate(found)


def _tags_of_blocks_of_rows(path: Path, data: bytes, at: int) -> np.ndarray:
    """Tags of the nodes of version 4.0: blocks of rows."""
    # blocks and nodes in the section; each block: three int32, then how many rows
    _, n_node = _numbers(path, data, at, "<u8", 2)
    _refuse_more(path, data, at, n_node, ROW.itemsize)
    at += 16
    found: list[np.ndarray] = [np.empty(0, dtype=np.int64)]
    n_found = 0
    while n_found < n_node:
        (n,) = _numbers(path, data, at + 12, "<u8", 1)
        at += 20
        _refuse_more(path, data, at, n, ROW.itemsize)
        found.append(np.frombuffer(data, ROW, n, at)["tag"].astype(np.int64))
        at += n * ROW.itemsize
        n_found += n
    return np.concatenate(found)


def _tags_of_rows(path: Path, data: bytes, at: int) -> np.ndarray:
    """Tags of the nodes of version 2: rows of a tag and a point, their number as text."""
    # the number of nodes as text, then rows without any separator
    end = data.find(b"\n", at)
    text = data[at:end].strip()
    n_node = int(text) if text.isdigit() else 0
    _refuse_more(path, data, end + 1, n_node, ROW.itemsize)
    return np.frombuffer(data, ROW, n_node, end + 1)["tag"].astype(np.int64)


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
            f"room for {left // size}. It is damaged or truncated; export it again."
        )
