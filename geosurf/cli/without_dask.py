"""Commands that make one model start faster without Dask.

Where Dask is installed, xarray imports it for the first array that it makes, and again parts of it
to write the first file: half a second, for arrays that no such command has. Modules set to None in
`sys.modules` count as not installed. Only the process of a command does this: other programs that
call `geosurf.cli.main` may have Dask arrays of their own.
"""

from __future__ import annotations

import sys
from typing import Any

PACKAGES = ("dask", "distributed")


def skip_dask() -> None:
    """Let nothing import Dask in this process, if nothing has."""
    modules: dict[str, Any] = sys.modules
    if not any(name in modules for name in PACKAGES):
        modules.update(dict.fromkeys(PACKAGES))
