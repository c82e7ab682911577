"""Draw the axes of the model box: round tick values, numbers and names."""

from __future__ import annotations

import math
from itertools import compress

import numpy as np

from geosurf.render import palette
from geosurf.render.furniture import Sheet, fitting, rim_of_words, tick_texts, ticks
from geosurf.render.views import Camera, corners

AXES = (("Easting", "km", 1000.0), ("Northing", "km", 1000.0), ("Elevation", "m", 1.0))
END_ON = 0.06  # an axis shorter than this fraction of the picture gets no labels


def draw_axes(sheet: Sheet, camera: Camera, bounds: tuple[float, ...]) -> None:
    """Label the visible edges of the box."""
    offset = np.array([sheet.layout.left, sheet.layout.bottom])
    box = corners(bounds)
    pixels = camera.to_pixels(box) + offset
    middle = pixels.mean(axis=0)

    # middles of numbers written so far: axes meet at corners, where they would overlap
    taken: list[np.ndarray] = []
    for axis, (name, unit, per) in enumerate(AXES):
        # the edge on the outline of the box, so that numbers stay outside of it
        edge = _outer_edge(pixels, axis, min(camera.size) * END_ON)
        if edge is None:
            continue

        # round values between its ends, as many as fit
        low, high = box[edge[0]], box[edge[1]]
        length = float(np.linalg.norm(pixels[edge[1]] - pixels[edge[0]]))
        texts_fit = fitting(length, sheet.layout.unit)
        values = ticks(low[axis], high[axis], min(texts_fit, 4 if axis == 2 else 5))
        texts = tick_texts(values, per)
        part = (values - low[axis]) / (high[axis] - low[axis])

        # unit vectors in pixels: along the edge, and away from the middle of the box
        ends = pixels[list(edge)]
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        outward = np.array([along[1], -along[0]])
        if outward @ (ends.mean(axis=0) - middle) < 0.0:
            outward = -outward
        places = ends[0] + part[:, None] * (ends[1] - ends[0])

        # a picture at a larger scale shows only a part of the box
        here = _inside(sheet, places)
        _draw_axis(sheet, places[here], list(compress(texts, here)), outward, taken)
        if _inside(sheet, ends.mean(axis=0)[None])[0]:
            _name_axis(sheet, ends.mean(axis=0), f"{name} [{unit}]", along, outward, texts)


def _inside(sheet: Sheet, places: np.ndarray) -> np.ndarray:
    """Whether each pixel (n, 2) is in the rectangle of the view."""
    low = np.array([sheet.layout.left, sheet.layout.bottom])
    high = low + sheet.layout.view_size
    off = np.abs(places - 0.5 * (low + high)) - 0.5 * (high - low)
    found: np.ndarray = off.max(axis=1) <= 0.5
    return found


def _outer_edge(pixels: np.ndarray, axis: int, shortest: float) -> tuple[int, int] | None:
    """The lowest edge for horizontal axes, the leftmost for elevation; None if seen end-on."""
    # corners are numbered in binary: the edges of an axis differ in its bit only
    bit = (4, 2, 1)[axis]
    edges = [(i, i | bit) for i in range(8) if not i & bit]
    length = np.linalg.norm(pixels[edges[0][1]] - pixels[edges[0][0]])
    if length < shortest:
        return None

    # rounded, so that equal edges of a symmetric view are chosen in the same order
    middles = [pixels[list(edge)].mean(axis=0).round(3) for edge in edges]
    keys = [(m[0], m[1]) if axis == 2 else (m[1], m[0]) for m in middles]
    return edges[min(range(4), key=keys.__getitem__)]


def _draw_axis(
    sheet: Sheet,
    places: np.ndarray,
    texts: list[str],
    outward: np.ndarray,
    taken: list[np.ndarray],
) -> None:
    """Draw ticks and numbers; a number that would overlap one in `taken` is left out."""
    unit = sheet.layout.unit
    x, y = outward
    for place, words in zip(places, texts, strict=True):
        sheet.line([place, place + 6.0 * unit * outward], 1.0, palette.FAINT)
        about = place + 30.0 * unit * outward  # the middle of the number
        if any(np.hypot(*(about - other)) < 28.0 * unit for other in taken):
            continue
        taken.append(about)
        sheet.text(
            place + 11.0 * unit * outward,
            words,
            12.0,
            ha="left" if x > 0.4 else "right" if x < -0.4 else "center",
            va="bottom" if y > 0.8 else "top" if y < -0.4 else "center",
            path_effects=rim_of_words(unit),
        )


def _name_axis(
    sheet: Sheet,
    at: np.ndarray,
    words: str,
    along: np.ndarray,
    outward: np.ndarray,
    texts: list[str],
) -> None:
    """Write the name along its axis, outside the numbers, never upside down."""
    angle = math.degrees(math.atan2(along[1], along[0]))

    # between -90 and 90 degrees: never upside down
    angle = (angle + 90.0) % 180.0 - 90.0
    # the numbers are as wide as their longest, and one line high
    wide = 7.6 * max(map(len, texts), default=0)
    distance = 25.0 + wide * abs(outward[0]) + 14.0 * abs(outward[1])
    place = at + distance * sheet.layout.unit * outward
    if abs(angle + 90.0) < 1e-6:
        angle = 90.0
    sheet.text(
        place,
        words,
        13.0,
        ha="center",
        va="center",
        path_effects=rim_of_words(sheet.layout.unit),
        rotation=angle,
        rotation_mode="anchor",
    )
