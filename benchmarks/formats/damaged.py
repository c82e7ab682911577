"""Files that are damaged or only look odd: each reads as before, or is refused."""

from __future__ import annotations

import struct
import warnings
import zlib
from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.formats.round_trips import Row, read_back
from benchmarks.formats.subjects import difference
from geosurf.errors import GeosurfError

# a cut at the end of a line leaves fewer points or triangles, and no count shows it
WITHOUT_COUNTS = (".obj", ".xyz", ".poi", ".csv", ".pol", ".dat")
CUT, MIDDLE, LETTER = "cut at the end of a line", "cut in the middle", "letter in a number"
ENCODED = (".vtp", ".vtu", ".glb", ".gltf")  # a letter among others that encode bytes is valid
# what Python and its libraries raise on bytes that they do not expect
RAISED = (
    *(ArithmeticError, AssertionError, AttributeError, EOFError, ImportError, LookupError),
    *(MemoryError, OSError, RuntimeError, TypeError, ValueError, struct.error, zlib.error),
)


def _with_letter(data: bytes) -> bytes:
    """A digit in the middle becomes a letter."""
    at = next((k for k in range(len(data) // 2, len(data)) if data[k : k + 1].isdigit()), None)
    return b"" if at is None else data[:at] + b"x" + data[at + 1 :]


def _cut_at_line(data: bytes) -> bytes:
    end = data.find(b"\n", len(data) // 2)
    return b"" if end < 0 else data[: end + 1]


CHANGES: dict[str, Callable[[bytes], bytes]] = {
    "line ends of Windows": lambda data: data.replace(b"\n", b"\r\n"),
    "byte order mark": lambda data: b"\xef\xbb\xbf" + data,
    "blank line at the end": lambda data: data + b"\n",
    MIDDLE: lambda data: data[: len(data) // 2 + 1],
    CUT: _cut_at_line,
    LETTER: _with_letter,
    "zero bytes": lambda data: data[: len(data) // 2] + b"\0\0\0" + data[len(data) // 2 :],
    "UTF-16": lambda data: data.decode("latin-1").encode("utf-16"),
    "nothing": lambda data: b"",
}
ONLY_TEXT = (*list(CHANGES)[:3], CUT, LETTER)


def damaged_rows(rows: Sequence[Row]) -> list[tuple[str, str, int, int, list[str]]]:
    """Kind, suffix, how many read as before and were refused, and what differs."""
    found = []
    for row in rows:
        if not row.read_with or not row.files:
            continue
        answers = [_answer(row, name, change) for name, change in CHANGES.items()]
        count = answers.count
        wrong = [one for one in answers if one not in ("", "before", "refused")]
        found.append((row.kind, row.suffix, count("before"), count("refused"), wrong))
    return found


def _answer(row: Row, name: str, change: Callable[[bytes], bytes]) -> str:
    """``"before"``, ``"refused"``, nothing where a change does not apply, or what is wrong."""
    path = row.files[0]
    data = path.read_bytes()
    if (b"\0" in data and name in ONLY_TEXT) or (name == LETTER and row.suffix in ENCODED):
        return ""
    changed = change(data)
    if changed == data:
        return ""
    target = path.with_name(f"damaged_{path.name}")
    target.write_bytes(changed)
    side = path.with_suffix(".h5")  # of RESQML
    if side.exists():
        target.with_suffix(".h5").write_bytes(side.read_bytes())
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            before = read_back(row.read_with, path, row.kind)
            found = read_back(row.read_with, target, row.kind)
    except GeosurfError as error:
        return "refused" if len(str(error)) > 30 else f"{name}: refused as {error}"
    except RAISED as error:  # whatever a reader raises besides is looked for
        return f"{name}: {type(error).__name__}: {error}"
    finally:
        target.unlink()
    if before.shape == found.shape and difference(before, found) == 0.0:
        return "before"
    if name in (CUT, MIDDLE) and row.suffix in WITHOUT_COUNTS and len(found) < len(before):
        return "" if np.isin(found, before).all() else f"{name}: other points"
    return f"{name}: reads as {len(found)} points, before {len(before)}"


__all__ = ["damaged_rows"]
