"""One line per step of a run, as it is done: for the console, and for callers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from geosurf.errors import GeometryError, InputError
from geosurf.model.excerpt import CloseUp
from geosurf.scene import Scene
from geosurf.scene.given import reported, surfaces_so_far
from geosurf.scene.memory import announced

# ---- failure ----------------------------------------
# What could not be built, as a picture of the place.


FILE = "failure.png"


def _draw(scene: Scene, folder: Path, error: GeometryError) -> None:
    """Draw the place of an error, if it has one, and add a note on the picture to it."""
    if error.place is None:
        return
    from geosurf.render import render_place
    from geosurf.render.backend import views_obstacle
    from geosurf.scene.pictures import Attempt  # loaded by those who draw

    # without a driver or pyvista nothing can be drawn
    if views_obstacle():
        return
    about = ", ".join(error.surfaces) or "the walls"
    path, title = folder / FILE, f"What failed: {about}"

    # a picture that fails must not hide the error that it was to explain
    with Attempt() as tried:
        seen = error.close_up or CloseUp(surfaces_so_far(scene))
        render_place(
            seen.surfaces, error.place, path, reach=seen.reach, rim=seen.rim, points=seen.points,
            title=title,
        )  # fmt: skip
    found = f": {path}" if not tried.reason else f" could not be drawn: {tried.reason}."
    error.add_note(f"A picture of the place{found}")


Progress = Callable[[str], object]


class StepLog:
    """
    Formats each step as a line: stage, subject, outcome, seconds.

    Parameters
    ----------
    progress : callable or None
        Is called with each line; None writes nothing.

    Examples
    --------
    >>> log = StepLog(print)
    >>> log.step("read", "1 horizon, 2 faults", "done", 0.25)
    read        1 horizon, 2 faults                    done                    0.2 s
    """

    def __init__(self, progress: Progress | None) -> None:
        if progress is not None and not callable(progress):
            raise InputError(
                f"progress is {progress!r}; give a function of one text, such as print."
            )
        self._progress = progress
        self._n_reported = 0
        self._clock = time.perf_counter()

    def step(
        self, stage: str, subject: str, outcome: str = "", seconds: float | None = None
    ) -> None:
        """Report one step, with its run time; default: the time since the step before."""
        now = time.perf_counter()

        # a step without its own time took all that passed since the last line
        seconds, self._clock = now - self._clock if seconds is None else seconds, now
        if self._progress is not None:
            self._progress(f"{stage:<11} {subject:<38} {outcome:<20}{seconds:7.1f} s")

    @contextmanager
    def watching(self, scene: Scene, folder: Path | None = None) -> Iterator[None]:
        """
        Report the steps that a scene runs in the block; draw the place where it cannot be built.

        Parameters
        ----------
        scene : Scene
        folder : pathlib.Path, optional
            Where ``failure.png`` goes.

        Raises
        ------
        GeometryError
            That of the block, with a note where the picture is.
        """

        def starts(stage: str, subject: str, number: int, count: int) -> None:
            """Report what is done, and what begins."""
            self._new_steps_of(scene)
            announced(stage, subject, number, count)
            if stage == "tear" and self._progress is not None:  # minutes for a large field
                self._progress(f"{stage:<11} {subject:<38} {number} of {count} ...")

        try:
            with reported(scene, starts):
                yield
        except GeometryError as error:
            if folder is not None:
                _draw(scene, folder, error)
            raise
        finally:
            self._new_steps_of(scene)

    def _new_steps_of(self, scene: Scene) -> None:
        """Report the steps that a scene has run since the last call."""
        # results from memory took no time and are not logged again
        for step in scene.steps[self._n_reported :]:
            if step.outcome == "ran":
                self.step(step.stage, step.subject, step.detail, step.seconds)
        self._n_reported = len(scene.steps)


SILENT = StepLog(None)
