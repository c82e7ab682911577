"""The command ``info``: what files hold and how geosurf reads them."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from geosurf.cli.answer import Answer


def info_command(options: argparse.Namespace) -> Answer:
    """Return what each file holds."""
    from geosurf.read.file_info import info

    found = [info(path) for path in options.files]
    return Answer([asdict(one) for one in found], "\n".join(map(str, found)))
