"""The commands ``doctor`` and ``warmup``: check the installation and compile the kernels."""

from __future__ import annotations

import argparse
import sys

from geosurf.cli.answer import Answer
from geosurf.cli.console import clear_line
from geosurf.errors import InputError


def doctor_command(options: argparse.Namespace) -> Answer:
    """Check the installation: versions, kernels, display."""
    from geosurf.render import doctor

    findings = doctor()

    # one row per part of the installation: name, whether it fits, a sentence with the remedy
    lines = [
        f"{'ok     ' if fit else 'MISSING'}  {name:<9} {sentence}"
        for name, fit, sentence in findings
    ]
    data = [{"part": name, "ok": fit, "detail": sentence} for name, fit, sentence in findings]
    code = 0 if all(fit for _, fit, _ in findings) else InputError.exit_code
    return Answer(data, "\n".join(lines), code)


def warmup_command(options: argparse.Namespace) -> Answer:
    """Compile all kernels, so that the next command starts at once."""
    from geosurf.kernels.compile.warmup import warm

    # a line that is overwritten makes no sense in a file or a pipe
    show = sys.stderr.isatty() and not options.quiet

    def progress(n_done: int, n_file: int) -> None:
        """Show how many files are done, on one line."""
        print(f"\r{n_done} of {n_file} kernel files compiled", end="", file=sys.stderr, flush=True)

    done = warm(progress if show else None)
    clear_line()
    return Answer({"kernels": done}, done)
