"""What a scene reports while it works: `Scene(on_start=...)`."""

from __future__ import annotations

from collections.abc import Callable

from geosurf.conventions.running import count_of
from geosurf.errors import InputError

# stage, subject, number of this step, and of all steps of the stage that are known so far
OnStart = Callable[[str, str, int, int], object]


def silent(stage: str, subject: str, number: int, count: int) -> None:
    """Report nothing."""


def announced(stage: str, subject: str, number: int, count: int) -> None:
    """Count for the line that shows what is running, where somebody watches."""
    count_of(f"{stage} {subject}", number, count)


def on_start_of(value: OnStart | None) -> OnStart:
    """
    Return what a scene calls before each step.

    Raises
    ------
    InputError
        If it cannot be called.

    Examples
    --------
    >>> on_start_of(None) is announced
    True
    """
    if value is None:
        return announced
    if not callable(value):
        raise InputError(
            f"on_start is {value!r}; give a function of stage, subject, number and count, such as "
            "print."
        )
    return value
