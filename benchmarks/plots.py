"""The three pictures: points and lines on logarithmic axes, named where they end."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.stats import SEEN_BYTES, count_text, metres_text, seconds_text
from geosurf.errors import OutputError

Row = dict[str, Any]
INK, FAINT, RULE = "#26292e", "#7d838c", "#d8dbe0"
COLOURS = {
    "geosurf": "#c8102e",
    "compas_cgal": "#3b6ea5",
    "loop_cgal": "#2f6b3c",
    "trueform": "#8a6d1f",
    "libigl": "#7a3b58",
    "manifold3d": "#bf8145",
    "vtk": "#59616d",
    "trimesh": "#5f7f72",
}
DASHES = {"curve, kept search": (0, (1, 1.5)), "split": (0, (5, 2)), "voxels": (0, (5, 2))}
LINE, SMALL = 1.75, 8.5  # height of a label over that of its letters; those letters


def draw_errors(table: dict[str, Any], path: str | os.PathLike[str]) -> Path:
    """Draw run time against error: curves on the left, volumes on the right.

    Parameters
    ----------
    table : dict
        From `error_table`.
    path : path-like
        A ``.png`` file.

    Returns
    -------
    Path
    """
    figure, (left, right) = _figure(2, "Run time against error")
    rows = [row for row in table["rows"] if row["options"].get("method") != "tree"]
    for axes, key in ((left, "error_m"), (right, "volume_error")):
        series = {}
        for row in rows:
            if row.get(key, 0) > 0:
                series.setdefault(row["route"], []).append((row["seconds"], row[key], row))
        _lines(axes, series, bars=True, below=True)
    _name(left, "Curve of two surfaces", "run time", "Hausdorff distance to the true curve",
          seconds_text, metres_text)  # fmt: skip
    _name(
        right,
        "Units with volumes",
        "run time",
        "largest relative error of a volume",
        seconds_text,
        "{:.0e}".format,
    )
    return _save(figure, path)


def draw_growth(table: dict[str, Any], path: str | os.PathLike[str]) -> Path:
    """Draw run time and memory against the number of triangles; see `draw_errors`."""
    figure, (left, right) = _figure(2, "Cost against size: hills and one listric fault")
    powers = table["exponents"]
    for axes, key, scale, least in (
        (left, "seconds", 1.0, 0.0),
        (right, "extra_bytes", 1e-6, SEEN_BYTES),
    ):
        series = {}
        for row in table["rows"]:
            if row.get(key, 0) > least:
                power = powers.get(row["series"], {}).get(key)
                fit = "" if power is None else f"  n^{power:.2f}"
                name = row["series"] + fit
                series.setdefault(name, []).append((row["triangles"], scale * row[key], row))
        if key == "extra_bytes":
            _inputs(axes, table["rows"])
        _lines(axes, series, bars=key == "seconds")
    _name(left, "Run time", "triangles", "run time", count_text, seconds_text)
    _name(right, "Peak memory beyond what was there before the call", "triangles", "memory [MB]",
          count_text)  # fmt: skip
    return _save(figure, path)


def draw_questions(table: dict[str, Any], path: str | os.PathLike[str]) -> Path:
    """Draw run time against what is asked of a scene; see `draw_errors`."""
    rows = [row for row in table["rows"] if not row["error"]]
    asked = list(dict.fromkeys(row["asked"] for row in table["rows"]))
    sizes = sorted({row["size"] for row in rows})
    figure, [axes] = _figure(1, "Run time against what is asked of a fresh scene", height=3.6)
    shades = ["#e9a3ad", COLOURS["geosurf"]][-len(sizes) :] if sizes else []
    for k, size in enumerate(sizes):
        colour = shades[min(k, len(shades) - 1)]
        mine = [row for row in rows if row["size"] == size]
        places = [asked.index(row["asked"]) for row in mine]
        for row, y in zip(mine, places, strict=True):
            axes.plot([row["fastest"], row["slowest"]], [y, y], color=colour, lw=1.2)
            axes.annotate(
                seconds_text(row["seconds"]), (row["seconds"], y), (0, -15 if k == 0 else 8),
                textcoords="offset points", ha="center", color=INK, fontsize=SMALL,
            )  # fmt: skip
        name = f"{count_text(mine[0]['triangles'])} triangles"
        times = [row["seconds"] for row in mine]
        axes.plot(times, places, "o", color=colour, ms=7, label=name)
    if sizes:
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False, fontsize=9)
    axes.set_yticks(range(len(asked)), asked)
    axes.set_ylim(len(asked) - 0.4, -0.6)
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    axes.set_xlim(low / 1.6, high * 1.6)
    axes.grid(True, axis="x", color=RULE, lw=0.6)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("run time")
    axes.xaxis.set_major_formatter(lambda value, _: seconds_text(value))
    return _save(figure, path)


# ---- what they share -------------------------------------------------------------------


def _figure(columns: int, title: str, height: float = 5.2) -> tuple[Any, Sequence[Any]]:
    """White paper with some axes; nothing of matplotlib's global state is touched."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.6 * columns if columns > 1 else 8.6, height), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title, fontsize=13, weight="bold", color=INK, x=0.01, ha="left")
    figure.get_layout_engine().set(wspace=0.06, w_pad=0.1, h_pad=0.1)
    axes = [figure.add_subplot(1, columns, k + 1) for k in range(columns)]
    for one in axes:
        for side in ("top", "right"):
            one.spines[side].set_visible(False)
        for side in ("left", "bottom"):
            one.spines[side].set_color(FAINT)
        one.tick_params(colors=INK, which="both", labelsize=9)
        one.set_axisbelow(True)
    return figure, axes


