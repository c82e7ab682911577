"""The commands ``doctor`` and ``warmup``: check the installation and compile the kernels."""

from __future__ import annotations

import argparse
import sys

from geosurf.errors import InputError


def doctor_command(options: argparse.Namespace) -> int:
    """Check the installation: versions, kernels, display."""
    from geosurf.render import doctor

    findings = doctor()

    # one row per part of the installation: name, whether it fits, a sentence with the remedy
    for name, fit, sentence in findings:
        print(f"{'ok     ' if fit else 'MISSING'}  {name:<9} {sentence}")
    return 0 if all(fit for _, fit, _ in findings) else InputError.exit_code


def warmup_command(options: argparse.Namespace) -> int:
    """Compile all kernels, so that the next command starts at once."""
    from geosurf.kernels.compile.warmup import warm

    # a line that is overwritten makes no sense in a file or a pipe
    show = sys.stdout.isatty()

    def progress(n_done: int, n_file: int) -> None:
        """Show how many files are done, on one line."""
        print(f"\r{n_done} of {n_file} kernel files compiled", end="", flush=True)

    done = warm(progress if show else None)
    print(f"\r{done}" if show else done)
    return 0
