"""What well tops change at each vertex of a cut horizon, by distances that go around faults."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from geosurf.conventions import length_text, place
from geosurf.errors import GeometryError, InputError
from geosurf.kernels.lattices.sets import ranges
from geosurf.model.tops import TieSettings, Tops
from geosurf.sheets.tie.controls import Controls, CutHorizon

STEEPEST = 0.5  # change of the correction over distance beyond which two tops contradict
FEWEST_CELLS = 3.0  # a range that cells can follow
OVERSHOOT = 3.0  # times the largest residual


def correction(
    cut: CutHorizon, controls: Controls, tops: Tops, settings: TieSettings, *, check: bool
) -> np.ndarray:
    """
    Return the change of elevation at each vertex of a cut horizon.

    Parameters
    ----------
    cut : CutHorizon
    controls : Controls
    tops : Tops
    settings : TieSettings
    check : bool
        Whether the tops are compared with each other, which the first correction needs.

    Returns
    -------
    ndarray of float64, shape (n_vertex,)
        [m]

    Raises
    ------
    InputError
        If the range is too small for the cells, or two tops contradict each other.
    """
    reach = settings.range
    if reach < FEWEST_CELLS * cut.cell:
        raise InputError(
            f"the tie has a range of {length_text(reach)}, less than {FEWEST_CELLS:g} cells of "
            f"horizon {tops.horizons[controls.top[0]]!r}. Give at least "
            f'tie={{"range": {np.ceil(FEWEST_CELLS * cut.cell):.0f}}}.'
        )

    # one field for each top: vertices in reach, and their distance around faults
    fields = [
        map_distances(cut.x, cut.triangles, cut.walls, start, tops.points[row, :2], reach)
        for row, start in zip(controls.top.tolist(), controls.triangle.tolist(), strict=True)
    ]
    far = _distances_between(cut, controls, fields)
    groups = _groups(far, cut.cell)
    if check:
        _refuse_contradictions(controls, tops, far, groups, settings)

    # tops in one cell act as one: the mean of them meets the mean of their residuals
    mean = (groups == np.arange(groups.max() + 1)[:, None]) / np.bincount(groups)[:, None]

    # acts (n, n): how top k (column) acts at top i. Least squares, should the matrix be singular
    acts = np.stack([_at_controls(cut, controls, field, reach) for field in fields], axis=1)
    weights = np.linalg.lstsq(mean @ acts @ mean.T, mean @ controls.residual)[0] @ mean

    change = np.zeros(len(cut.x))
    for weight, (vertices, distance) in zip(weights.tolist(), fields, strict=True):
        change[vertices] += weight * wendland(distance / reach)

    # an overshoot: several tops contradict each other, though no pair of them does by itself
    if np.abs(change).max(initial=0.0) > OVERSHOOT * controls.largest:
        _refuse_steepest(controls, tops, far)
    return change


def wendland(q: np.ndarray) -> np.ndarray:
    """Share of a correction at a distance over the range.

    Examples
    --------
    >>> wendland(np.array([0.0, 0.5, 1.0, 2.0])).tolist()
    [1.0, 0.1875, 0.0, 0.0]
    """
    inside = np.maximum(1.0 - q, 0.0)
    return inside**4 * (1.0 + 4.0 * q)


def _at_controls(
    cut: CutHorizon, controls: Controls, field: tuple[np.ndarray, np.ndarray], reach: float
) -> np.ndarray:
    """How one top acts at all of them, as the triangles interpolate it."""
    vertices, distance = field

    # interpolated as the mesh is, not read off exactly: so the mesh itself meets the top
    value = np.zeros(len(cut.x))
    value[vertices] = wendland(distance / reach)
    return (value[cut.triangles[controls.triangle]] * controls.share).sum(axis=1)


def _distances_between(
    cut: CutHorizon, controls: Controls, fields: list[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """Distances (n, n) between tops that do not cross a fault [m]; infinite beyond the range."""
    n = len(fields)
    far = np.full((n, n), np.inf)
    value = np.full(len(cut.x), np.nan)
    corners = cut.triangles[controls.triangle]
    for k, (vertices, distance) in enumerate(fields):
        # NaN at a corner out of reach, or behind a fault, makes the pair infinitely far apart
        value[vertices] = distance
        weighed = np.where(controls.share > 0, value[corners] * controls.share, 0.0).sum(axis=1)
        far[:, k] = np.where(np.isnan(weighed), np.inf, weighed)
        value[vertices] = np.nan
    far[np.arange(n), np.arange(n)] = 0.0

    # both directions are computed; rounding, and reach, may make one of them shorter
    return np.minimum(far, far.T)


def _groups(far: np.ndarray, cell: float) -> np.ndarray:
    """Number of the group of each top: tops less than a cell apart are in one."""
    return connected_components(far < cell, directed=False)[1]


def _refuse_contradictions(
    controls: Controls, tops: Tops, far: np.ndarray, groups: np.ndarray, settings: TieSettings
) -> None:
    """Refuse two tops that no smooth correction meets."""
    # in one cell residuals may differ by little, farther apart by a slope of STEEPEST
    apart = np.abs(controls.residual[:, None] - controls.residual[None, :])
    together = groups[:, None] == groups[None, :]
    allowed = np.where(together, 1.5 * settings.tolerance, STEEPEST * far)
    excess = np.where(np.isfinite(far) & (apart > allowed), apart / np.maximum(far, 1.0), 0.0)
    if excess.any():
        _refuse(controls, tops, far, int(excess.argmax()))


def _refuse_steepest(controls: Controls, tops: Tops, far: np.ndarray) -> None:
    """Name the two tops between which the correction is steepest."""
    apart = np.abs(controls.residual[:, None] - controls.residual[None, :])
    slope = np.where(np.isfinite(far), apart / np.maximum(far, 1.0), 0.0)
    _refuse(controls, tops, far, int(slope.argmax()))


def _refuse(controls: Controls, tops: Tops, far: np.ndarray, pair: int) -> None:
    """Name both tops of a pair, an entry of the matrix of distances."""
    i, j = sorted(divmod(pair, len(far)))
    first, second = controls.top[i], controls.top[j]
    raise GeometryError(
        f"well tops of {tops.horizons[first]!r} contradict each other: wells {tops.wells[first]!r} "
        f"and {tops.wells[second]!r} are {length_text(far[i, j])} apart on one side of all faults, "
        f"near {place(tops.points[first])}, and need corrections of "
        f"{controls.residual[i]:.4g} m and {controls.residual[j]:.4g} m. Correct or leave out one "
        "of them, or add the fault between them.",
        place=tops.points[first],
        surfaces=(tops.horizons[first],),
    )


# ---- distances ----------------------------------------
# Along the map, from a point of the mesh around the walls of faults.


SETTLED = 1e-10  # of the reach: gains below this end the spreading
SLIGHT = 1e-9  # [rad] and of lengths: a line that passes a wall so closely is taken as crossing it


def map_distances(
    x: np.ndarray,
    triangles: np.ndarray,
    walls: np.ndarray,
    start: int,
    source: np.ndarray,
    reach: float,
) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the vertices nearer than `reach` to a point of the mesh, and their distances.

    Parameters
    ----------
    x : ndarray of float64, shape (n_vertex, 3) or (n_vertex, 2)
        Only easting and northing count [m].
    triangles : ndarray of int64, shape (n, 3)
        Rows of `x`.
    walls : ndarray of int64, shape (n_wall, 2)
        Edges along which a fault cuts the mesh, rows of `x`.
    start : int
        Row of the triangle that holds the point.
    source : ndarray of float64, shape (2,)
        Easting and northing of the point [m].
    reach : float
        [m]

    Returns
    -------
    (ndarray of int64, ndarray of float64)
        Vertices in increasing order, and distances [m].

    Examples
    --------
    >>> x = np.array([[0.0, 0], [4, 0], [0, 3], [4, 3]])
    >>> square = np.array([[0, 1, 2], [1, 3, 2]])
    >>> nothing = np.empty((0, 2), dtype=np.int64)
    >>> vertices, far = map_distances(x, square, nothing, 0, np.zeros(2), 10.0)
    >>> vertices.tolist(), far.round(9).tolist()
    ([0, 1, 2, 3], [0.0, 4.0, 3.0, 5.0])
    """
    # p (n_vertex, 2): from the point, so that it is the origin of all lines of sight
    p = x[:, :2] - source
    straight = np.hypot(*p.T)

    # no way along the sheet is shorter than the straight one: nothing else can be in reach
    near = straight < reach
    near[triangles[start]] = True
    used = np.flatnonzero(near)

    # hidden: vertices behind a wall; those of the start's own triangle never are
    hidden = _hidden(p[used], p[walls[near[walls].any(axis=1)]])
    hidden &= ~np.isin(used, triangles[start])
    far = np.full(len(x), np.inf)
    far[used[~hidden]] = straight[used[~hidden]]
    if hidden.any():
        # only triangles with a hidden corner can shorten anything: spread in these alone
        behind = np.zeros(len(x), dtype=bool)
        behind[used[hidden]] = True
        _spread(p, triangles[behind[triangles].any(axis=1)], far, reach)
    inside = np.flatnonzero(far < reach)
    return inside, far[inside]