def _name(axes: Any, title: str, across: str, up: str, *formats: Callable | None) -> None:
    """Words at the axes; formats turn values across and up into words, None leaves powers."""
    axes.set_title(title, fontsize=10.5, color=INK, loc="left")
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    for axis, words in zip((axes.xaxis, axes.yaxis), formats, strict=False):
        if words is not None:
            axis.set_major_formatter(lambda value, _, words=words: words(value))


def _inputs(axes: Any, rows: list[Row]) -> None:
    """A faint line: the size of the grids themselves."""
    seen = {row["triangles"]: row["input_bytes"] for row in rows
            if not row["error"] and row["who"] == "geosurf"}  # fmt: skip
    sizes = sorted(seen)
    if not sizes:
        return
    axes.plot(sizes, [1e-6 * seen[n] for n in sizes], color=FAINT, lw=1, zorder=1)
    axes.annotate(
        "the grids", (sizes[0], 1e-6 * seen[sizes[0]]), (2, -11), color=FAINT, fontsize=8.5,
        textcoords="offset points",
    )  # fmt: skip


def _lines(
    axes: Any, series: dict[str, list[tuple[float, float, Row]]], *, bars: bool, below: bool = False
) -> None:
    """Lines through the points of each series; names stand to the right of the axes, or below."""
    ends = []
    for name, points in series.items():
        points = sorted(points, key=lambda p: p[2]["size"])
        x, y = [p[0] for p in points], [p[1] for p in points]
        row = points[0][2]
        colour = COLOURS.get(row["who"], INK)
        dash = DASHES.get(row["options"].get("method", row["task"]), "-")
        if "tolerance" in row["options"]:
            dash = (0, (2, 1))
        heavy = row["who"] == "geosurf"
        wide, size = (2.0, 5) if heavy else (1.3, 4)
        axes.plot(x, y, ls=dash, color=colour, lw=wide, marker="o", ms=size, zorder=3 + heavy)
        _mark_wrong(axes, points, colour)
        if bars:
            _spreads(axes, points, colour)
        ends.append((x[-1], y[-1], name, colour))
    if not ends:
        axes.text(0.5, 0.5, "nothing was measured", ha="center", transform=axes.transAxes)
        axes.set_xticks([])
        axes.set_yticks([])
        return
    _decades(axes)
    if below:
        _labels_below(axes, ends)
    else:
        _labels_beside(axes, ends)


