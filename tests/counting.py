"""Count what becomes of many cases, each known by its number.

Programs of the tests, such as ``python -m tests.rebuild.many [cases] [seconds] [first]``, hand
their cases to `count`.
"""

from __future__ import annotations

import faulthandler
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable

import geosurf as gs

LIMIT = 300  # seconds of a case: then its stack is printed, and the run ends


def count(
    case: Callable[[int], str | tuple[str, str]],
    *,
    cases: int = 10_000,
    refused: Callable[[Exception], bool] = lambda error: False,
    most_refused: float = 1.0,
) -> int:
    """Run cases by number, a word and perhaps a reason each; 1 if one is wrong.

    Any warning but our own, and any error, is wrong, but for errors that are `refused`; so are
    more than a share of `most_refused`.
    """
    given = [float(word) for word in sys.argv[1:4]]
    total, seconds, first = *given, *(cases, float("inf"), 0)[len(given) :]
    start, done = time.monotonic(), Counter()
    warnings.simplefilter("error")
    warnings.simplefilter("ignore", gs.GeosurfWarning)
    for seed in range(int(first), int(first + total)):
        if time.monotonic() - start > seconds:
            break
        faulthandler.dump_traceback_later(LIMIT, exit=True)
        try:
            told = case(seed)
        except Exception as error:  # whatever it is, it is counted
            told = "refused" if refused(error) else "wrong", f"{type(error).__name__}: {error}"
        word, why = (told, "") if isinstance(told, str) else told
        done[word] += 1
        if why and word != "refused":
            sys.stdout.write(f"case {seed}: {' '.join(why.split())[:300]}\n")
            sys.stdout.flush()
    faulthandler.cancel_dump_traceback_later()
    counts = ", ".join(f"{n} {word}" for word, n in sorted(done.items()))
    sys.stdout.write(f"{done.total()} cases: {counts}; {time.monotonic() - start:.0f} s\n")
    return int(done["wrong"] > 0 or done["refused"] > most_refused * done.total())
