"""Choose the graphics backend for off-screen pictures, and test it first.

VTK draws without a screen through EGL or OSMesa. If neither works, VTK ends the interpreter
instead of raising an error; by default it also tries an X server first and prints warnings.
Therefore geosurf chooses the backend before VTK opens a window, and tests each candidate in a
separate process (`probe.py`, about 0.1 s, once per process). Windows and macOS draw off-screen
with their own drivers.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from geosurf.conventions.packages import DRAWING, missing_sentence
from geosurf.errors import DependencyError

CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"
ALLOWED = "ALLOW_PLOTTING"  # pyvista opens no window to test what has been tested
PROBE = Path(__file__).with_name("probe.py")
PROBE_SECONDS = 60
INSTALL = (
    "Install EGL with a software driver (Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri; "
    "conda: mesalib) or OSMesa (apt install libosmesa6)"
)

_lock = threading.Lock()


@dataclass(frozen=True)
class Backend:
    """A graphics backend: name, window class of VTK, shared libraries, and what it needs."""

    name: str
    window: str
    libraries: tuple[str, ...]
    needs: str = "a driver that draws OpenGL 3.2"


EGL = Backend("egl", "vtkEGLRenderWindow", ("libEGL.so.1", "libEGL.so"))
OSMESA = Backend(
    "osmesa", "vtkOSOpenGLRenderWindow", ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
)
X = Backend("x", "vtkXOpenGLRenderWindow", ("libX11.so.6",), "a running X server")
BACKENDS = (EGL, OSMESA, X)


@dataclass(frozen=True)
class Finding:
    """Result of a probe: the name of the renderer, or '' and the reason."""

    backend: Backend
    renderer: str
    reason: str


def probe(backend: Backend) -> Finding:
    """Test in a separate process whether a backend can draw.

    Parameters
    ----------
    backend : Backend

    Returns
    -------
    Finding
    """
    reason = f"none of {', '.join(backend.libraries)} can be loaded"
    for library in backend.libraries:
        # -I and -S: no modules, paths or settings of the user in the process that may crash
        command = [sys.executable, "-I", "-S", str(PROBE), backend.name, library]
        try:
            run = subprocess.run(  # our own file, with a name from the list above
                command, capture_output=True, text=True, timeout=PROBE_SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            return Finding(backend, "", f"{library} did not respond within {PROBE_SECONDS} s")
        except OSError as error:
            return Finding(backend, "", f"{sys.executable} cannot be started: {error.strerror}")

        # a library that is not there is silent; one that fails to draw is worth a reason
        if run.returncode == 0:
            return Finding(backend, run.stdout.strip(), f"{library} can draw")
        if f"{library}: cannot open shared object" not in run.stderr:
            died = f" (it crashed with signal {-run.returncode})" if run.returncode < 0 else ""
            return Finding(
                backend, "", f"{library} is installed, but {backend.needs} is missing{died}"
            )
    return Finding(backend, "", reason)


@functools.cache
def find_backend(asked: str = "") -> Finding:
    """Return the first backend that can draw: EGL, then OSMesa.

    Parameters
    ----------
    asked : str
        A window class of VTK that the user chose, or ''. Then only this one is tried.

    Returns
    -------
    Finding

    Raises
    ------
    DependencyError
        If no backend can draw. The message lists the attempts and the packages to install.
    """
    # a choice of the user is tried alone: another driver would hide that it fails
    known = {backend.window: backend for backend in BACKENDS}
    if asked and asked not in known:
        raise DependencyError(
            f"the environment variable {CHOICE} is {asked!r}, which geosurf cannot use. "
            f"Unset it, or set it to one of {', '.join(known)}."
        )
    findings = []
    for backend in [known[asked]] if asked else [EGL, OSMESA]:
        finding = probe(backend)
        if finding.renderer:
            return finding
        findings.append(finding)

    # each backend with its reason: which package is missing differs from machine to machine
    tried = "; ".join(f"{f.backend.name.upper()}: {f.reason}" for f in findings)
    unset = f", or unset {CHOICE}" if asked else ""
    raise DependencyError(f"pictures cannot be drawn without a screen ({tried}). {INSTALL}{unset}.")


@contextmanager
def off_screen() -> Iterator[None]:
    """Make VTK open its windows with a working backend, one picture at a time.

    The choice ends with the ``with`` block, so windows that users open are not affected.

    Raises
    ------
    DependencyError
        If no backend can draw.
    """
    # Windows and macOS have one way to draw, which needs no choice
    if not sys.platform.startswith("linux"):
        yield
        return

    # VTK reads the variable when a window opens; one picture at a time sets it
    window = find_backend(os.environ.get(CHOICE) or "").backend.window
    with _lock:
        wanted = {CHOICE: window, ALLOWED: "true"}
        before = {key: os.environ.get(key) for key in wanted}
        os.environ.update(wanted)
        try:
            yield
        finally:
            for key, value in before.items():
                if value is None:
                    del os.environ[key]
                else:
                    os.environ[key] = value


def views_obstacle() -> str:
    """Return why views in three dimensions cannot be drawn here, and the remedy, or ''."""
    if sentence := missing_sentence("pictures in three dimensions need", *DRAWING):
        return sentence
    if sys.platform.startswith("linux"):
        try:
            find_backend(os.environ.get(CHOICE) or "")
        except DependencyError as error:
            return str(error)
    return ""
