"""``python -m benchmarks.stress``: test the engine on difficult cases, or repeat one of them."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.stress.stress import CASES, replay, run_stress


def main(argv: Sequence[str] | None = None) -> int:
    """Run the engine on difficult cases; 1 if any result is wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.stress",
        description="Test the engine on difficult cases, judged in exact arithmetic.",
    )
    parser.add_argument("--cases", type=int, default=CASES, help="number of cases per family")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random cases")
    parser.add_argument(
        "--family", action="append", metavar="NAME", help="test only this family; can be repeated"
    )
    parser.add_argument("-o", "--out", help="output file (.json) for the table and the failures")
    parser.add_argument("--replay", metavar="FILE", help="repeat one failed case (.npz)")
    options = parser.parse_args(argv)

    # the file has the seed and the surfaces: the case is the same on every machine
    if options.replay:
        case, outcome = replay(options.replay)
        print(f"{case.family} {case.number}, seed {case.seed}: {len(outcome.wrong)} wrong")
        for sentence in (*outcome.wrong, *filter(None, [outcome.refused])):
            print(f"  {sentence}")
        return int(bool(outcome.wrong))

    keep = Path(options.out or "stress.json").parent / "stress_failures"
    start = time.perf_counter()
    rows = run_stress(options.cases, options.seed, options.family, keep=keep, progress=print)
    seconds = time.perf_counter() - start

    count, wrong, refused = (
        sum(getattr(row, key) for row in rows) for key in ("cases", "wrong", "refused")
    )
    print(f"{count} cases, {wrong} wrong, {refused} refused, {seconds:.1f} s, seed {options.seed}.")
    if options.out:
        table = {"seed": options.seed, "cases": options.cases, "families": [*map(asdict, rows)]}
        Path(options.out).parent.mkdir(parents=True, exist_ok=True)
        Path(options.out).write_text(f"{json.dumps(table, indent=1)}\n", encoding="utf-8")

    # three of each family are enough to start with; the file has them all
    for row in rows:
        for failure in row.failures[:3]:
            print(f"{row.family} {failure['number']}: {failure['wrong'][0]}", file=sys.stderr)
            print(f"  python -m benchmarks.stress --replay {failure['file']}", file=sys.stderr)
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
