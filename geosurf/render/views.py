"""Named views: the direction of view, and the projection of world points to pixels.

The projection is parallel. So a length across the picture has the same scale everywhere, lines can
be moved towards the viewer without a shift on the picture, and labels are placed in float64.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean, is_number, is_word
from geosurf.errors import InputError

View = str | tuple[float, float]  # a key of `VIEWS`, or two angles [degrees]

# Position of the viewer: azimuth clockwise from north, angle above the horizontal [degrees].
# Corner views are a little off the diagonal, so that the two sides of a box differ.
VIEWS = {
    "southwest": (213.0, 27.0),
    "southeast": (147.0, 27.0),
    "northwest": (327.0, 27.0),
    "northeast": (33.0, 27.0),
    "south": (180.0, 0.0),
    "north": (0.0, 0.0),
    "east": (90.0, 0.0),
    "west": (270.0, 0.0),
    "top": (180.0, 90.0),
}

# Round vertical exaggerations.
EXAGGERATIONS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0)
# Smallest and largest width and height of a picture [pixels]; smaller ones have no room for text.
SMALLEST, LARGEST = (200, 150), (8000, 8000)
SIZE = (1280, 800)  # default width and height of a picture [pixels]
ZOOMS = (0.1, 100.0)
RELIEF = 0.4  # height over width that reads well


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection of exaggerated, local coordinates to pixels.

    Attributes
    ----------
    right, up, towards : ndarray of float64, shape (3,)
        Unit vectors: to the right, upwards, and towards the viewer.
    centre : ndarray of float64, shape (3,)
        World point [m] in the centre of the picture; the origin of the local frame.
    exaggeration : float
        Elevations are stretched by this about `centre`.
    size : (int, int)
        Pixels across and up.
    metres_per_pixel : float
    """

    right: np.ndarray
    up: np.ndarray
    towards: np.ndarray
    centre: np.ndarray
    exaggeration: float
    size: tuple[int, int]
    metres_per_pixel: float

    def to_local(self, points: np.ndarray) -> np.ndarray:
        """Return world points (n, 3) shifted to `centre` and stretched, float64."""
        # from the centre, in float64: drivers round to float32, which has seven digits
        made: np.ndarray = (points - self.centre) * (1.0, 1.0, self.exaggeration)
        return made

    def to_pixels(self, points: np.ndarray) -> np.ndarray:
        """Return the pixels (n, 2) of world points (n, 3), from the lower left."""
        local = self.to_local(np.asarray(points, dtype=np.float64))
        flat = np.stack([local @ self.right, local @ self.up], axis=-1)
        return flat / self.metres_per_pixel + np.array(self.size) / 2.0


def angles_of(view: View) -> tuple[float, float]:
    """Return azimuth and height of the viewer [degrees] of a named view, or those that are given.

    Raises
    ------
    InputError
        If there is no such view.

    Examples
    --------
    >>> angles_of("top")
    (180.0, 90.0)
    >>> angles_of((-45, 30))
    (315.0, 30.0)
    """
    if is_word(view, VIEWS):
        return VIEWS[str(view)]
    if isinstance(view, str) or not isinstance(view, tuple | list):
        guess = did_you_mean(view, VIEWS) if isinstance(view, str) else ""
        raise InputError(
            f"unknown view {view!r}. Views are {', '.join(VIEWS)}, or azimuth and height of the "
            f"viewer in degrees, as in (225, 30).{guess}"
        )
    if len(view) != 2 or not all(is_number(angle) for angle in view):
        raise InputError(f"view is {view!r}, expected azimuth and height in degrees: (225, 30).")
    azimuth, height = map(float, view)
    if not -90.0 <= height <= 90.0:
        raise InputError(f"the height of the view is {height:g}°, expected -90 to 90 degrees.")
    return azimuth % 360.0, height


def check_zoom(zoom: Any) -> float:
    """Return the zoom, or raise an error.

    Raises
    ------
    InputError
        If it is not a number from 0.1 to 100.
    """
    low, high = ZOOMS
    if not (is_number(zoom) and low <= zoom <= high):
        raise InputError(f"zoom is {zoom!r}, expected a number from {low:g} to {high:g}.")
    return float(zoom)


def words_of(view: View) -> str:
    """Return where the viewer stands, for captions.

    Examples
    --------
    >>> words_of("top"), words_of("south"), words_of((225, 30))
    ('above', 'the south', 'azimuth 225°, 30° above the horizontal')
    """
    if isinstance(view, str):
        return "above" if view == "top" else f"the {view}"
    azimuth, height = angles_of(view)
    side = "above" if height >= 0.0 else "below"
    return f"azimuth {azimuth:g}°, {abs(height):g}° {side} the horizontal"


