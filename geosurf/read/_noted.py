"""How a reader interpreted a file: notes for `geosurf.info`, without effect elsewhere."""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import TypeVar

from geosurf.conventions import did_you_mean
from geosurf.errors import InputError

# ---- choice ----------------------------------------
# Files with several named objects: which one a caller means.


Part = TypeVar("Part")
MOST_NAMED = 12  # names in one message


def chosen(
    path: Path, groups: Mapping[str, Sequence[Part]], name: str | None, what: str
) -> tuple[str, list[Part]]:
    """
    Return the name and the parts of the one object that a caller means.

    Parameters
    ----------
    path : pathlib.Path
    groups : mapping of str to sequence
        Parts of each object; without a name under "".
    name : str or None
        The name that the caller gives; any name is right where there is one object.
    what : str
        Objects in the plural: "faults".

    Raises
    ------
    InputError
        If there are several and `name` is not one of them.

    Examples
    --------
    >>> chosen(Path("f.dat"), {"F1": [1, 2], "F2": [3]}, "F2", "faults")
    ('F2', [3])
    >>> chosen(Path("f.dat"), {"F1": [1, 2], "F2": [3]}, None, "faults")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    geosurf.errors.InputError: f.dat: the file has 2 faults: F1, F2. Choose one, as in name='F1' ...
    """
    names = list(groups)
    listed = ", ".join(names[:MOST_NAMED]) + (" ..." if len(names) > MOST_NAMED else "")
    if any(names):
        noted("names", f"{len(names)} {what}: {listed}" if len(names) > 1 else listed)
    if len(names) <= 1:
        return (names or [""])[0], [part for parts in groups.values() for part in parts]
    if name in groups:
        return str(name), list(groups[str(name)])
    if is_looking():  # `geosurf.info` looks at all of them
        return "", [part for parts in groups.values() for part in parts]
    asked = "" if name is None else f", but none is called {name!r}"
    guess = "" if name is None else did_you_mean(name, names)
    raise InputError(
        f"{path}: the file has {len(names)} {what}: {listed}{asked}.{guess} Choose one, as in "
        f"name={names[0]!r} (on the command line: --name {shlex.quote(names[0])})."
    )


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
