"""Tearing on fields and on random networks: ``python -m benchmarks.tears fields|networks``.

    python -m benchmarks.tears networks --count 100
    python -m benchmarks.tears fields --field "export grids" --trim auto 2

Writes Markdown to stdout for docs/validation/tears.md, and progress to stderr. Fields are read from
the folder in GEOSURF_SHARED; those that are absent are left out with a reason.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

from benchmarks.torn_fields import FIELDS, PREPARATIONS, TRIMS, fields_table, run_fields
from benchmarks.torn_networks import networks_table, run_networks


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run one of the two and print its tables.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int
        1 if anything crashed, otherwise 0.
    """
    options = build_parser().parse_args(argv)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # each sheet's report has them
        if options.what == "networks":
            found = run_networks(options.count, options.seed, options.only)
            text = networks_table(found)
            crashed = any(one.crashed for one in found)
        else:
            rows = run_fields(options.field, options.sticks, options.trim, options.results)
            text = fields_table(rows)
            crashed = any(row.crashed for row in rows)
    sys.stdout.write(f"{text}\n")
    return int(crashed)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all options."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tears", description="Tear horizons")
    parts = parser.add_subparsers(dest="what", required=True)
    add = parts.add_parser("networks", help="random networks with known truth").add_argument
    add("--count", type=int, default=400)
    add("--seed", type=int, default=1)
    add("--only", type=int, nargs="+", metavar="NUMBER", help="these networks only")
    add = parts.add_parser("fields", help="fields, by preparation of their faults").add_argument
    add("--field", nargs="+", choices=FIELDS, default=list(FIELDS))
    add("--sticks", nargs="+", choices=PREPARATIONS, default=list(PREPARATIONS))
    add("--trim", nargs="+", type=_trim, default=list(TRIMS), help='"auto" or cells')
    add("--results", type=Path, metavar="FILE", help="append rows here, and run only new ones")
    return parser


def _trim(word: str) -> float | str:
    """A trim as it is typed."""
    return word if word == "auto" else float(word)


if __name__ == "__main__":
    sys.exit(main())
