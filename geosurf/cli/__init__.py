"""The command line: ``geosurf run scenario.toml -o out/``.

Commands import what they need when they run, so that ``geosurf --help`` answers at once. Errors
that geosurf raises on purpose are printed without a traceback; `exit_codes` turns them into exit
codes.

===================== ============================================
`parser`              commands, options and their help
`arguments`           arguments are refused in one sentence
`scenario_commands`   ``run``, ``validate``, ``check``, ``report``, ``new``, ``ensemble``
`render_command`      ``render``
`convert_command`     ``convert``, ``curves``
`info_command`        ``info``
`install_commands`    ``doctor``, ``warmup``
`installation`        packages, kernels and extras, checked
`console`             answers, progress, output in any encoding, warnings
`without_dask`        a faster start of the process of a command
`exit_codes`          errors and signals become exit codes
===================== ============================================
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence

from geosurf.cli.console import ExitCode, encodable_output, peak_megabytes, printed_warnings
from geosurf.cli.install_commands import doctor_command
from geosurf.cli.parser import build_parser
from geosurf.cli.scenario_commands import ensemble_command
from geosurf.cli.without_dask import skip_dask

__all__ = ["build_parser", "main"]


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a command and return its exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int

    Examples
    --------
    >>> main(["check", "missing.toml"])
    2
    """
    # outermost: the parser's own messages quote arguments in any script
    with encodable_output():
        options = build_parser().parse(argv)
        if argv is None and options.run not in (ensemble_command, doctor_command):
            skip_dask()
        exit_code = ExitCode(options.debug, lambda: options.kept(options))
        start = time.perf_counter()
        from geosurf.conventions.running import silence  # not for --help: it loads numpy

        # commands show their own progress
        with exit_code, printed_warnings(), silence():
            answer = options.run(options)
            exit_code.code = answer.code
            if shown := answer.shown(as_json=options.json, quiet=options.quiet):
                print(shown)
            if options.verbose:
                seconds = time.perf_counter() - start
                print(f"{seconds:.1f} s, {peak_megabytes():.0f} MB at most", file=sys.stderr)

            # inside `exit_code`, so that a closed pipe or a full disk is met here and not in the
            # interpreter's own flush at exit, whose message nobody can catch
            if sys.stdout is not None:  # closed from the beginning
                sys.stdout.flush()
    return exit_code.code
