"""Choose what draws, and look before drawing.

VTK draws without a screen through EGL or OSMesa. Where neither works it does not
raise: it kills the interpreter; and left to itself it first knocks at an X
server and complains. So the choice is made here, before VTK opens a window, and
each candidate has to draw in a process of its own (`probe.py`, some 0.1 s, once per
process). Windows and macOS draw off-screen with what they bring.
"""

from __future__ import annotations

import functools
import importlib.metadata
import os
import platform
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from geosurf.errors import DependencyError

CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"
PROBE = Path(__file__).with_name("probe.py")
PROBE_SECONDS = 60
PACKAGES = ("numpy", "numba", "vtk", "pyvista")
INSTALL = (
    "Install EGL with a software driver (Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri; "
    "conda: mesalib) or OSMesa (apt install libosmesa6)"
)

_lock = threading.Lock()


@dataclass(frozen=True)
class Backend:
    """One way to draw: its name, VTK's window class, the libraries that bring it, what may lack."""

    name: str
    window: str
    libraries: tuple[str, ...]
    needs: str = "a driver that draws OpenGL 3.2"


EGL = Backend("egl", "vtkEGLRenderWindow", ("libEGL.so.1", "libEGL.so"))
OSMESA = Backend(
    "osmesa", "vtkOSOpenGLRenderWindow", ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
)
X = Backend("x", "vtkXOpenGLRenderWindow", ("libX11.so.6",), "an X server that answers")
BACKENDS = (EGL, OSMESA, X)


@dataclass(frozen=True)
class Finding:
    """What a probe found: the renderer's name, or '' and the reason."""

    backend: Backend
    renderer: str
    reason: str


def probe(backend: Backend) -> Finding:
    """Let a process of its own try whether a back end draws.

    Parameters
    ----------
    backend : Backend

    Returns
    -------
    Finding
    """
    reason = f"none of {', '.join(backend.libraries)} can be loaded"
    for library in backend.libraries:
        command = [sys.executable, "-I", "-S", str(PROBE), backend.name, library]
        try:
            run = subprocess.run(  # our own file, with a name from the list above
                command, capture_output=True, text=True, timeout=PROBE_SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            return Finding(backend, "", f"{library} did not answer in {PROBE_SECONDS} s")
        except OSError as error:
            return Finding(backend, "", f"{sys.executable} cannot be started: {error.strerror}")
        if run.returncode == 0:
            return Finding(backend, run.stdout.strip(), f"{library} draws")
        if f"{library}: cannot open shared object" not in run.stderr:
            died = f" (it died with signal {-run.returncode})" if run.returncode < 0 else ""
            return Finding(backend, "", f"{library} is there, but not {backend.needs}{died}")
    return Finding(backend, "", reason)


@functools.cache
def find_backend(asked: str = "") -> Finding:
    """Return the first back end that draws: EGL, then OSMesa.

    Parameters
    ----------
    asked : str
        A window class of VTK that the user asked for, or ''. Only that one is tried.

    Returns
    -------
    Finding

    Raises
    ------
    DependencyError
        If none draws: what was tried, and which packages bring one.
    """
    known = {backend.window: backend for backend in BACKENDS}
    if asked and asked not in known:
        raise DependencyError(
            f"the environment says {CHOICE}={asked}, which cannot draw here; "
            f"unset it or choose one of {', '.join(known)}."
        )
    findings = []
    for backend in [known[asked]] if asked else [EGL, OSMESA]:
        finding = probe(backend)
        if finding.renderer:
            return finding
        findings.append(finding)
    tried = "; ".join(f"{f.backend.name.upper()}: {f.reason}" for f in findings)
    unset = f", or unset {CHOICE}" if asked else ""
    raise DependencyError(f"pictures cannot be drawn without a screen ({tried}). {INSTALL}{unset}.")


@contextmanager
def off_screen() -> Iterator[None]:
    """Make VTK open its windows with a back end that works, one picture at a time.

    The choice lasts as long as the ``with`` block, so that people's own
    windows open as they always did.

    Raises
    ------
    DependencyError
        If nothing here can draw.
    """
    if not sys.platform.startswith("linux"):
        yield
        return
    before = os.environ.get(CHOICE)
    window = find_backend(before or "").backend.window
    with _lock:
        os.environ[CHOICE] = window
        try:
            yield
        finally:
            if before is None:
                del os.environ[CHOICE]
            else:
                os.environ[CHOICE] = before


def doctor() -> list[tuple[str, bool, str]]:
    """Describe what geosurf stands on here, for ``geosurf doctor``.

    Returns
    -------
    list of (str, bool, str)
        Name, whether it is fit, and one sentence: version, or what to do.

    Examples
    --------
    >>> [name for name, ok, sentence in doctor()]
    ['python', 'numpy', 'numba', 'vtk', 'pyvista', 'kernels', 'pictures']
    """
    from geosurf.kernels.compile.jit import RUNNER

    version = platform.python_version()
    return [
        ("python", sys.version_info >= (3, 11), f"Python {version} on {platform.system()}."),
        *(_package(name) for name in PACKAGES),
        ("kernels", not RUNNER.obstacle(), RUNNER.describe()),
        _pictures(),
    ]


def _package(name: str) -> tuple[str, bool, str]:
    try:
        return name, True, f"{name} {importlib.metadata.version(name)} is installed."
    except importlib.metadata.PackageNotFoundError:
        return name, False, f"{name} is not installed; mend it with: pip install {name}"


def _pictures() -> tuple[str, bool, str]:
    if not sys.platform.startswith("linux"):
        return "pictures", True, f"drawn off-screen by what {platform.system()} brings."
    try:
        found = find_backend(os.environ.get(CHOICE) or "")
    except DependencyError as error:
        return "pictures", False, str(error)
    how = f"{found.backend.name.upper()}, {found.renderer}"
    return "pictures", True, f"drawn off-screen through {how}."