def _decades(axes: Any) -> None:
    """Logarithmic axes that show a decade at least, named at its powers of ten."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, which="major", color=RULE, lw=0.6)
    for axis, limits, fix in (
        (axes.xaxis, axes.get_xlim(), axes.set_xlim),
        (axes.yaxis, axes.get_ylim(), axes.set_ylim),
    ):
        low, high = limits
        if high / low < 12.0:
            middle = math.sqrt(low * high)
            low, high = middle / 12**0.5, middle * 12**0.5
        fix(low, high)
        steps = (1.0, 2.0, 5.0) if high / low < 200.0 else (1.0,)
        axis.set_major_locator(LogLocator(subs=steps, numticks=12))
        axis.set_minor_formatter(NullFormatter())


def _mark_wrong(axes: Any, points: list[tuple[float, float, Row]], colour: str) -> None:
    """Wrong results are hollow."""
    wrong = [(x, y) for x, y, row in points if row["wrong"]]
    if wrong:
        axes.plot(*zip(*wrong, strict=True), "o", mfc="white", mec=colour, ms=6, zorder=5)


def _spreads(axes: Any, points: list[tuple[float, float, Row]], colour: str) -> None:
    """A thin line from the fastest repeat to the slowest, along the axis of time."""
    for x, y, row in points:
        span = [row["fastest"], row["slowest"]]
        along = (span, [y, y]) if x == row["seconds"] else ([x, x], span)
        axes.plot(*along, color=colour, lw=0.8, alpha=0.6, zorder=2)


def _labels_beside(axes: Any, ends: list[tuple[float, float, str, str]]) -> None:
    """Names to the right of the axes, at the heights of their lines and clear of each other."""
    axes.figure.draw_without_rendering()
    to_axes = axes.transData + axes.transAxes.inverted()
    points = axes.get_window_extent().height * 72.0 / axes.figure.dpi
    wanted = sorted((float(to_axes.transform((x, y))[1]), x, y, n, c) for x, y, n, c in ends)
    heights = _apart([w[0] for w in wanted], LINE * SMALL / points)
    for height, (_, x, y, name, colour) in zip(heights, wanted, strict=True):
        axes.annotate(
            name, (x, y), (1.03, height), textcoords="axes fraction", va="center", color=colour,
            fontsize=SMALL, annotation_clip=False, arrowprops=_leader(colour, 0.0),
        )  # fmt: skip


def _labels_below(axes: Any, ends: list[tuple[float, float, str, str]]) -> None:
    """Names under the ends of their lines, one below the other from left to right."""
    axes.figure.draw_without_rendering()
    points = axes.get_window_extent().height * 72.0 / axes.figure.dpi
    step = LINE * SMALL / points
    low, high = axes.get_ylim()
    room = step * (len(ends) + 1)
    axes.set_ylim(high / (high / low) ** (1.0 / (1.0 - room)), high)
    to_axes = axes.transData + axes.transAxes.inverted()
    for k, (x, y, name, colour) in enumerate(sorted(ends)):
        side = "left" if to_axes.transform((x, y))[0] < 0.2 else "right"
        axes.annotate(
            name, (x, y), (x, room - step * (k + 1)), textcoords=("data", "axes fraction"),
            ha=side, va="center", color=colour, fontsize=SMALL,
            arrowprops=_leader(colour, float(side == "right")),
        )  # fmt: skip


def _leader(colour: str, end: float) -> dict[str, Any]:
    """A thin line to what is named, from the left (0) or right (1) end of the name."""
    return {"arrowstyle": "-", "color": colour, "lw": 0.5, "alpha": 0.6, "shrinkA": 1,
            "shrinkB": 5, "relpos": (end, 0.5)}  # fmt: skip


def _apart(heights: list[float], step: float) -> list[float]:
    """Move ascending heights as little as needed so that they are a step apart.

    Examples
    --------
    >>> [round(h, 6) for h in _apart([0.0, 0.01, 0.5], 0.1)]
    [-0.045, 0.055, 0.5]
    """
    groups: list[list[float]] = []  # centre, number of members
    for height in heights:
        groups.append([height, 1])
        while len(groups) > 1:
            (below, m), (above, n) = groups[-2:]
            if above - below >= step * (m + n) / 2:
                break
            groups[-2:] = [[(m * below + n * above) / (m + n), m + n]]
    return [c + step * (k - (n - 1) / 2) for c, n in groups for k in range(int(n))]


def _save(figure: Any, path: str | os.PathLike[str]) -> Path:
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(path, dpi=160, facecolor="white")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error}). Choose another -o.") from error
    return path
