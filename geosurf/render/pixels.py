"""Pixels of a picture: made from those of a larger one, and pasted into a figure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.artist import Artist


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


def pasted(image: np.ndarray, left: int, bottom: int) -> Artist:
    """
    Return pixels as a part of a figure, in which they are drawn as they are.

    `Figure.figimage` would sample them, which takes 100 bytes for each.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3 or 4)
        The first row is the top.
    left, bottom : int
        Where the lower left corner is [pixels].

    Returns
    -------
    matplotlib.artist.Artist
    """
    from matplotlib.artist import Artist

    class Pasted(Artist):
        """An image whose pixels are those of the figure."""

        def draw(self, renderer: Any) -> None:
            # renderers take four channels, the lowest row first
            opaque = np.full((*image.shape[:2], 4), 255, dtype=np.uint8)
            opaque[..., : image.shape[2]] = image[::-1]
            context = renderer.new_gc()
            renderer.draw_image(context, left, bottom, opaque)
            context.restore()

    return Pasted()


__all__ = ["averaged", "pasted"]
