"""Run independent tasks in threads, with results in order; kernels release the lock of Python."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

from geosurf.errors import InputError


def n_threads() -> int:
    """Number of threads: GEOSURF_THREADS, or the cores that this process may use.

    Raises
    ------
    InputError
        If GEOSURF_THREADS is not a whole number above 0.
    """
    said = os.environ.get("GEOSURF_THREADS")
    if said is None:
        cores = getattr(os, "sched_getaffinity", None)
        return len(cores(0)) if cores else os.cpu_count() or 1
    if not said.isdecimal() or int(said) < 1:
        raise InputError(f"GEOSURF_THREADS is {said!r}; give a whole number above 0.")
    return int(said)


def map_threads(work: Callable[..., Any], rows: Sequence[tuple], worth: bool = True) -> list[Any]:
    """Return ``[work(*row) for row in rows]``, on several threads if that is worth it.

    Examples
    --------
    >>> map_threads(divmod, [(7, 2), (9, 4)])
    [(3, 1), (2, 1)]
    """
    n = min(n_threads(), len(rows)) if worth else 1
    if n <= 1:
        return [work(*row) for row in rows]
    from concurrent.futures import ThreadPoolExecutor  # a tenth of a short process's own imports

    with ThreadPoolExecutor(n) as pool:
        return list(pool.map(lambda row: work(*row), rows))
