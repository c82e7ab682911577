"""The command ``stress``: test the engine on difficult cases, or repeat one of them."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import asdict
from pathlib import Path

from geosurf.cli.answer import Answer
from geosurf.cli.exit_codes import OUR_FAULT
from geosurf.cli.live import live_progress


def stress_command(options: argparse.Namespace) -> Answer:
    """Run the engine on difficult cases and compare its results with exact arithmetic."""
    from geosurf.prove.stress import replay, run_stress, write_json

    # the file has the seed and the surfaces: the case is the same on every machine
    if options.replay:
        case, outcome = replay(options.replay)
        head = f"{case.family} {case.number}, seed {case.seed}: {len(outcome.wrong)} wrong"
        sentences = (*outcome.wrong, *filter(None, [outcome.refused]))
        data = {"family": case.family, "number": case.number, "seed": case.seed}
        return Answer(
            data | {"wrong": outcome.wrong, "refused": outcome.refused},
            "\n  ".join([head, *sentences]),
            OUR_FAULT if outcome.wrong else 0,
        )

    # failed cases are stored as files, so that --replay can repeat them
    keep = Path(options.out).parent / "stress_failures" if options.out else "stress_failures"
    start = time.perf_counter()
    rows = run_stress(
        options.cases,
        options.seed,
        options.family,
        keep=keep,
        progress=live_progress(options, steps=True),
    )

    # one line for all families, then each failure with the command that repeats it
    count, wrong, refused = (
        sum(getattr(r, k) for r in rows) for k in ("cases", "wrong", "refused")
    )
    seconds = time.perf_counter() - start
    lines = [
        f"{count} cases, {wrong} wrong, {refused} refused, {seconds:.1f} s, seed {options.seed}."
    ]
    if options.out:
        lines.append(str(write_json(rows, options.out, seed=options.seed, cases=options.cases)))

    # three of each family are enough to start with; the file has them all
    for row in rows:
        for failure in row.failures[:3]:
            print(f"{row.family} {failure['number']}: {failure['wrong'][0]}", file=sys.stderr)
            print(f"  geosurf stress --replay {failure['file']}", file=sys.stderr)
    data = {"cases": count, "wrong": wrong, "refused": refused, "seconds": seconds}
    return Answer(
        data | {"families": [asdict(row) for row in rows]},
        "\n".join(lines),
        OUR_FAULT if wrong else 0,
    )