def _hidden(p: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Whether a wall (n, 2, 2) lies between the origin and points (n, 2), or touches the line.

    Only points in the angle of a wall are compared with it.
    """
    hidden = np.zeros(len(p), dtype=bool)
    if not len(walls):
        return hidden

    # points by angle: each wall is compared only with those between the angles of its ends
    angle = np.arctan2(p[:, 1], p[:, 0])
    order = np.argsort(angle, kind="stable")
    sorted_angle = angle[order]
    ends = np.arctan2(walls[:, :, 1], walls[:, :, 0])
    low, high = ends.min(axis=1) - SLIGHT, ends.max(axis=1) + SLIGHT

    # a wall that crosses due west, where angles jump, is looked at in two parts
    around = high - low > np.pi  # the angle goes across west
    pairs = [
        (np.flatnonzero(~around), low[~around], high[~around]),
        (np.flatnonzero(around), np.full(around.sum(), -np.inf), low[around] + 2 * SLIGHT),
        (np.flatnonzero(around), high[around] - 2 * SLIGHT, np.full(around.sum(), np.inf)),
    ]
    for which, left, right in pairs:
        first = np.searchsorted(sorted_angle, left, "left")
        count = np.searchsorted(sorted_angle, right, "right") - first

        # all pairs (wall, point in its angle), one row each
        row, place_in_order = ranges(first, count)
        wall, point = which[row], order[place_in_order]

        # beyond: on the other side of the wall's line than the origin, or within rounding of it
        a, b, v = walls[wall, 0], walls[wall, 1], p[point]
        along, size = b - a, np.hypot(*(b - a).T)
        of_point = along[:, 0] * (v - a)[:, 1] - along[:, 1] * (v - a)[:, 0]
        of_origin = along[:, 1] * a[:, 0] - along[:, 0] * a[:, 1]
        beyond = of_point * np.sign(of_origin) <= SLIGHT * size * (size + np.hypot(*v.T))
        hidden[point[beyond]] = True
    return hidden


def _spread(p: np.ndarray, faces: np.ndarray, far: np.ndarray, reach: float) -> None:
    """Shorten distances `far` of the corners of faces until no way through a face is shorter."""
    # corner: vertices at all corners, sorted; order // 3: the triangles that have each
    flat = faces.ravel()
    order = np.argsort(flat, kind="stable")
    corner = flat[order]

    # the front: vertices whose distance is known or has become shorter
    changed = np.unique(flat)
    changed = changed[np.isfinite(far[changed])]
    best = far.copy()
    while len(changed):
        # triangles around the front, and what they give for each of their corners
        first, last = (np.searchsorted(corner, changed, side) for side in ("left", "right"))
        _, at_front = ranges(first, last - first)
        corners, shortest = _across(p, faces[np.unique(order[at_front] // 3)], far)
        np.minimum.at(best, corners, shortest)
        touched = np.unique(corners)

        # gains below the last digits end it: distances fall and are bounded, so that it ends
        gained = best[touched] < np.minimum(far[touched] - SETTLED * reach, reach)
        changed = touched[gained]
        far[changed] = best[changed]
        best[touched] = far[touched]


def _across(p: np.ndarray, faces: np.ndarray, far: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners, and the distance of each through its triangle or along its edges."""
    corners, distances = [], []
    for k in range(3):
        # each corner from the other two: along an edge, or straight through the triangle
        c, a, b = (faces[:, (k + j) % 3] for j in range(3))
        along_a = far[a] + np.hypot(*(p[c] - p[a]).T)
        along_b = far[b] + np.hypot(*(p[c] - p[b]).T)
        through = _through(p[a], p[b], p[c], far[a], far[b])
        corners.append(c)
        distances.append(np.minimum(np.minimum(along_a, along_b), through))
    return np.concatenate(corners), np.concatenate(distances)


def _through(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, far_a: np.ndarray, far_b: np.ndarray
) -> np.ndarray:
    """Distance of c by a straight line that crosses ab; infinite where none does."""
    base = b - a
    length = np.hypot(*base.T)

    # coordinates along ab and away from it; triangles without area give NaN, which counts as
    # no way
    with np.errstate(invalid="ignore", divide="ignore"):
        along = base / length[:, None]
        to_c = c - a
        cx = (to_c * along).sum(axis=1)
        cy = np.abs(along[:, 0] * to_c[:, 1] - along[:, 1] * to_c[:, 0])
        # the image of the point: where circles around a and b meet, on the side away from c
        sx = (far_a * far_a - far_b * far_b + length * length) / (2.0 * length)
        sy = np.sqrt(far_a * far_a - sx * sx)

        # the straight line from the image to c crosses ab here; outside of it, the edges are
        # shorter
        crossing = sx + (cx - sx) * sy / (cy + sy)
        is_straight = (crossing >= 0.0) & (crossing <= length) & (cy > 0.0)
        distance = np.hypot(cx - sx, cy + sy)
    return np.where(is_straight & np.isfinite(distance), distance, np.inf)
