"""What could not be built, as a picture of the place."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from geosurf.errors import GeometryError
from geosurf.scene import Scene

FILE = "failure.png"


@contextmanager
def pictured(
    scene: Scene, folder: Path | None, names: Sequence[str] | None = None
) -> Iterator[None]:
    """
    Draw the place of a `GeometryError` that the block raises, and say in it where the picture is.

    Parameters
    ----------
    scene : Scene
    folder : pathlib.Path or None
        Where ``failure.png`` goes; None draws nothing.
    names : sequence of str, optional
        Surfaces that are drawn; default: all.

    Raises
    ------
    GeometryError
        The same one, with a note where the picture is.
    """
    try:
        yield
    except GeometryError as error:
        if folder is not None:
            _draw(scene, folder, names, error)
        raise


def _draw(scene: Scene, folder: Path, names: Sequence[str] | None, error: GeometryError) -> None:
    """Draw the place of an error, if it has one, and add a note on the picture to it."""
    if error.place is None:
        return
    from geosurf.render import render_place
    from geosurf.render.backend import views_obstacle
    from geosurf.scene.attempt import Attempt  # loaded by those who draw

    # without a driver or pyvista nothing can be drawn
    if views_obstacle():
        return
    about = " and ".join(error.surfaces) or "the walls"
    path, title = folder / FILE, f"What failed: {about}"

    # a picture that fails must not hide the error that it was to explain
    with Attempt() as tried:
        if names is None:
            names = (*scene.horizon_names, *scene.fault_names)
        drawn = map(scene.whole_surface, names)
        render_place(list(drawn), error.place, path, title=title)
    found = f": {path}" if not tried.reason else f" could not be drawn: {tried.reason}."
    error.add_note(f"A picture of the place{found}")
