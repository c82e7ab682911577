"""Charts of an ensemble: quantiles, one sum in detail, maps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.ensemble.results import LEAST, convergence, quantiles, tornado, volumes_by
from geosurf.render import palette
from geosurf.render.furniture import tick_texts, ticks
from geosurf.render.map_frame import colours_of
from geosurf.render.sheet import figure_bytes

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLION = 1e6
LOW, HIGH = palette.rgb("#3b6a96"), palette.rgb("#c8102e")
FROM_ZERO = 0.5  # of the largest volume: an axis of volumes above this does not start at 0
PALE = 0.3  # of bars that may be chance
BELOW: dict[str, Any] = {
    "fontsize": 8, "loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "frameon": False,
}  # fmt: skip
MOST_BARS = 12  # parameters of a tornado
N_TICK = 5  # of the axes of a map
SHARES = ("#ffffff", "#dbe3b0", "#84bcab", "#3b6a96")  # none to all of the realisations
SPREAD = ("#ffffff", "#f3d9a4", "#dd8d4f", "#8a3b2f")


def quantile_chart(result: xarray.Dataset, names: Sequence[str], by: str) -> Figure:
    """Return P90 to P10 of some volumes as bars, with P50, mean and base case."""
    found = quantiles(result, by).sel({by: list(names)})
    figure = _figure(11.0, 1.1 + 0.36 * len(names))
    axes = figure.subplots()
    rows = np.arange(len(names))[::-1]
    low, middle, high = (found[key].values / MILLION for key in ("P90", "P50", "P10"))
    axes.barh(rows, high - low, 0.55, low, color=palette.rgb("#84bcab"), label="P90 to P10")
    axes.plot(middle, rows, "|", ms=16, mew=2.5, color=palette.INK, label="P50")
    axes.plot(found["mean"].values / MILLION, rows, "o", ms=5, color=LOW, label="mean")
    base = found["base"].values / MILLION
    axes.plot(base, rows, "D", ms=5, mfc="none", color=HIGH, label="base case")
    axes.set_yticks(rows, [_plain(name) for name in names])
    # From 0, unless all bars would be slivers at the other end.
    if low.size and low.min() <= FROM_ZERO * high.max():
        axes.set_xlim(left=min(0.0, float(low.min())))
    else:  # bars would end on the frame
        axes.use_sticky_edges = False
        axes.autoscale_view()
    axes.set_xlabel("volume [million m³]")
    axes.grid(axis="x", color=palette.FRAME, alpha=0.35)
    figure.legend(loc="outside upper center", ncols=4, frameon=False)
    return figure


def detail_chart(result: xarray.Dataset, name: str, by: str) -> Figure:
    """Return one volume in detail: how often it is exceeded, whether it has settled, and why."""
    figure = _figure(13.0, 4.2)
    exceeded, settling, bars = figure.subplots(1, 3)
    volumes = np.sort(volumes_by(result, by).sel({by: name}).values) / MILLION
    share = 100.0 * (1.0 - np.arange(len(volumes)) / len(volumes))
    exceeded.step(volumes, share, where="pre", color=LOW)
    exceeded.set(xlabel="volume [million m³]", ylabel="realisations at or above [%]", ylim=(0, 101))
    exceeded.set_title("Exceedance", fontsize=11)
    for key, level in (("P90", 90.0), ("P50", 50.0), ("P10", 10.0)):
        at = float(quantiles(result, by).sel({by: name})[key]) / MILLION
        exceeded.plot([at, at], [0.0, level], ":", color=palette.FAINT)
        exceeded.annotate(key, (at, level), (4, 2), textcoords="offset points", fontsize=9)

    if len(volumes) > 1:
        found = convergence(result, name, by)
        for key, style, label in (
            ("P10", "--", "P90 and P10"),
            ("P50", "-", "P50"),
            ("P90", "--", None),
        ):
            settling.plot(found.n, found[key] / MILLION, style, color=LOW, label=label)
        ends = [(found["mean"] + sign * found.standard_error) / MILLION for sign in (-1, 1)]
        settling.fill_between(found.n, *ends, color=palette.rgb("#84bcab"), alpha=0.6, lw=0)
        settling.plot(
            found.n,
            found["mean"] / MILLION,
            color=palette.rgb("#2f7a66"),
            label="mean ± standard error",
        )
        settling.legend(**BELOW, ncols=3)
    settling.set(xlabel="realisations", ylabel="volume [million m³]")
    settling.set_title("Convergence", fontsize=11)
    _tornado(bars, result, name, by)
    for axes in (exceeded, settling):
        axes.grid(color=palette.FRAME, alpha=0.35)
    return figure


def _tornado(axes: Axes, result: xarray.Dataset, name: str, by: str) -> None:
    """Draw the mean volumes where each parameter is low, and where it is high."""
    axes.set_title("Which parameter matters", fontsize=11)
    if not result.sizes["parameter"] or int((result.status == 1).sum()) < LEAST:
        why = "no uncertain number" if not result.sizes["parameter"] else "needs ten realisations"
        axes.text(0.5, 0.5, why, ha="center", transform=axes.transAxes)
        axes.set_axis_off()
        return
    found = tornado(result, name, by).isel(parameter=slice(MOST_BARS))
    rows, mean = np.arange(found.sizes["parameter"])[::-1], found.attrs["mean"] / MILLION
    is_weak = (np.abs(found.rank_correlation.values) <= found.attrs["noise"]).tolist()
    for key, colour in (("low", LOW), ("high", HIGH)):
        width = found[key].values / MILLION - mean
        bars = axes.barh(rows, width, 0.6, mean, color=colour, label=f"{key} fifth of the values")
        for bar, weak in zip(bars, is_weak, strict=True):
            bar.set_alpha(PALE if weak else 1.0)
    axes.axvline(mean, color=palette.INK, lw=1)
    axes.set_yticks(rows, [_plain(word) for word in found.parameter.values.tolist()], fontsize=9)
    axes.set_xlabel("mean volume [million m³]" + "; pale: may be chance" * any(is_weak))
    axes.legend(**BELOW, ncols=2)


def map_chart(result: xarray.Dataset, layer: str) -> Figure:
    """Return maps of a layer: probability, mean and standard deviation of its thickness.

    Nodes where no realisation has the layer are blank.
    """
    one = result.sel(layer=layer)
    east, north = (float(np.ptp(one[key].values)) for key in ("easting", "northing"))
    # As high as the maps are, with their colour bars below them.
    figure = _figure(13.0, 1.6 + 3.9 * min(max(north / east, 0.3), 2.0))
    parts = (
        (one.probability, "probability of presence", SHARES, (0.0, 1.0)),
        (one.thickness_mean, "mean thickness [m]", palette.THICKNESS, (0.0, None)),
        (one.thickness_sd, "standard deviation of thickness [m]", SPREAD, (0.0, None)),
    )
    for axes, (values, words, codes, (low, high)) in zip(
        figure.subplots(1, 3, sharey=True), parts, strict=True
    ):
        z = values.where(one.probability > 0).transpose("northing", "easting").values
        top = high if high is not None else float(np.nanmax(z, initial=0.0)) or 1.0
        mesh = axes.pcolormesh(
            one.easting, one.northing, z, cmap=colours_of(codes), vmin=low, vmax=top
        )
        bar = figure.colorbar(mesh, ax=axes, label=words, location="bottom", aspect=30, shrink=0.9)
        bar.outline.set_visible(False)
        axes.set_aspect("equal")
        axes.set_xlabel("Easting [km]")
        for axis, bounds in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            at = ticks(bounds[0], bounds[1], N_TICK)
            axis.set_ticks(at, tick_texts(at, 1000.0))
    figure.axes[0].set_ylabel("Northing [km]")
    return figure


def juxtaposition_chart(found: xarray.Dataset, fault: str) -> Figure:
    """Return the probability that zones face each other across a fault, as a matrix of zones."""
    mine = found.isel(pair=np.flatnonzero(found.fault.values == fault))
    sides = [mine[key].values.tolist() for key in ("hanging_zone", "foot_zone")]
    # in the order of the base case, which is that of the column
    zones = list(dict.fromkeys([zone for pair in zip(*sides, strict=True) for zone in pair]))
    share = np.zeros((len(zones), len(zones)))
    for hanging, foot, value in zip(*sides, mine.probability.values.tolist(), strict=True):
        share[zones.index(hanging), zones.index(foot)] = value
    figure = _figure(3.6 + 0.9 * len(zones), 1.9 + 0.5 * len(zones))
    axes = figure.subplots()
    axes.imshow(share, cmap=colours_of(SHARES), vmin=0.0, vmax=1.0, aspect="auto")
    for (row, column), value in np.ndenumerate(share):
        colour = "white" if value > 0.7 else palette.INK
        words = f"{100.0 * value:.0f} %" if value else ""
        axes.text(column, row, words, ha="center", va="center", color=colour)
    labels = [_plain(zone) for zone in zones]
    axes.set_xticks(range(len(zones)), labels, rotation=20, ha="right")
    axes.set_yticks(range(len(zones)), labels)
    axes.set(xlabel="footwall", ylabel="hanging wall")
    return figure


def png_of(figure: Figure) -> bytes:
    """Return a chart as PNG: the same bytes each time."""
    return figure_bytes(figure, "png")


def _figure(width: float, height: float) -> Figure:
    """An empty figure [inches], which pyplot does not know."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", dpi=110)


def _plain(name: Any) -> str:
    """A name as it is: matplotlib would read dollar signs as formulas."""
    return str(name).replace("$", r"\$")


__all__ = ["detail_chart", "juxtaposition_chart", "map_chart", "png_of", "quantile_chart"]
