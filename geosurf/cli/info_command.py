"""The command ``info``: what files hold and how geosurf reads them."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict


def info_command(options: argparse.Namespace) -> int:
    """Print what each file holds, as text or as JSON."""
    from geosurf.read.file_info import info

    found = [info(path) for path in options.files]
    if options.json:
        print(json.dumps([asdict(one) for one in found], indent=2))
    else:
        print("\n".join(map(str, found)))
    return 0
