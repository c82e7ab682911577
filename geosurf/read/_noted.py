"""How a reader interpreted a file: notes for `geosurf.info`, without effect elsewhere."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar

_NOTES: ContextVar[dict[str, str] | None] = ContextVar("geosurf_read_notes", default=None)


def noted(key: str, value: object) -> None:
    """Keep one sentence on what was read; later ones replace earlier ones."""
    notes = _NOTES.get()
    if notes is not None:
        notes[key] = str(value)


@contextlib.contextmanager
def collected() -> Iterator[dict[str, str]]:
    """Collect what readers note meanwhile, in this thread."""
    notes: dict[str, str] = {}
    token = _NOTES.set(notes)
    try:
        yield notes
    finally:
        _NOTES.reset(token)


def is_collecting() -> bool:
    """Whether `geosurf.info` looks at a file, which may then hold several objects."""
    return _NOTES.get() is not None
