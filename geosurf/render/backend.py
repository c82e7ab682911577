"""Choose the graphics backend for off-screen pictures, and test it first.

VTK draws without a screen through EGL or OSMesa. If neither works, VTK ends the interpreter
instead of raising an error; by default it also tries an X server first and prints warnings.
Therefore geosurf chooses the backend before VTK opens a window, and tests each candidate in a
separate process (`probe.py`, about 0.1 s, once per process). Windows and macOS draw off-screen
with their own drivers.
"""

from __future__ import annotations

import functools
import math
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geosurf.conventions.machine import DRAWING, missing_sentence
from geosurf.conventions.palette import PAPER, RGB
from geosurf.errors import DependencyError
from geosurf.render.layers import Layer
from geosurf.render.views import Camera

if TYPE_CHECKING:  # pragma: no cover - types only
    from pyvista import Plotter
    from pyvista.plotting.themes import Theme


# ---- plot ----------------------------------------
# Draw layers off-screen with VTK; the only module that imports pyvista.


# ---- pixels ----------------------------------------
# Pixels of a picture: made from those of a larger one, and pasted into a figure.


def averaged(image: np.ndarray, n: int) -> np.ndarray:
    """
    Return a picture with the means of blocks of pixels.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3 or 4)
        The fourth channel is opacity.
    n : int
        Pixels along the sides of a block; those of incomplete ones at the end are left out.

    Returns
    -------
    ndarray of uint8, shape (height // n, width // n, 3 or 4)

    Examples
    --------
    >>> averaged(np.array([[[0, 9, 0], [0, 0, 0]], [[4, 9, 0], [0, 0, 0]]], dtype=np.uint8), 2)
    array([[[1, 5, 0]]], dtype=uint8)
    """
    return _averaged_rgba(image, n) if image.shape[2] == 4 else _averaged_rgb(image, n)


def _averaged_rgba(image: np.ndarray, n: int) -> np.ndarray:
    """Average blocks of pixels with their opacity: what is transparent has no colour."""
    height, width = image.shape[0] // n, image.shape[1] // n
    blocks = image[: height * n, : width * n].reshape(height, n, width, n, 4).astype(np.float64)
    weight = blocks[..., 3:].sum(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).sum(axis=(1, 3)) / np.maximum(weight, 1.0)
    mean: np.ndarray = np.concatenate([colour, weight / (n * n)], axis=2)
    return np.round(mean).astype(np.uint8)


