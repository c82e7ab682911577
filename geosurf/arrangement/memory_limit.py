"""Check that pairs of triangles fit into memory, before they are stored.

Most scenes have a few pairs for each triangle near a curve. Where thousands of triangles coincide,
or all pass through one point, the number of pairs is their square. Then an error with numbers comes
before the system has to end the process.
"""

from __future__ import annotations

from geosurf.conventions.memory import free_memory
from geosurf.errors import InputError

PAIR = 80  # bytes of a candidate pair, over all steps
CONTACT = 400  # bytes of two triangles that meet
IN_PLANE = 1200  # bytes of two that lie in one plane
_SMALL = 256 << 20  # bytes, below which there is no check


class TooManyPairs(Exception):
    """More pairs than fit into memory; the caller makes an `InputError` with names of surfaces.

    Attributes
    ----------
    n : int
        Number of pairs.
    """

    def __init__(self, n: int) -> None:
        super().__init__(n)
        self.n = n


def check_pairs(n: int) -> None:
    """Raise `TooManyPairs` if `n` candidate pairs need more memory than is free."""
    if lack_of_room(n * PAIR) is not None:
        raise TooManyPairs(n)


def refusal(
    n: int,
    names: list[str],
    size: int = PAIR,
    what: str = "pairs of triangles that may meet",
) -> InputError:
    """Return the error for `n` pairs of `size` bytes each, between named surfaces.

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
    have = "" if free is None else f" and {gigabytes(free)} are free"
    count = f"{n:,}".replace(",", " ")
    return InputError(
        f"{who} {count} {what}, which need {gigabytes(n * size)} of memory{have}. "
        "Remove duplicate surfaces, coarsen the others (triangulate_horizon(..., "
        "tolerance=...)), or use a larger machine.",
        surfaces=named,
    )


def lack_of_room(needed: int) -> int | None:
    """Return the bytes of free memory if they are fewer than needed, else None."""
    if needed < _SMALL:
        return None
    free = free_memory()
    return free if free is not None and free < needed else None


def gigabytes(n: int) -> str:
    """A number of bytes in GB.

    Examples
    --------
    >>> gigabytes(5_200_000_000), gigabytes(12_300_000_000)
    ('5.2 GB', '12 GB')
    """
    return f"{n / 1e9:,.0f} GB".replace(",", " ") if n >= 1e10 else f"{n / 1e9:.1f} GB"
