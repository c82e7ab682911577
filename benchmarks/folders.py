"""Where data of outside are that some scenes need."""

from __future__ import annotations

import os
from pathlib import Path


def drogon_folder() -> Path:
    """Return where the data of the field are, whether there or not."""
    here = Path(__file__).resolve().parents[1].parent / "shared"
    return Path(os.environ.get("GEOSURF_SHARED", here)) / "data"
