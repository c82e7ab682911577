"""An interactive view in three dimensions: a part of the report, or a page of its own.

Places are counted in 65 535 steps along each axis of the model, so a page needs six bytes for a
point. Triangles of different surfaces share no points: that makes their edges sharp. Everything is
written as little-endian base64; `assets/viewer_*.js` draws it, with WebGL 2 if
the browser has it.
"""

from __future__ import annotations

import base64
import json
from string import Template
from typing import Any

import numpy as np

from geosurf.model.protocols import Body, View3D
from geosurf.report.assets import asset, document, viewer_script

STEPS = 65_535
SHORT = 1 << 16  # points that two bytes can number


def viewer_html(view: View3D, title: str = "Model") -> str:
    """Return a self-contained HTML page with an interactive view; it needs no network.

    Parameters
    ----------
    view : View3D
        From `geosurf.render.interactive`.
    title : str

    Returns
    -------
    str
        The page. The same view gives the same text.

    Examples
    --------
    >>> import geosurf as gs
    >>> from geosurf.render.interactive import view_of_units
    >>> world = gs.synthetic.tilted_planes(n=3)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> page = viewer_html(view_of_units(units), "Planes")
    >>> "<title>Planes</title>" in page and "src=" not in page
    True
    """
    styles, scripts = (asset("theme.css"), asset("viewer.css")), (viewer_script(),)
    return document(title, viewer_part(view), styles, scripts)


def viewer_part(view: View3D) -> str:
    """Return the view as a part of a page that has the style sheet and script of the viewer."""
    head, data = pack(view)

    # `<` may not appear in a script: it could end it
    words = json.dumps(head, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    code = base64.b64encode(data).decode("ascii")
    return Template(asset("viewer.html")).substitute(head=words, data=code)


def pack(view: View3D) -> tuple[dict[str, Any], bytes]:
    """Return what describes the bodies, and their arrays as bytes."""
    points = [body.points for body in view.bodies if len(body.points)]
    west, east, south, north, bottom, top = view.box
    corners = np.array([(west, south, bottom), (east, north, top)])
    low = np.min([corners[0], *(p.min(axis=0) for p in points)], axis=0)
    high = np.max([corners[1], *(p.max(axis=0) for p in points)], axis=0)

    # a model without height has steps of any size
    step = np.where(high > low, high - low, 1.0) / STEPS
    data = bytearray()
    bodies = [_packed(body, low, step, data) for body in view.bodies]
    head = {
        "lower": [_short(x) for x in low],
        "step": [float(x) for x in step],
        "box": [_short(x - low[i // 2]) for i, x in enumerate(view.box)],
        "exaggeration": view.exaggeration,
        "explode": view.explode,
        "bodies": bodies,
    }
    return head, bytes(data)


def _packed(body: Body, low: np.ndarray, step: np.ndarray, data: bytearray) -> dict[str, Any]:
    """Append the arrays of a body to `data`; return its description."""
    # one point for each surface and place: what a step does not tell apart is one point
    places = np.rint((body.points - low) / step).astype(np.int64)
    span = STEPS + 1
    code = (places[:, 0] * span + places[:, 1]) * span + places[:, 2]
    place = np.unique(code, return_inverse=True)[1].ravel()
    n = int(place.max(initial=0)) + 1
    keys = body.surface[:, None] * n + place[body.triangles]
    a, b, c = keys.T
    keys = keys[(a != b) & (b != c) & (c != a)]

    # lines take any of the points at their ends; a body of lines has no others
    ends = place[body.lines].reshape(-1, 2)
    ends = ends[ends[:, 0] != ends[:, 1]]
    bare = ends if not len(body.triangles) else ends[:0]
    used, rows = np.unique(np.concatenate([keys.ravel(), bare.ravel()]), return_inverse=True)
    triangles = rows.ravel()[: keys.size]
    here = np.zeros(n, dtype=np.int64)
    here[place] = np.arange(len(place))
    of_place = np.full(n, -1)
    of_place[used % n] = np.arange(len(used))
    lines = of_place[ends]
    lines = lines[(lines >= 0).all(axis=1)]
    places = places[here[used % n]]
    kind = "u2" if len(used) <= SHORT else "u4"
    arrays = {"points": (places, "u2"), "triangles": (triangles, kind), "lines": (lines, kind)}
    return {
        "name": body.name,
        "group": body.group,
        "colour": "#" + "".join(f"{round(255 * value):02x}" for value in body.colour),
        "facts": body.facts,
        "shift": [_short(x) for x in body.shift],
        "closed": body.closed,
        "on": body.shown,
        **{name: _append(array, kind, data) for name, (array, kind) in arrays.items()},
    }


def _append(array: np.ndarray, kind: str, data: bytearray) -> tuple[str, int, int]:
    """Append an array at a multiple of four bytes; return its kind, offset and length."""
    data.extend(bytes(-len(data) % 4))
    offset = len(data)
    data.extend(np.ascontiguousarray(array, dtype=f"<{kind}").tobytes())
    return kind, offset, int(array.size)


def _short(value: float) -> float:
    """Millimetres are enough."""
    return round(float(value), 3)