def _averaged_rgb(image: np.ndarray, n: int) -> np.ndarray:
    """Average blocks of pixels, rounded half up."""
    height, width = image.shape[0] // n, image.shape[1] // n

    # one pixel of each block at a time: nothing as large as the window is made
    total = np.full((height, width, 3), n * n // 2, dtype=np.uint16)
    for row in range(n):
        for column in range(n):
            total += image[row : height * n : n, column : width * n : n]
    return (total // (n * n)).astype(np.uint8)


LARGEST_PART = 540_000  # pixels that are drawn at once; drivers have a few buffers of that size,
LARGEST_PEELED = 150_000  # and a dozen if surfaces are transparent
OVERSAMPLING = 2  # edges are smoothed by averaging, which is the same for every driver
MARGIN = 16  # pixels around each part that is drawn: drivers drop lines whose middle is outside
LIFT = 1.5e-3  # lines are moved to the viewer by this fraction of the size of the model
LIFT_STEEP = 3.0  # plus this number of line widths, for steep surfaces
FEATURE_ANGLE = 40.0
PEELS = 6  # transparent surfaces one behind the other


def draw_layers(
    layers: tuple[Layer, ...], camera: Camera, background: RGB = PAPER, transparent: bool = False
) -> np.ndarray:
    """Return the picture of some layers.

    Parameters
    ----------
    layers : tuple of Layer
    camera : Camera
    background : (red, green, blue)
    transparent : bool
        Whether the background is left out.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3), or 4 with a transparent background
        The first row is the top.

    Raises
    ------
    DependencyError
        If no graphics driver can draw.
    """
    peeled = any(layer.opacity < 1.0 for layer in layers)
    n_part = _parts(camera.size, LARGEST_PEELED if peeled else LARGEST_PART)
    with off_screen():
        import pyvista

        plotter = pyvista.Plotter(
            off_screen=True,
            window_size=[-(-OVERSAMPLING * n // n_part) + 2 * MARGIN for n in camera.size],
            lighting="none",
            theme=_theme(background),
        )
        try:
            reach = _add_layers(plotter, layers, camera)
            _point_camera(plotter, camera, reach)
            _light(plotter)
            if peeled:
                _peel(plotter)
            image = _pixels(plotter, camera.size, n_part, transparent)
        finally:
            plotter.close()
    return averaged(image, OVERSAMPLING)


def _theme(background: RGB) -> Theme:
    """A theme of its own, independent of the global theme of the user."""
    import pyvista

    theme: Theme = pyvista.themes.Theme()
    theme.background = background
    theme.anti_aliasing = None
    theme.return_cpos = False
    return theme


def _add_layers(plotter: Plotter, layers: tuple[Layer, ...], camera: Camera) -> float:
    """Add shifted copies of the layers; return the largest distance from the centre."""
    # float64 until here: VTK computes in float32, and world coordinates have seven digits
    local = [camera.to_local(layer.points) for layer in layers]
    reach = max(float(np.linalg.norm(points, axis=1).max(initial=0.0)) for points in local)
    for layer, points in zip(layers, local, strict=True):
        if layer.triangles is not None:
            _add_triangles(plotter, layer, points, layer.triangles)
        if layer.dots:
            _add_dots(plotter, layer, points + LIFT * reach * camera.towards)
        if len(layer.lines):
            lift = LIFT * reach + LIFT_STEEP * layer.width * camera.metres_per_pixel
            _add_lines(plotter, layer, points + lift * camera.towards)
    return reach


def _add_triangles(
    plotter: Plotter, layer: Layer, points: np.ndarray, triangles: np.ndarray
) -> None:
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(points, triangles)
    shades = None
    if layer.shades is not None:
        # with the mesh: `sharp` splits its points
        mesh.point_data["shades"] = np.round(255.0 * layer.shades).astype(np.uint8)
        shades = "shades"
    # colours that stand for numbers are compared with the colour bar: shadows are weak there
    ambient, diffuse = (0.42, 0.68) if shades is None else (0.75, 0.35)

    # smooth normals, but creases of units stay sharp: `sharp` splits their vertices
    mesh = mesh.compute_normals(
        cell_normals=False,
        split_vertices=layer.sharp,
        feature_angle=FEATURE_ANGLE,
        consistent_normals=False,
        auto_orient_normals=False,
    )
    plotter.add_mesh(
        mesh,
        color=layer.colour,
        scalars=shades,
        rgb=shades is not None,
        opacity=layer.opacity,
        smooth_shading=True,
        ambient=ambient,
        diffuse=diffuse,
        specular=0.0,
        reset_camera=False,
        render=False,
        copy_mesh=False,
    )


def _add_dots(plotter: Plotter, layer: Layer, points: np.ndarray) -> None:
    plotter.add_points(
        points,
        color=layer.colour,
        opacity=layer.opacity,
        point_size=layer.width * OVERSAMPLING,
        render_points_as_spheres=False,
        lighting=False,
        reset_camera=False,
        render=False,
    )


def _add_lines(plotter: Plotter, layer: Layer, points: np.ndarray) -> None:
    import pyvista

    mesh = pyvista.PolyData(points)

    # without this, pyvista draws a dot at every point
    mesh.verts = np.empty(0, dtype=np.int64)

    # VTK wants each line as its number of points, then their rows
    if isinstance(layer.lines, np.ndarray):
        mesh.lines = np.insert(layer.lines, 0, 2, axis=1).ravel()
    else:
        mesh.lines = np.concatenate([np.insert(line, 0, len(line)) for line in layer.lines])
    plotter.add_mesh(
        mesh,
        color=layer.colour,
        opacity=layer.opacity,
        line_width=layer.width * OVERSAMPLING,
        lighting=False,
        reset_camera=False,
        render=False,
        copy_mesh=False,
    )


def _point_camera(plotter: Plotter, camera: Camera, reach: float) -> None:
    eye = plotter.camera
    distance = 3.0 * max(reach, 1.0)

    # the distance changes nothing in a parallel projection; it only clears the model
    eye.position = tuple(distance * camera.towards)
    eye.focal_point = (0.0, 0.0, 0.0)
    eye.up = tuple(camera.up)
    eye.parallel_projection = True

    # VTK's scale: half the height of the picture [m]
    eye.parallel_scale = camera.size[1] * camera.metres_per_pixel / 2.0
    plotter.renderer.camera_set = True

    # depth is stored as a fraction of this range: a tight one separates near surfaces
    eye.clipping_range = (distance - 1.1 * max(reach, 1.0), distance + 1.1 * max(reach, 1.0))


def _peel(plotter: Plotter) -> None:
    """Draw transparent surfaces in their order."""
    # not `enable_depth_peeling`, which opens a second window to test the driver
    plotter.renderer.SetUseDepthPeeling(True)
    plotter.renderer.SetMaximumNumberOfPeels(PEELS)
    plotter.renderer.SetOcclusionRatio(0.0)


def _parts(size: tuple[int, int], most: int) -> int:
    """Into how many parts along either side a picture is divided, so that none is too large."""
    return max(OVERSAMPLING, math.ceil(OVERSAMPLING * math.sqrt(size[0] * size[1] / most)))


def _light(plotter: Plotter) -> None:
    """Add a key light from the upper left, as in shaded maps, and a weak light against it."""
    import pyvista

    # lights fixed to the camera: the same shading from all directions of view
    for position, intensity in (((-0.65, 0.9, 0.75), 0.93), ((0.8, -0.1, 0.8), 0.38)):
        light = pyvista.Light(
            position=position, light_type="camera light", intensity=intensity, color="white"
        )
        plotter.add_light(light)


def _pixels(plotter: Plotter, size: tuple[int, int], n_part: int, transparent: bool) -> np.ndarray:
    """Draw part after part, and return the pixels (height, width, 3 or 4) from the top, uint8.

    All of it is `OVERSAMPLING` times as wide and as high as the picture.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    m = MARGIN
    window, eye = plotter.render_window, plotter.camera
    assert window is not None  # the plotter is open
    wide, high = window.GetActualSize()
    width, height = wide - 2 * m, high - 2 * m
    across_all, up_all = (OVERSAMPLING * n for n in size)
    image = np.empty((up_all, across_all, 4 if transparent else 3), dtype=np.uint8)
    eye.SetParallelScale(eye.GetParallelScale() * high / up_all)
    for row in range(n_part):
        for column in range(n_part):
            # in halves of the window, from the middle of the picture to that of the part
            across = (2 * column + 1) * width - across_all
            up = (2 * row + 1) * height - up_all
            eye.SetWindowCenter(across / wide, up / high)
            window.Render()
            pixels = vtkUnsignedCharArray()
            corners = m, m, m + width - 1, m + height - 1
            if transparent:
                window.GetRGBACharPixelData(*corners, 1, pixels, 0)
            else:
                window.GetPixelData(*corners, 1, pixels, 0)
            part: np.ndarray = vtk_to_numpy(pixels)  # type: ignore[no-untyped-call]
            # the last parts may be larger than what is left
            room = image[row * height : (row + 1) * height, column * width : (column + 1) * width]
            room[...] = part.reshape(height, width, -1)[: room.shape[0], : room.shape[1]]
    return image[::-1]


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
