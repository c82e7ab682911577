"""The report of an ensemble: one HTML page with quantiles, charts and maps."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted, palette
from geosurf.conventions.machine import need_plots
from geosurf.conventions.running import running
from geosurf.ensemble.record import EXCEEDED, LEAST, MILLION, STATISTICS, TOTAL
from geosurf.files import write_into_folder
from geosurf.lazy import xarray
from geosurf.render import artists
from geosurf.render.compose import figure_path, save_figure
from geosurf.render.furniture import colours_of, tick_texts, ticks
from geosurf.render.sheet import check_axes
from geosurf.report import page
from geosurf.report.page import NOTHING, Section, Table, number
from geosurf.report.tables import described_files, file_table, version_table

if TYPE_CHECKING:  # pragma: no cover - types only
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# ---- plots ----------------------------------------
# The charts of an ensemble: `Ensemble.plot`.


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
            title = plain(words_of(self._ensemble, asked))
            axes.set_title(f"Tornado: {title}", fontsize=11)
            data = self._ensemble.data
            if not data.sizes["parameter"] or self._ensemble.n_built < LEAST:
                few = "needs ten realisations" if data.sizes["parameter"] else "nothing is drawn"
                axes.text(0.5, 0.5, few, ha="center", transform=axes.transAxes)
                axes.set_axis_off()
                return
            tornado = self._ensemble.tornado(**asked).isel(parameter=slice(MOST_BARS))
            rows, mean = (
                np.arange(tornado.sizes["parameter"])[::-1],
                tornado.attrs["mean"] / MILLION,
            )
            is_weak = (np.abs(tornado.rank_correlation.values) <= tornado.attrs["noise"]).tolist()
            for key, colour in (("low", LOW), ("high", HIGH)):
                width = tornado[key].values / MILLION - mean
                bars = axes.barh(
                    rows, width, 0.6, mean, color=colour, label=f"{key} fifth of the values"
                )
                for bar, weak in zip(bars, is_weak, strict=True):
                    bar.set_alpha(PALE if weak else 1.0)
            axes.axvline(mean, color=palette.INK, lw=1)
            axes.set_yticks(rows, [plain(word) for word in tornado.parameter.values], fontsize=9)
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
        quantile_rows = list(self._ensemble.rows(of, include, groups, **where))

        def draw(axes: Axes) -> None:
            rows = np.arange(len(quantile_rows))[::-1]
            low, middle, high, mean, base = (
                np.array([numbers[key] for _, numbers in quantile_rows]) / MILLION
                for key in ("P90", "P50", "P10", "mean", "base")
            )
            bars: dict[str, Any] = {"color": palette.rgb("#84bcab"), "label": "P90 to P10"}
            axes.barh(rows, high - low, 0.55, low, **bars)
            axes.plot(middle, rows, "|", ms=16, mew=2.5, color=palette.INK, label="P50")
            axes.plot(mean, rows, "o", ms=5, color=LOW, label="mean")
            axes.plot(base, rows, "D", ms=5, mfc="none", color=HIGH, label="base case")
            axes.set_yticks(
                rows, [plain(" ".join(words) or TOTAL[include]) for words, _ in quantile_rows]
            )
            # From 0, unless all bars would be slivers at the other end.
            if low.size and low.min() <= FROM_ZERO * high.max():
                axes.set_xlim(left=min(0.0, float(low.min())))
            else:  # bars would end on the frame
                axes.use_sticky_edges = False
                axes.autoscale_view()
            axes.set_xlabel(self._ensemble.name(of))
            axes.grid(axis="x", color=palette.FRAME, alpha=0.35)
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False)

        return drawn(draw, ax, path, (11.0, 1.4 + 0.36 * len(quantile_rows)))

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
            curves = self._ensemble.convergence(**asked)
            for key, style, label in (
                ("P10", "--", "P90 and P10"), ("P50", "-", "P50"), ("P90", "--", None)
            ):  # fmt: skip
                axes.plot(curves.n, curves[key] / MILLION, style, color=LOW, label=label)
            ends = [(curves["mean"] + sign * curves.standard_error) / MILLION for sign in (-1, 1)]
            axes.fill_between(curves.n, *ends, color=palette.rgb("#84bcab"), alpha=0.6, lw=0)
            line: dict[str, Any] = {
                "color": palette.rgb("#2f7a66"),
                "label": "mean ± standard error",
            }
            axes.plot(curves.n, curves["mean"] / MILLION, **line)
            axes.legend(**BELOW, ncols=3)

        return drawn(draw, ax, path, (6.0, 4.2))

    def _quantity(self, asked: dict[str, Any]) -> str:
        """What is summed, with its unit."""
        made: str = self._ensemble.name(asked.get("of"))
        return made


def words_of(ensemble: Any, asked: dict[str, Any]) -> str:
    """What a sum is of: ``"STOIIP, region A"``, ``"GRV, fluid oil"``."""
    column, where = asked.get("of"), {k: v for k, v in asked.items() if k not in ("of", "include")}
    if column is None and not where:
        column, where = ensemble.answers[0]
    parts = [
        f"{key} {value if isinstance(value, str) else ' and '.join(value)}"
        for key, value in where.items()
    ]
    return ", ".join([ensemble.name(column).partition(" [")[0], *parts])


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


# further tables of each quantity, which are folded
GROUPS = (("zone", "By zone"), ("block", "By block"), ("unit", "By unit"))
MOST_DETAILS = 6  # sums with charts of their own
MOST_REASONS = 20
N_TICK = 5  # of the axes of a map
SHARES = ("#ffffff", "#dbe3b0", "#84bcab", "#3b6a96")  # none to all of the realisations
SPREAD = ("#ffffff", "#f3d9a4", "#dd8d4f", "#8a3b2f")


@running("report")
def report_ensemble(
    ensemble: Any,
    folder: Path,
    title: str,
    inputs: Mapping[str, Any] | None,
    relative_to: str | os.PathLike[str] | None,
    include: str,
) -> Path:
    """Write the page of an ensemble, see `Ensemble.report`."""
    need_plots()
    result = ensemble.data
    waiting = result.sizes["realisation"] - ensemble.n_built - ensemble.n_failed
    facts = f"{counted(ensemble.n_built, 'realisation')} built, {ensemble.n_failed} failed; "
    facts += f"seed {result.attrs['seed']}."
    if waiting:
        facts += f" {waiting} have not run yet."
    facts += words_of_tears(result)
    facts += f" {ensemble.left_out(include)}".rstrip()
    header = [
        page.paragraph(facts),
        page.paragraph(
            "P90, the low case, is what 90 % of the realisations exceed; P10 is the high case.",
            "faint",
        ),
    ]
    # Before any picture is drawn: a wrong argument is refused at once.
    given = _inputs(result, {} if inputs is None else inputs, relative_to)
    versions = Section("Versions", page.html_table(version_table()))
    sections = [*_sections(ensemble, folder, include), given, versions]
    html = page.fill_page(title, "\n".join(header), sections)
    return write_into_folder(folder / "index.html", html.encode("utf-8"), "the report")


def _sections(ensemble: Any, folder: Path, include: str) -> Iterator[Section]:
    """Answers first, then what they rest on."""
    pictures, result = folder / "pictures", ensemble.data
    asked = [column for column, _ in ensemble.answers]
    for column in dict.fromkeys([*asked, "bulk"]):
        path = pictures / f"quantiles_{column}.png"
        chart = ensemble.plot.quantiles(of=column, include=include, path=path)
        tables = [page.html_table(quantile_table(ensemble, column, include))]
        tables += [
            page.folded(words, page.html_table(quantile_table(ensemble, column, include, [(by,)])))
            for by, words in GROUPS
        ]
        shown = page.figure("P90 to P10, P50, mean and base case.", chart)
        yield Section(ensemble.name(column), "\n".join([shown, *tables]), name=column)

    details = []
    for k, what in enumerate(_details(ensemble, include)):
        path = save_figure(detail_chart(ensemble, what), pictures / f"volume_{k}.png")
        caption = _most(ensemble, what)
        heading = f"<h3>{escape(words_of(ensemble, what))}</h3>"
        details.append(f"{heading}\n{page.figure(caption, path)}")
    yield Section("Tornado, exceedance and convergence", "\n".join(details))

    if "probability" in result:
        yield _maps(result, pictures)
    if "juxtaposed_area" in result:
        yield _juxtaposition(ensemble, pictures, include)
    yield Section("Uncertain numbers", page.html_table(parameter_table(result)))
    failures = failure_table(result)
    yield Section("Failed realisations", page.html_table(failures) if failures.rows else "")


def _details(ensemble: Any, include: str) -> list[dict[str, Any]]:
    """Sums with charts of their own: the answers, then their largest regions."""
    sums = []
    for column, where in ensemble.answers:
        asked = {"of": column, "include": include, **where}
        sums.append(asked)
        regions = ensemble.quantiles("region", column, include, **where).sortby(
            "P50", ascending=False
        )
        if regions.sizes["region"] > 1:
            sums += [{**asked, "region": name} for name in regions.region.values.tolist()]
    return sums[:MOST_DETAILS]


def _maps(result: xarray.Dataset, pictures: Path) -> Section:
    """Maps of each layer; a layer that no realisation has is named only."""
    maps, absent = [], []
    for k, layer in enumerate(result.layer.values.tolist()):
        if not (result.probability.sel(layer=layer) > 0).any():
            absent.append(str(layer))
            continue
        path = save_figure(map_chart(result, layer), pictures / f"map_{k}.png")
        words = f"{layer}: probability, mean and standard deviation of thickness."
        maps.append(page.figure(words, path))
    if absent:
        maps.append(page.paragraph(f"In no realisation: {', '.join(absent)}."))
    # one below the other: each is three maps wide
    return Section("Maps", "\n".join(maps))


def _inputs(
    result: xarray.Dataset, inputs: Mapping[str, Any], relative_to: str | os.PathLike[str] | None
) -> Section:
    """What the ensemble was made of: files and distributions."""
    parts, files = [], described_files(inputs, relative_to)
    if "parameter_distribution" in result.coords and result.sizes["parameter"]:
        parts.append(page.html_table(distribution_table(result)))
    if files:
        parts.append(page.html_table(file_table(files, "")))
    return Section("Inputs", "\n".join(parts))


def words_of_tears(result: xarray.Dataset) -> str:
    """In how many realisations horizons were cut anew; empty if in none.

    Examples
    --------
    >>> import xarray as xr
    >>> counts = {"torn": ("realisation", [4, 4, 4]), "searched": ("realisation", [0, 1, 0])}
    >>> words_of_tears(xr.Dataset({"status": ("realisation", [1, 1, 2]), **counts}))
    ' In 1 of 2 realisations, a horizon could not be cut at its faults as in the base case, and was cut anew: volumes may differ by 0.1 % for that.'
    """  # noqa: E501 - a sentence
    torn = (result.torn > 0) & (result.status == 1)
    searched = int((torn & (result.searched > 0)).sum())
    if not searched:
        return ""
    return (
        f" In {searched} of {int(torn.sum())} realisations, a horizon could not be cut at its "
        "faults as in the base case, and was cut anew: volumes may differ by 0.1 % for that."
    )


def distribution_table(result: xarray.Dataset) -> Table:
    """The distribution of each parameter, in words with units."""
    names, words = (result[k].values.tolist() for k in ("parameter", "parameter_distribution"))
    rows = tuple((str(name), str(word)) for name, word in zip(names, words, strict=True))
    return Table(("parameter", "distribution"), rows, n_label=2)


def _juxtaposition(ensemble: Any, pictures: Path, include: str) -> Section:
    """How likely zones face each other across each fault, and over what area."""
    pairs = ensemble.juxtaposition(include)
    drawn = {}
    for k, fault in enumerate(dict.fromkeys(pairs.fault.values.tolist())):
        path = pictures / f"fault_{k}.png"
        words = f"{fault}: share of the realisations in which two zones face each other."
        drawn[words] = save_figure(juxtaposition_chart(pairs, fault), path)
    table = page.folded("Areas [m²]", page.html_table(juxtaposition_table(pairs)))
    return Section("Juxtaposition", f"{page.html_pictures(drawn)}\n{table}" if drawn else "")


def juxtaposition_table(pairs: xarray.Dataset) -> Table:
    """Areas of pairs of zones across faults [m2], and in what share of the realisations."""
    keys = ("P90", "P50", "P10", "mean")
    rows = [
        (
            *(str(pairs[key].values[k]) for key in ("fault", "zone_plus", "zone_minus")),
            f"{100.0 * float(pairs.probability[k]):.0f} %",
            *(number(float(pairs[key][k])) for key in keys),
        )
        for k in range(pairs.sizes["pair"])
    ]
    return Table(("fault", "hanging wall", "footwall", "probability", *keys), tuple(rows), 3)


def _most(ensemble: Any, asked: dict[str, Any]) -> str:
    """The caption of a sum: the input that matters most, if one does."""
    if not ensemble.data.sizes["parameter"] or ensemble.n_built < LEAST:
        return f"{words_of(ensemble, asked)}."
    found = ensemble.tornado(**asked)
    most = found.isel(parameter=0)
    rank, noise = float(most.rank_correlation), found.attrs["noise"]
    if abs(rank) <= noise:
        return f"No rank correlation is above {noise:.2f}, which may be chance."
    return f"Depends most on {most.parameter.item()} (rank correlation {number(rank, 2)})."


def quantile_table(
    ensemble: Any, column: str, include: str, groups: Sequence[Sequence[str]] | None = None
) -> Table:
    """Quantiles of sums [millions], and in what share of the realisations each is present."""
    rows = [
        (
            " ".join(labels) or TOTAL[include],
            *(number(numbers[key] / MILLION, 3) for key in STATISTICS[:-1]),
            f"{100.0 * numbers['present']:.0f} %",
        )
        for labels, numbers in ensemble.rows(column, include, groups)
    ]
    head = ("", "P90", "P50", "P10", "mean", "standard deviation", "base case", "present")
    return Table(head, tuple(rows))


def parameter_table(result: xarray.Dataset) -> Table:
    """What was drawn for each uncertain number: smallest, mean and largest."""
    rows = []
    for k, name in enumerate(result.parameter.values.tolist()):
        values = result.drawn.values[result.status.values == 1, k]
        unit = str(result.parameter_unit.values[k])
        cells = (values.min(), values.mean(), values.max()) if len(values) else ()
        rows.append((str(name), unit, *(number(float(v), 2) for v in cells)))
    return Table(("", "unit", "smallest", "mean", "largest"), tuple(rows), n_label=2)


def failure_table(result: xarray.Dataset) -> Table:
    """Realisations that could not be built, with their numbers and reasons."""
    failed = [k for k, status in enumerate(result.status.values.tolist()) if status == 2]
    rows = [
        (str(int(result.realisation[k])), str(result.reason.values[k]))
        for k in failed[:MOST_REASONS]
    ]
    if len(failed) > MOST_REASONS:
        rows.append((NOTHING, f"and {len(failed) - MOST_REASONS} more: result.reason"))
    return Table(("realisation", "reason"), tuple(rows), n_label=2)


def detail_chart(ensemble: Any, asked: dict[str, Any]) -> Figure:
    """Return one sum in detail: which input matters, how often it is exceeded, has it settled."""
    figure = new_figure(13.0, 4.6)
    bars, exceeded, settling = figure.subplots(1, 3)
    ensemble.plot.tornado(ax=bars, **asked)
    ensemble.plot.exceedance(ax=exceeded, **asked)
    ensemble.plot.convergence(ax=settling, **asked)
    return figure


def map_chart(result: xarray.Dataset, layer: str) -> Figure:
    """Return maps of a layer: probability, mean and standard deviation of its thickness.

    Nodes where no realisation has the layer are blank.
    """
    maps = result.sel(layer=layer)
    east, north = (float(np.ptp(maps[key].values)) for key in ("easting", "northing"))
    # As high as the maps are, with their colour bars below them.
    figure = new_figure(13.0, 1.6 + 3.9 * min(max(north / east, 0.3), 2.0))
    parts = (
        (maps.probability, "probability of presence", SHARES, (0.0, 1.0)),
        (maps.thickness_mean, "mean thickness [m]", palette.THICKNESS, (0.0, None)),
        (maps.thickness_sd, "standard deviation of thickness [m]", SPREAD, (0.0, None)),
    )
    for axes, (values, words, codes, (low, high)) in zip(
        figure.subplots(1, 3, sharey=True), parts, strict=True
    ):
        z = values.where(maps.probability > 0).transpose("northing", "easting").values
        top = high if high is not None else float(np.nanmax(z, initial=0.0)) or 1.0
        mesh = axes.pcolormesh(
            maps.easting, maps.northing, z, cmap=colours_of(codes), vmin=low, vmax=top
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


def juxtaposition_chart(pairs: xarray.Dataset, fault: str) -> Figure:
    """Return the probability that zones face each other across a fault, as a matrix of zones."""
    fault_pairs = pairs.isel(pair=np.flatnonzero(pairs.fault.values == fault))
    sides = [fault_pairs[key].values.tolist() for key in ("zone_plus", "zone_minus")]
    # in the order of the base case, which is that of the column
    zones = list(dict.fromkeys([zone for pair in zip(*sides, strict=True) for zone in pair]))
    share = np.zeros((len(zones), len(zones)))
    for hanging, foot, value in zip(*sides, fault_pairs.probability.values.tolist(), strict=True):
        share[zones.index(hanging), zones.index(foot)] = value
    figure = new_figure(3.6 + 0.9 * len(zones), 1.9 + 0.5 * len(zones))
    axes = figure.subplots()
    axes.imshow(share, cmap=colours_of(SHARES), vmin=0.0, vmax=1.0, aspect="auto")
    for (row, column), value in np.ndenumerate(share):
        colour = "white" if value > 0.7 else palette.INK
        words = f"{100.0 * value:.0f} %" if value else ""
        axes.text(column, row, words, ha="center", va="center", color=colour)
    labels = [plain(zone) for zone in zones]
    axes.set_xticks(range(len(zones)), labels, rotation=20, ha="right")
    axes.set_yticks(range(len(zones)), labels)
    axes.set(xlabel="footwall", ylabel="hanging wall")
    return figure
