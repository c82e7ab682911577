"""Minimum curvature: from measured depths and directions of a well to places along it.

Between two stations the path is an arc of a circle that has the directions of both as its
tangents, the method of the industry. Straight lines between stations would leave the arc by
several metres where stations are far apart, so points are added along each arc.
"""

from __future__ import annotations

import numpy as np

SAG = 0.01  # m: how far a straight line between two points may be from the arc


def along_arcs(
    md: np.ndarray, inclination: np.ndarray, azimuth: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return places along a well relative to its first station, and their measured depths.

    Parameters
    ----------
    md : ndarray of float64, shape (n,)
        Measured depths of the stations [m], which rise.
    inclination, azimuth : ndarray of float64, shape (n,)
        Angles from the vertical, and clockwise from grid north [degrees]. The directions of two
        neighbours are not opposite.

    Returns
    -------
    (ndarray of float64, shape (m, 3), ndarray of float64, shape (m,))
        East, north and up [m], and measured depths [m]: of all stations, and of points between
        them, so that straight lines are within 1 cm of the arcs.

    Examples
    --------
    >>> import numpy as np
    >>> quarter = 500.0 * np.pi  # an arc with a radius of 1000 m, from the vertical to the east
    >>> places, _ = along_arcs(np.array([0.0, quarter]), np.array([0.0, 90.0]), np.full(2, 90.0))
    >>> places[-1].round(9).tolist()
    [1000.0, 0.0, -1000.0]
    """
    inc, azi = np.radians(inclination), np.radians(azimuth)
    tangents = np.column_stack([np.sin(inc) * np.sin(azi), np.sin(inc) * np.cos(azi), -np.cos(inc)])
    one, two = tangents[:-1], tangents[1:]
    length = np.diff(md)

    # the angle between two directions from sine and cosine is accurate for small ones, too
    cosine = (one * two).sum(axis=1)
    sine = np.linalg.norm(np.cross(one, two), axis=1)
    angle = np.arctan2(sine, cosine)
    across = two - one * cosine[:, None]
    across /= np.where(sine > 0.0, sine, 1.0)[:, None]

    # so many pieces that no straight one is farther than SAG from its arc
    with np.errstate(divide="ignore"):
        flat = np.where(angle > 0.0, SAG * angle / length, 0.0)
    widest = 2.0 * np.arccos(np.maximum(1.0 - flat, -1.0))
    count = np.ceil(np.divide(angle, widest, out=np.ones_like(angle), where=angle > 0.0))
    count = np.maximum(count.astype(np.int64), 1)
    piece = np.repeat(np.arange(len(length)), count)
    share = np.concatenate([np.arange(1, n + 1) / n for n in count])

    # on the arc: R sin(phi) along the first direction, R (1 - cos(phi)) across, with R = L / angle
    turned = share * angle[piece] / np.pi
    along = share * np.sinc(turned)
    aside = share * np.sinc(0.5 * turned) * np.sin(0.5 * np.pi * turned)
    moved = length[piece, None] * (along[:, None] * one[piece] + aside[:, None] * across[piece])
    ends = np.cumsum(count) - 1
    starts = np.concatenate([np.zeros((1, 3)), np.cumsum(moved[ends], axis=0)])
    places = np.concatenate([np.zeros((1, 3)), starts[piece] + moved])
    depths = md[piece] + share * length[piece]
    depths[ends] = md[1:]
    return places, np.concatenate([md[:1], depths])


__all__ = ["SAG", "along_arcs"]
