"""The command ``info``: what files hold and how geosurf reads them."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict

from geosurf.cli.console import Answer
from geosurf.errors import InputError


def info_command(options: argparse.Namespace) -> Answer:
    """Return what each file holds."""
    from geosurf.read.file_info import info

    found, code = [], 0
    for path in options.files:
        try:
            found.append(info(path))
        except InputError as error:  # the others are shown all the same
            print(f"geosurf: {error}", file=sys.stderr)
            code = error.exit_code
    return Answer([asdict(one) for one in found], "\n".join(map(str, found)), code)
