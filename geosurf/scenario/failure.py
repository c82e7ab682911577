"""What could not be built, as a picture of the place."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from geosurf.errors import GeometryError
from geosurf.gallery import cannot_draw
from geosurf.render import render_place
from geosurf.scene import Scene

FILE = "failure.png"


@contextmanager
def pictured(scene: Scene, folder: Path | None) -> Iterator[None]:
    """
    Draw the place of a `GeometryError` that the block raises, and say in it where the picture is.

    Parameters
    ----------
    scene : Scene
    folder : pathlib.Path or None
        Where ``failure.png`` goes; None draws nothing.

    Raises
    ------
    GeometryError
        The same one, with a note where the picture is.
    """
    try:
        yield
    except GeometryError as error:
        if folder is not None and error.place is not None and not cannot_draw():
            about = " and ".join(error.surfaces) or "the walls"
            path = render_place(
                scene.surfaces, error.place, folder / FILE, title=f"What failed: {about}"
            )
            error.add_note(f"A picture of the place: {path}")
        raise