def view_vectors(view: View) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the unit vectors right, up and towards the viewer.

    Parameters
    ----------
    view : str or (float, float)
        A key of `VIEWS`, or azimuth and height of the viewer [degrees].

    Raises
    ------
    InputError
        If there is no such view.

    Examples
    --------
    >>> right, up, towards = view_vectors("south")
    >>> [abs(x) for x in up.round(12).tolist()]
    [0.0, 0.0, 1.0]
    """
    # the direction to the viewer, on the ground and then raised; right is level
    azimuth, height = (math.radians(angle) for angle in angles_of(view))
    ground = np.array([math.sin(azimuth), math.cos(azimuth), 0.0])
    right = np.array([-ground[1], ground[0], 0.0])
    towards = math.cos(height) * ground + math.sin(height) * np.array([0.0, 0.0, 1.0])
    return right, np.cross(towards, right), towards


def choose_exaggeration(bounds: tuple[float, ...]) -> float:
    """Return a round vertical exaggeration of 1 or more that suits the shape of the model.

    The width is the side of the square of the same area, so long and narrow models are not
    exaggerated because of their length.

    Parameters
    ----------
    bounds : (west, east, south, north, bottom, top)
        [m].

    Examples
    --------
    >>> choose_exaggeration((0, 10_000, 0, 10_000, -2500, -1500))
    4.0
    >>> choose_exaggeration((0, 100, 0, 100, 0, 500))
    1.0
    """
    west, east, south, north, bottom, top = bounds
    width, height = math.sqrt((east - west) * (north - south)), top - bottom
    if height <= 0.0 or width <= 0.0:
        return 1.0

    # the largest round value that does not exceed what reads well
    wanted = RELIEF * width / height
    return max((x for x in EXAGGERATIONS if x <= wanted), default=1.0)


def check_exaggeration(exaggeration: float | None, bounds: tuple[float, ...]) -> float:
    """Return a usable exaggeration: the one given, or a chosen one.

    Raises
    ------
    InputError
        If it is not a positive, finite number.
    """
    if exaggeration is None:
        return choose_exaggeration(bounds)
    if not (is_number(exaggeration) and exaggeration > 0.0):
        raise InputError(
            f"exaggeration is {exaggeration!r}, expected a number above 0. "
            "Leave it out for the default."
        )
    return float(exaggeration)


def check_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size of a picture in pixels, or raise an error.

    Raises
    ------
    InputError
        If these are not two whole numbers between `SMALLEST` and `LARGEST`.

    Examples
    --------
    >>> check_size((64, 64))
    Traceback (most recent call last):
    geosurf.errors.InputError: size is (64, 64), expected (width, height) in pixels, two whole numbers from (200, 150) to (8000, 8000).
    """  # noqa: E501 - a message
    listed = isinstance(size, tuple | list) or (isinstance(size, np.ndarray) and size.ndim == 1)

    # text has a length and items, too: only lists, tuples and arrays are sizes
    pair = tuple(size) if listed else ()
    if len(pair) == 2 and all(is_number(n) and n == int(n) for n in pair):
        width, height = map(int, pair)
        if SMALLEST[0] <= width <= LARGEST[0] and SMALLEST[1] <= height <= LARGEST[1]:
            return width, height
    raise InputError(
        f"size is {size!r}, expected (width, height) in pixels, two whole numbers from {SMALLEST} "
        f"to {LARGEST}."
    )


def corners(bounds: tuple[float, ...]) -> np.ndarray:
    """Return the eight corners (8, 3) of a box, west to east slowest, elevation fastest."""
    west, east, south, north, bottom, top = bounds
    box = itertools.product((west, east), (south, north), (bottom, top))
    return np.array(list(box), dtype=np.float64)


def aim(
    view: View,
    bounds: tuple[float, ...],
    size: tuple[int, int],
    exaggeration: float,
    zoom: float = 1.0,
) -> Camera:
    """Return the camera that fits a box into a picture of some size.

    Parameters
    ----------
    view : str or (float, float)
        A key of `VIEWS`, or azimuth and height of the viewer [degrees].
    bounds : (west, east, south, north, bottom, top)
        Bounds that must be visible [m].
    size : (int, int)
        Pixels across and up.
    exaggeration : float
    zoom : float
        1 fits the box into the picture; 2 shows its middle at twice the scale.
    """
    right, up, towards = view_vectors(view)
    box = corners(bounds)
    centre = (box[0] + box[-1]) / 2.0

    # the larger of both spans over the pixels that it gets
    local = (box - centre) * (1.0, 1.0, exaggeration)
    across, along = np.ptp(local @ right), np.ptp(local @ up)
    scale = max(across / size[0], along / size[1])

    # a single point has no span: any scale shows it
    if not scale > 0.0:
        scale = 1.0
    return Camera(right, up, towards, centre, exaggeration, size, float(scale) / zoom)


def bounds_of(arrays: list[np.ndarray]) -> tuple[float, float, float, float, float, float]:
    """Return west, east, south, north, bottom, top of some points, each (n, 3).

    Raises
    ------
    InputError
        If there are no points.
    """
    arrays = [points for points in arrays if len(points)]
    if not arrays:
        raise InputError(
            "the picture is empty: it has no triangles and no lines. "
            "Pass at least one surface, or add to `show`."
        )

    # layer by layer: no copy of all points
    low = np.min([points.min(axis=0) for points in arrays], axis=0)
    high = np.max([points.max(axis=0) for points in arrays], axis=0)
    (w, s, b), (e, n, t) = low.tolist(), high.tolist()
    return w, e, s, n, b, t
