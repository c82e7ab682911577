"""The charts of an ensemble: `Ensemble.plot`."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import palette
from geosurf.conventions.machine import need_plots
from geosurf.ensemble.record import EXCEEDED, LEAST, MILLION, TOTAL
from geosurf.render import artists
from geosurf.render.compose import figure_path, save_figure
from geosurf.render.sheet import check_axes

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOW, HIGH = palette.rgb("#3b6a96"), palette.rgb("#c8102e")
FROM_ZERO = 0.5  # of the largest volume: an axis of volumes above this does not start at 0
PALE = 0.3  # of bars that may be chance
BELOW: dict[str, Any] = {
    "fontsize": 8, "loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "frameon": False,
}  # fmt: skip
MOST_BARS = 12  # parameters of a tornado


class EnsemblePlots:
    """The charts of an ensemble: figures of matplotlib, or files.

    All take ``ax`` (axes to draw into), ``path`` (a ``.png``, ``.svg`` or ``.pdf`` file), and what
    `Ensemble.sums` takes: `of`, `include`, and words such as ``region="A"``. They return the
    figure, or the path.

    Parameters
    ----------
    ensemble : Ensemble

    Examples
    --------
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2100.0})
    >>> level = gs.ensemble.ContactLevel("OWC", shift=gs.ensemble.Uniform(-10.0, 10.0))
    >>> ensemble = gs.run_ensemble(scene, 10, uncertain=[level], progress=False)
    >>> ensemble.plot.tornado().axes[0].get_xlabel()
    'mean GRV [million m³]'
    """

    def __init__(self, ensemble: Any) -> None:
        self._ensemble = ensemble

    def tornado(self, *, ax: Any = None, path: Any = None, **asked: Any) -> Any:
        """Draw the mean of a sum where each uncertain input is low, and where it is high.

        Parameters
        ----------
        ax, path, **asked
            See `EnsemblePlots`. Default: the first of ``ensemble.answers``.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
        """

        def draw(axes: Axes) -> None:
            axes.set_title(f"Tornado: {self._title(asked)}", fontsize=11)
            data = self._ensemble.data
            if not data.sizes["parameter"] or self._ensemble.n_built < LEAST:
                few = "needs ten realisations" if data.sizes["parameter"] else "nothing is drawn"
                axes.text(0.5, 0.5, few, ha="center", transform=axes.transAxes)
                axes.set_axis_off()
                return
            found = self._ensemble.tornado(**asked).isel(parameter=slice(MOST_BARS))
            rows, mean = np.arange(found.sizes["parameter"])[::-1], found.attrs["mean"] / MILLION
            is_weak = (np.abs(found.rank_correlation.values) <= found.attrs["noise"]).tolist()
            for key, colour in (("low", LOW), ("high", HIGH)):
                width = found[key].values / MILLION - mean
                bars = axes.barh(
                    rows, width, 0.6, mean, color=colour, label=f"{key} fifth of the values"
                )
                for bar, weak in zip(bars, is_weak, strict=True):
                    bar.set_alpha(PALE if weak else 1.0)
            axes.axvline(mean, color=palette.INK, lw=1)
            axes.set_yticks(rows, [plain(word) for word in found.parameter.values], fontsize=9)
            chance = "; pale: may be chance" * any(is_weak)
            axes.set_xlabel(f"mean {self._quantity(asked)}{chance}")
            axes.legend(**BELOW, ncols=2)

        n = min(MOST_BARS, self._ensemble.data.sizes["parameter"])
        return drawn(draw, ax, path, (7.0, 2.0 + 0.35 * n))

    def quantiles(
        self, *, groups: Sequence[Sequence[str]] | None = None, ax: Any = None, path: Any = None,
        of: str | None = None, include: str = "reservoir", **where: Any,
    ) -> Any:  # fmt: skip
        """Draw P90 to P10 of sums as bars, with P50, mean and base case.

        Parameters
        ----------
        groups : sequence of sequence of str, optional
            As for `Ensemble.rows`.
        ax, path, of, include, **where
            See `EnsemblePlots`.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
        """
        found = list(self._ensemble.rows(of, include, groups, **where))

        def draw(axes: Axes) -> None:
            rows = np.arange(len(found))[::-1]
            low, middle, high, mean, base = (
                np.array([numbers[key] for _, numbers in found]) / MILLION
                for key in ("P90", "P50", "P10", "mean", "base")
            )
            bars: dict[str, Any] = {"color": palette.rgb("#84bcab"), "label": "P90 to P10"}
            axes.barh(rows, high - low, 0.55, low, **bars)
            axes.plot(middle, rows, "|", ms=16, mew=2.5, color=palette.INK, label="P50")
            axes.plot(mean, rows, "o", ms=5, color=LOW, label="mean")
            axes.plot(base, rows, "D", ms=5, mfc="none", color=HIGH, label="base case")
            axes.set_yticks(rows, [plain(" ".join(words) or TOTAL[include]) for words, _ in found])
            # From 0, unless all bars would be slivers at the other end.
            if low.size and low.min() <= FROM_ZERO * high.max():
                axes.set_xlim(left=min(0.0, float(low.min())))
            else:  # bars would end on the frame
                axes.use_sticky_edges = False
                axes.autoscale_view()
            axes.set_xlabel(self._ensemble.name(of))
            axes.grid(axis="x", color=palette.FRAME, alpha=0.35)
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)

        return drawn(draw, ax, path, (11.0, 1.4 + 0.36 * len(found)))

    def exceedance(self, *, ax: Any = None, path: Any = None, **asked: Any) -> Any:
        """Draw the share of the realisations that reach each value.

        Parameters
        ----------
        ax, path, **asked
            See `EnsemblePlots`. Default: the first of ``ensemble.answers``.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
        """
        values = np.sort(self._ensemble.answer(**asked).values) / MILLION

        def draw(axes: Axes) -> None:
            share = 100.0 * (1.0 - np.arange(len(values)) / len(values))
            axes.step(values, share, where="pre", color=LOW)
            axes.set(xlabel=self._quantity(asked), ylim=(0, 101))
            axes.set_ylabel("realisations at or above [%]")
            axes.set_title("Exceedance", fontsize=11)
            axes.grid(color=palette.FRAME, alpha=0.35)
            for level in EXCEEDED:
                at = float(np.quantile(values, 1.0 - level / 100.0))
                axes.plot([at, at], [0.0, level], ":", color=palette.FAINT)
                offset: dict[str, Any] = {"textcoords": "offset points", "fontsize": 9}
                axes.annotate(f"P{level}", (at, level), (4, 2), **offset)

        return drawn(draw, ax, path, (6.0, 4.2))

    def convergence(self, *, ax: Any = None, path: Any = None, **asked: Any) -> Any:
        """Draw how P90, P50, P10 and the mean settle with the number of realisations.

        Parameters
        ----------
        ax, path, **asked
            See `EnsemblePlots`. Default: the first of ``ensemble.answers``.

        Returns
        -------
        matplotlib.figure.Figure or pathlib.Path
        """

        def draw(axes: Axes) -> None:
            axes.set(xlabel="realisations", ylabel=self._quantity(asked))
            axes.set_title("Convergence", fontsize=11)
            axes.grid(color=palette.FRAME, alpha=0.35)
            if self._ensemble.n_built < 2:
                return
            found = self._ensemble.convergence(**asked)
            for key, style, label in (
                ("P10", "--", "P90 and P10"), ("P50", "-", "P50"), ("P90", "--", None)
            ):  # fmt: skip
                axes.plot(found.n, found[key] / MILLION, style, color=LOW, label=label)
            ends = [(found["mean"] + sign * found.standard_error) / MILLION for sign in (-1, 1)]
            axes.fill_between(found.n, *ends, color=palette.rgb("#84bcab"), alpha=0.6, lw=0)
            line: dict[str, Any] = {
                "color": palette.rgb("#2f7a66"),
                "label": "mean ± standard error",
            }
            axes.plot(found.n, found["mean"] / MILLION, **line)
            axes.legend(**BELOW, ncols=3)

        return drawn(draw, ax, path, (6.0, 4.2))

    def _quantity(self, asked: dict[str, Any]) -> str:
        """What is summed, with its unit."""
        return self._ensemble.name(asked.get("of"))

    def _title(self, asked: dict[str, Any]) -> str:
        """What is summed, in words."""
        return plain(words_of(self._ensemble, asked))


def words_of(ensemble: Any, asked: dict[str, Any]) -> str:
    """What a sum is of: ``"STOIIP, region A"``, ``"GRV, fluid oil"``."""
    of, where = asked.get("of"), {k: v for k, v in asked.items() if k not in ("of", "include")}
    if of is None and not where:
        of, where = ensemble.answers[0]
    parts = [
        f"{key} {value if isinstance(value, str) else ' and '.join(value)}"
        for key, value in where.items()
    ]
    return ", ".join([ensemble.name(of).partition(" [")[0], *parts])


def drawn(
    draw: Callable[[Axes], None], ax: Any, path: str | os.PathLike[str] | None,
    size: tuple[float, float],
) -> Any:  # fmt: skip
    """Draw into axes, or a new figure of a size [inches]; return the figure, or the file."""
    need_plots()
    if ax is None:
        figure = new_figure(*size)
        ax = figure.subplots()
    else:
        check_axes(ax)
        figure = ax.figure
    if path is not None:
        figure_path(path)
    draw(ax)
    return figure if path is None else save_figure(figure, path)


def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inches], which pyplot does not know."""
    return artists.Figure(figsize=(width, height), layout="constrained", dpi=110)


def plain(name: Any) -> str:
    """A name as it is: matplotlib would read dollar signs as formulas."""
    return str(name).replace("$", r"\$")
