"""How a reader interpreted a file: notes for `geosurf.info`, without effect elsewhere."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar

_LOOKING: ContextVar[bool] = ContextVar("geosurf_read_looking", default=False)
_NOTES: ContextVar[dict[str, str] | None] = ContextVar("geosurf_read_notes", default=None)


def noted(key: str, value: object) -> None:
    """Keep one sentence on what was read; later ones replace earlier ones."""
    notes = _NOTES.get()
    if notes is not None:
        notes[key] = str(value)


@contextlib.contextmanager
def collected(*, looking: bool = False) -> Iterator[dict[str, str]]:
    """
    Collect what readers note meanwhile, in this thread.

    `looking` is for `geosurf.info`: readers take a file with several objects, and do not warn.
    """
    notes: dict[str, str] = {}
    token, before = _NOTES.set(notes), _LOOKING.set(looking)
    try:
        yield notes
    finally:
        _NOTES.reset(token)
        _LOOKING.reset(before)


def is_looking() -> bool:
    """Whether `geosurf.info` looks at a file, which may then hold several objects."""
    return _LOOKING.get()
