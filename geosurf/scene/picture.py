"""One picture of a scene, not yet drawn, and the options that change it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

# options that decide how a picture looks, for pictures of each kind
FLAT = ("size", "style")
SOLID = (*FLAT, "exaggeration")


@dataclass(frozen=True)
class Picture:
    """One picture: what it shows, its file, how it is drawn there, and what leaves it out.

    `options` names the options of `pictures_of` that change it. Stored pictures are found by these
    (`stored_pictures`), so an option that is missing here shows an old picture.
    """

    caption: str
    file: str
    draw: Callable[[Path], object]
    without: str
    options: tuple[str, ...]
    needs_opengl: bool = True


__all__ = ["FLAT", "SOLID", "Picture"]
