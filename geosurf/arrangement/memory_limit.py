"""Whether pairs of triangles fit into memory, asked when they are counted and before they are kept.

Nearly all scenes have a few pairs for each triangle near a curve. Where thousands of triangles
cover one another, or all pass one place, pairs are as many as their square: then an error with
numbers comes before the system has to end the process.
"""

from __future__ import annotations

import re
from pathlib import Path

from geosurf.errors import InputError

PAIR = 80  # bytes of a candidate pair, through all steps in which it is there
CONTACT = 400  # bytes of two triangles that meet
IN_PLANE = 1200  # bytes of two that lie in one plane
_SMALL = 256 << 20  # bytes, below which nothing is asked


class TooManyPairs(Exception):
    """More pairs than fit into memory; becomes an `InputError` where the surfaces are known.

    Attributes
    ----------
    n : int
        Number of pairs.
    """

    def __init__(self, n: int) -> None:
        super().__init__(n)
        self.n = n


def check_pairs(n: int) -> None:
    """Raise `TooManyPairs` if so many candidate pairs need more memory than is free."""
    if lack_of_room(n * PAIR) is not None:
        raise TooManyPairs(n)


def refusal(
    n: int,
    names: list[str],
    size: int = PAIR,
    what: str = "pairs of triangles that may meet",
) -> InputError:
    """The error for n pairs, of so many bytes each, of some surfaces.

    Examples
    --------
    >>> print(refusal(5_000_000_000, ["Salt", "Salt"]))  # doctest: +ELLIPSIS
    surface 'Salt' has 5 000 000 000 pairs of triangles that may meet, which need 400 GB of ...
    """
    named = sorted(set(names))
    if len(named) == 1:
        who = f"surface {named[0]!r} has"
    elif len(named) == 2:
        who = f"surfaces {named[0]!r} and {named[1]!r} have"
    else:
        who = f"{len(named)} surfaces have"
    free = free_memory()
    have = "" if free is None else f" and {_gigabytes(free)} are free"
    count = f"{n:,}".replace(",", " ")
    return InputError(
        f"{who} {count} {what}, which need {_gigabytes(n * size)} of memory{have}. "
        "Remove duplicate surfaces, coarsen the others (triangulate_horizon(..., "
        "tolerance=...)), or use a larger machine.",
        surfaces=named,
    )


def lack_of_room(needed: int) -> int | None:
    """Bytes of memory that are free, if they are fewer than are needed, else None."""
    if needed < _SMALL:
        return None
    free = free_memory()
    return free if free is not None and free < needed else None


def free_memory() -> int | None:
    """Bytes of memory that this process may still take, None where it is unknown."""
    found = [_of_system(), _of_group(), _of_process()]
    known = [free for free in found if free is not None]
    return max(0, min(known)) if known else None


def _of_system() -> int | None:
    """What the system has."""
    try:
        text = Path("/proc/meminfo").read_bytes()
    except OSError:
        return None
    match = re.search(rb"^MemAvailable:\s+(\d+) kB", text, re.MULTILINE)
    return int(match[1]) << 10 if match else None


def _of_group() -> int | None:
    """What a container leaves."""
    folder = Path("/sys/fs/cgroup")
    try:
        most, used = (
            (folder / name).read_text().strip() for name in ("memory.max", "memory.current")
        )
    except OSError:
        return None
    return int(most) - int(used) if most.isdigit() and used.isdigit() else None


def _of_process() -> int | None:
    """What a limit of the process leaves (``ulimit -v``)."""
    try:
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        if most == resource.RLIM_INFINITY:
            return None
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return most - pages * resource.getpagesize()
    except (ImportError, OSError):
        return None


def _gigabytes(n: int) -> str:
    return f"{n / 1e9:,.0f} GB".replace(",", " ") if n >= 1e10 else f"{n / 1e9:.1f} GB"
