"""Draw layers off-screen with VTK.

Only the modules of VTK that draw are loaded: pyvista loads all of them, which takes 120 MB and half
a second more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from geosurf.render.backend import off_screen
from geosurf.render.layers import Layer
from geosurf.render.palette import PAPER, RGB
from geosurf.render.views import Camera

if TYPE_CHECKING:  # pragma: no cover - types only
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkActor, vtkCamera, vtkRenderer, vtkRenderWindow

OVERSAMPLING = 2  # edges are smoothed by averaging, which is the same for every driver
MARGIN = 16  # pixels around each part that is drawn: drivers drop lines whose middle is outside
LIFT = 1.5e-3  # lines are moved to the viewer by this fraction of the size of the model
LIFT_STEEP = 3.0  # plus this number of line widths, for steep surfaces
FEATURE_ANGLE = 40.0
PEELS = 6  # layers of transparent surfaces that are told apart


def draw_layers(
    layers: tuple[Layer, ...],
    camera: Camera,
    background: RGB = PAPER,
    transparent: bool = False,
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
    with off_screen():
        # first: without the classes that draw, those below it draw nothing
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
        from vtkmodules.vtkRenderingCore import vtkRenderer

        renderer = vtkRenderer()
        renderer.SetBackground(*background)
        window = _window(renderer, camera.size)
        try:
            reach = _add_layers(renderer, layers, camera)
            _point_camera(renderer, camera, reach)
            _light(renderer)
            if any(layer.opacity < 1.0 for layer in layers):
                _peel(window, renderer)
            image = _pixels(window, renderer.GetActiveCamera(), transparent)
        finally:
            # arrays and shaders of the driver go now, not when garbage is collected
            renderer.RemoveAllViewProps()
            window.Finalize()
    return _average_rgba(image) if transparent else _average(image)


def _window(renderer: vtkRenderer, size: tuple[int, int]) -> vtkRenderWindow:
    """A window off-screen for a part of the picture, with a margin that is cut off."""
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    if hasattr(window, "SetConnectContextToNSView"):
        window.SetConnectContextToNSView(False)  # macOS: needs neither a dock nor the main thread
    window.SetMultiSamples(0)
    window.SetSize(*(n + 2 * MARGIN for n in size))
    window.AddRenderer(renderer)
    return window


def _add_layers(renderer: vtkRenderer, layers: tuple[Layer, ...], camera: Camera) -> float:
    """Add shifted copies of the layers; return the largest distance from the centre."""
    # float64 until here: VTK computes in float32, and world coordinates have seven digits
    local = [camera.to_local(layer.points) for layer in layers]
    reach = max(float(np.linalg.norm(points, axis=1).max(initial=0.0)) for points in local)
    for layer, points in zip(layers, local, strict=True):
        if layer.triangles is not None:
            renderer.AddActor(_triangles(layer, points, layer.triangles))
        if layer.dots:
            renderer.AddActor(_dots(layer, points + LIFT * reach * camera.towards))
        if len(layer.lines):
            lift = LIFT * reach + LIFT_STEEP * layer.width * camera.metres_per_pixel
            renderer.AddActor(_lines(layer, points + lift * camera.towards))
    return reach


def _triangles(layer: Layer, points: np.ndarray, triangles: np.ndarray) -> vtkActor:
    """Shaded triangles; creases of units stay sharp: `sharp` splits their vertices."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    mesh = _mesh(points)
    mesh.SetPolys(_cells(triangles))
    if layer.shades is not None:
        # with the mesh: normals may split its points
        shades = np.round(255.0 * layer.shades).astype(np.uint8)
        mesh.GetPointData().SetScalars(numpy_to_vtk(shades))  # type: ignore[no-untyped-call]
    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SetSplitting(layer.sharp)
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    normals.Update()

    actor = _actor(normals.GetOutput(), layer, shaded=True)
    look = actor.GetProperty()
    look.SetInterpolationToPhong()
    look.SetAmbient(0.42)
    look.SetDiffuse(0.68)
    look.SetSpecular(0.0)
    return actor


def _dots(layer: Layer, points: np.ndarray) -> vtkActor:
    mesh = _mesh(points)
    mesh.SetVerts(_cells(np.arange(len(points))[:, None]))
    actor = _actor(mesh, layer)
    actor.GetProperty().SetPointSize(layer.width * OVERSAMPLING)
    return actor


def _lines(layer: Layer, points: np.ndarray) -> vtkActor:
    mesh = _mesh(points)
    mesh.SetLines(_cells(layer.lines))
    actor = _actor(mesh, layer)
    actor.GetProperty().SetLineWidth(layer.width * OVERSAMPLING)
    return actor


