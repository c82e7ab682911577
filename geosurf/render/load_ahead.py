"""Load what draws in a thread of its own, while a model is built.

pyvista, VTK, matplotlib and a font take half a second of the first picture of a process. Kernels
release the lock of Python, so that both go on at once. Nothing waits for the thread but those who
draw; what it cannot load, they fail to load again and raise.
"""

from __future__ import annotations

import io
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from geosurf.conventions.memory import collect_later
from geosurf.conventions.packages import DRAWING, missing_sentence

_lock = threading.Lock()
_loader: threading.Thread | None = None  # that loads, or has loaded


def begin_to_load() -> None:
    """Begin to load what draws and to look for a backend, once in a process.

    Python waits for the thread at its end: a thread that is stopped inside a library can take the
    process down.

    Examples
    --------
    >>> begin_to_load()
    >>> wait_until_loaded()
    """
    global _loader
    # only for views: runs without pictures load this file, too
    from geosurf.render.backend import begin_to_find

    begin_to_find()
    with _lock:
        if _loader is None and not missing_sentence("pictures need", *DRAWING):
            # Here, since it replaces what all threads do with warnings for a moment: two threads
            # that do so at once can leave all warnings unseen.
            with quiet_matplotlib():
                import matplotlib.style  # noqa: F401
            _loader = threading.Thread(target=_load, name="geosurf-load-ahead")
            _loader.start()


def wait_until_loaded() -> None:
    """Wait until all is loaded that `begin_to_load` has begun to load."""
    if _loader is not None:
        _loader.join()


@contextmanager
def quiet_matplotlib() -> Iterator[None]:
    """Suppress what matplotlib logs at its first import: its cache of fonts and its folders.

    One thread at a time: of two, the second one would restore what the first one has set.
    """
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _load() -> None:
    """Load in the order of use: what views need first."""
    # whatever is wrong is raised for those who draw, who say what they were about to do
    with suppress(Exception), collect_later(), quiet_matplotlib():
        import pyvista
        from vtkmodules.util import numpy_support  # noqa: F401

        pyvista.Plotter  # noqa: B018 - loaded on first use, as VTK's modules are

        # a word is drawn, so that its font and what writes files are found
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(1.0, 1.0))
        figure.text(0.5, 0.5, "m", parse_math=False)
        FigureCanvasAgg(figure).print_png(io.BytesIO())  # type: ignore[no-untyped-call]


__all__ = ["begin_to_load", "quiet_matplotlib", "wait_until_loaded"]
