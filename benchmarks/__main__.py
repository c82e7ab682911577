"""``python -m benchmarks``: measure, print the tables, and write them with pictures and a page."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks import bench_text, run_bench, write_bench
from geosurf.cli.console import OUR_FAULT, ExitCode, encodable_output, printed_warnings


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run the benchmarks and return an exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int
        0, or 4 if an answer of geosurf is wrong; errors have the codes of the command ``geosurf``.
    """
    with encodable_output():
        options = build_parser().parse_args(argv)
        ending = ExitCode(options.debug)
        with ending, printed_warnings():
            ending.code = run(options)
            sys.stdout.flush()
    return ending.code


def run(options: argparse.Namespace) -> int:
    """Measure what the options name."""
    tables = [*(options.only or ()), *(["targets"] if options.targets else [])]
    found = run_bench(
        tables or None,
        size=options.size,
        quick=options.quick,
        targets=options.target,
        core=options.core,
        progress=None if options.quiet else lambda line: print(line, flush=True),
    )
    print(f"\n{bench_text(found)}\n")
    for path in write_bench(found, options.out) if options.out else ():
        print(path)
    for sentence in found["wrong"]:
        print(f"benchmarks: {sentence}", file=sys.stderr)
    return OUR_FAULT if found["wrong"] else 0


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of all options."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Measure time, error and memory of geosurf; exit code 4 if an answer is wrong.",
    )
    add = parser.add_argument
    add("--quick", action="store_true", help="tiny sizes, to check that everything runs")
    add("--only", action="append", metavar="TABLE",
        help="error, growth, questions or targets; may be repeated")  # fmt: skip
    add("--targets", action="store_true", help="the table of targets")
    add("--target", action="append", metavar="NAME", help="one row of targets; may be repeated")
    add("--size", type=float, help="largest number of triangles (default: 2e6; targets: 2e7)")
    add("--core", type=int, help="core to measure on (default: the last)")
    add("-o", "--out", help="folder for JSON, pictures and one page")
    add("--quiet", action="store_true", help="print no progress")
    add("--debug", action="store_true", help="show the traceback of an error")
    return parser


if __name__ == "__main__":
    sys.exit(main())
