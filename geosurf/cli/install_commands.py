"""The commands ``doctor`` and ``warmup``: check the installation and compile the kernels."""

from __future__ import annotations

import argparse
import sys

from geosurf.cli.console import Answer, clear_line
from geosurf.errors import InputError


def doctor_command(options: argparse.Namespace) -> Answer:
    """Check the installation: versions, kernels, display, extras."""
    from geosurf.cli.installation import installation

    parts = installation()

    # one row per part of the installation; extras that are absent are no fault
    lines = [f"{part.state:<7}  {part.name:<9} {part.detail}" for part in parts]
    data = [
        {"part": part.name, "ok": part.ok, "extra": part.extra, "detail": part.detail}
        for part in parts
    ]
    code = 0 if all(part.ok or part.extra for part in parts) else InputError.exit_code
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