def _mesh(points: np.ndarray) -> vtkPolyData:
    """Points of a mesh without cells."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkPolyData

    places, mesh = vtkPoints(), vtkPolyData()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points)))  # type: ignore[no-untyped-call]
    mesh.SetPoints(places)
    return mesh


def _cells(rows: np.ndarray | Sequence[np.ndarray]) -> vtkCellArray:
    """Cells by the rows of their points: a table, or one array for each cell."""
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray

    if isinstance(rows, np.ndarray):
        starts = np.arange(0, rows.size + 1, rows.shape[1])
        corners = np.ascontiguousarray(rows).reshape(-1)
    else:
        starts = np.cumsum([0, *map(len, rows)])
        corners = np.concatenate(rows)
    cells = vtkCellArray()
    numbers = (a.astype(np.int64, copy=False) for a in (starts, corners))
    cells.SetData(*map(numpy_to_vtkIdTypeArray, numbers))
    return cells


def _actor(mesh: vtkPolyData, layer: Layer, *, shaded: bool = False) -> vtkActor:
    """A mesh in the colours of its layer; without `shaded` no light changes them."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper, actor = vtkPolyDataMapper(), vtkActor()
    mapper.SetInputData(mesh)
    mapper.SetScalarVisibility(shaded and layer.shades is not None)
    mapper.SetColorModeToDirectScalars()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*layer.colour)
    look.SetOpacity(layer.opacity)
    look.SetLighting(shaded)
    return actor


def _point_camera(renderer: vtkRenderer, camera: Camera, reach: float) -> None:
    eye = renderer.GetActiveCamera()
    distance = 3.0 * max(reach, 1.0)

    # the distance changes nothing in a parallel projection; it only clears the model
    eye.SetPosition(*(distance * camera.towards))
    eye.SetFocalPoint(0.0, 0.0, 0.0)
    eye.SetViewUp(*camera.up)
    eye.ParallelProjectionOn()

    # VTK's scale: half the height of the picture [m]
    eye.SetParallelScale(camera.size[1] * camera.metres_per_pixel / 2.0)

    # depth is stored as a fraction of this range: a tight one separates near surfaces
    eye.SetClippingRange(distance - 1.1 * max(reach, 1.0), distance + 1.1 * max(reach, 1.0))


def _light(renderer: vtkRenderer) -> None:
    """Add a key light from the upper left, as in shaded maps, and a weak light against it."""
    from vtkmodules.vtkRenderingCore import vtkLight

    # lights fixed to the camera: the same shading from all directions of view
    renderer.AutomaticLightCreationOff()
    for position, intensity in (((-0.65, 0.9, 0.75), 0.93), ((0.8, -0.1, 0.8), 0.38)):
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*position)
        light.SetIntensity(intensity)
        light.SetColor(1.0, 1.0, 1.0)
        renderer.AddLight(light)


def _peel(window: vtkRenderWindow, renderer: vtkRenderer) -> None:
    """Tell transparent surfaces apart by their depth."""
    window.AlphaBitPlanesOn()
    renderer.UseDepthPeelingOn()
    renderer.SetMaximumNumberOfPeels(PEELS)
    renderer.SetOcclusionRatio(0.0)


def _pixels(window: vtkRenderWindow, eye: vtkCamera, transparent: bool) -> np.ndarray:
    """Draw part after part, and return the pixels (height, width, 3 or 4) from the top, uint8.

    The driver has up to a dozen buffers of the size of the window.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    n, m = OVERSAMPLING, MARGIN
    wide, high = window.GetActualSize()
    width, height = wide - 2 * m, high - 2 * m
    image = np.empty((n * height, n * width, 4 if transparent else 3), dtype=np.uint8)
    eye.SetParallelScale(eye.GetParallelScale() * high / (n * height))
    for row in range(n):
        for column in range(n):
            # in halves of the window, from the middle of the picture to that of the part
            across, up = (2 * column + 1 - n) * width, (2 * row + 1 - n) * height
            eye.SetWindowCenter(across / wide, up / high)
            window.Render()
            found = vtkUnsignedCharArray()
            corners = m, m, m + width - 1, m + height - 1
            if transparent:
                window.GetRGBACharPixelData(*corners, 1, found, 0)
            else:
                window.GetPixelData(*corners, 1, found, 0)
            rows = slice(row * height, (row + 1) * height)
            columns = slice(column * width, (column + 1) * width)
            part: np.ndarray = vtk_to_numpy(found)  # type: ignore[no-untyped-call]
            image[rows, columns] = part.reshape(height, width, -1)
    return image[::-1]


def _average_rgba(image: np.ndarray) -> np.ndarray:
    """Average blocks of pixels with their opacity: what is transparent has no colour."""
    n = OVERSAMPLING
    height, width = image.shape[0] // n, image.shape[1] // n
    blocks = image[: height * n, : width * n].reshape(height, n, width, n, 4).astype(np.float64)
    weight = blocks[..., 3:].sum(axis=(1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).sum(axis=(1, 3)) / np.maximum(weight, 1.0)
    mean: np.ndarray = np.concatenate([colour, weight / (n * n)], axis=2)
    return np.round(mean).astype(np.uint8)


def _average(image: np.ndarray) -> np.ndarray:
    """Average blocks of pixels, rounded half up."""
    n = OVERSAMPLING
    height, width = image.shape[0] // n, image.shape[1] // n

    # one pixel of each block at a time: nothing as large as the window is made
    total = np.full((height, width, 3), n * n // 2, dtype=np.uint16)
    for row in range(n):
        for column in range(n):
            total += image[row : height * n : n, column : width * n : n]
    return (total // (n * n)).astype(np.uint8)
