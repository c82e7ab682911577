"""The command line: ``geosurf run scenario.toml -o out/``.

Commands import what they need when they run, so that ``geosurf --help`` answers at once. Errors
that geosurf raises on purpose are printed without a traceback; `exit_codes` turns them into exit
codes.

================== ============================================
parser             commands, options and their help
arguments          arguments are refused in one sentence
scenario_commands  ``run``, ``validate``, ``check``
new_command        ``new``
ensemble_command   ``ensemble``
render_command     ``render``
convert_command    ``convert``, ``curves``
info_commands      ``info``, ``doctor``, ``warmup``
console            answers, progress, output in any encoding, exit codes
================== ============================================
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from importlib import import_module
from typing import Any

from geosurf.cli.console import ExitCode, encodable_output, peak_megabytes, printed_warnings
from geosurf.cli.parser import build_parser
from geosurf.stopping import keeping

__all__ = ["build_parser", "main"]

WITH_DASK = ("ensemble", "doctor")
PACKAGES = ("dask", "distributed")


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
        if argv is None and options.command not in WITH_DASK:
            skip_dask()
        keeping(lambda: options.kept(options))
        exit_code = ExitCode(options.debug, lambda: options.kept(options))
        start = time.perf_counter()
        from geosurf.conventions.running import silence  # not for --help: it loads numpy

        quiet = silence() if options.quiet else nullcontext()
        with exit_code, printed_warnings(), quiet:
            module = import_module(f"geosurf.cli.{options.module}")
            answer = getattr(module, f"{options.command}_command")(options)
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


def skip_dask() -> None:
    """Let nothing import Dask in this process, if nothing has.

    Where Dask is installed, xarray imports it for the first array that it makes, and again parts of
    it to write the first file: half a second, for arrays that no such command has. Modules set to
    None in `sys.modules` count as not installed. Only the process of a command does this: other
    programs that call `geosurf.cli.main` may have Dask arrays of their own.
    """
    modules: dict[str, Any] = sys.modules
    if not any(name in modules for name in PACKAGES):
        modules.update(dict.fromkeys(PACKAGES))
