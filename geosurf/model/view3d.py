"""What an interactive view shows: bodies with few enough triangles, their colours and numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Body:
    """One unit or surface of an interactive view.

    Attributes
    ----------
    name : str
    group : str
        Bodies of one group can be shown and hidden together: a zone, or a role.
    colour : (red, green, blue)
        From 0 to 1.
    points : ndarray of float64, shape (n_point, 3)
        World coordinates [m].
    triangles : ndarray of int64, shape (n_triangle, 3)
        Outward normals, where the body is closed.
    surface : ndarray of int64, shape (n_triangle,)
        Triangles of different surfaces meet at a sharp edge.
    lines : ndarray of int64, shape (n_line, 2)
        Edges that are drawn as lines.
    facts : tuple of (str, str)
        What a reader learns who picks it: ``(("Zone", "Top/Base"), ...)``.
    shift : (float, float, float)
        By how much it moves where the view is exploded in full [m].
    closed : bool
        Whether the triangles bound a volume.
    shown : bool
        Whether it is visible at first.
    """

    name: str
    group: str
    colour: tuple[float, float, float]
    points: np.ndarray
    triangles: np.ndarray
    surface: np.ndarray
    lines: np.ndarray
    facts: tuple[tuple[str, str], ...] = ()
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    closed: bool = True
    shown: bool = True


@dataclass(frozen=True, eq=False)
class View3D:
    """The content of an interactive view.

    Attributes
    ----------
    bodies : tuple of Body
    box : (west, east, south, north, bottom, top)
        Whose edges are drawn [m].
    exaggeration : float
        Vertical exaggeration at first.
    explode : float
        Of the shifts of bodies, from 0 to 1, at first.
    """

    bodies: tuple[Body, ...]
    box: tuple[float, ...]
    exaggeration: float = 1.0
    explode: float = 0.0
