"""Proof that geosurf does what it promises, for anyone to run.

`geosurf.prove.stress` feeds the engine what breaks engines, and judges its answers with arithmetic
that shares nothing with it. The names are imported when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "Case": "geosurf.prove.case",
    "FAMILIES": "geosurf.prove.families",
    "make_case": "geosurf.prove.families",
    "replay": "geosurf.prove.stress",
    "run_case": "geosurf.prove.stress",
    "run_stress": "geosurf.prove.stress",
}

__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'geosurf.prove' has no attribute {name!r}")
