"""Count wrong signs over many cases: ``python -m tests.kernels.million [cases] [seconds]``.

With NUMBA_DISABLE_JIT=1 the same kernels run as plain Python, bounds and all. It stops after so
many seconds, if they are given; ends with 1 if a sign is wrong.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from tests.kernels.families import FAMILIES, PREDICATES, kernel_signs, share, true_signs, tuples

CHUNK = 20_000


def count(total: int, seconds: float = float("inf"), seed: int = 1):
    """Rows (predicate, family, cases, zeros, wrong)."""
    start = time.monotonic()
    chunk = min(CHUNK, share(total))
    done: dict = {}
    for step in range(-(-share(total) // chunk)):
        for name, (corners, dimension) in PREDICATES.items():
            for family in FAMILIES:
                if time.monotonic() - start > seconds:
                    return done
                points = tuples(family, chunk, corners, dimension, seed + step)
                true, found = true_signs(name, points), kernel_signs(name, points)
                row = done.setdefault((name, family), np.zeros(3, dtype=np.int64))
                row += len(points), int((true == 0).sum()), int((true != found).sum())
    return done


def main(arguments: list[str]) -> int:
    total = int(arguments[0]) if arguments else 1_000_000
    seconds = float(arguments[1]) if len(arguments) > 1 else float("inf")
    start = time.monotonic()
    done = count(total, seconds)
    for (name, family), (cases, zeros, bad) in done.items():
        say(f"{name:9} {family:10} {cases:8} cases {zeros:8} zero {bad:4} wrong")
    cases, zeros, wrong = sum(done.values())
    say(f"{cases} cases, {zeros} zero, {wrong} wrong, {time.monotonic() - start:.0f} s")
    return int(wrong > 0)


def say(line: str) -> None:
    sys.stdout.write(line + "\n")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
