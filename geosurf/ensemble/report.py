"""The report of an ensemble: one HTML page with quantiles, charts and maps."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.packages import need_plots
from geosurf.conventions.running import running
from geosurf.ensemble.record import expect_ensemble, juxtaposition
from geosurf.ensemble.results import (
    LEAST,
    convergence,
    included,
    left_out,
    quantiles,
    tornado,
    volumes_by,
)
from geosurf.errors import OutputError
from geosurf.files.atomic import write_whole
from geosurf.model.expected import path_of
from geosurf.render import palette
from geosurf.render.compose import save_png
from geosurf.render.furniture import colours_of, tick_texts, ticks
from geosurf.render.sheet import figure_bytes
from geosurf.report import page
from geosurf.report.page import NOTHING, Section, Table, number
from geosurf.report.tables import described_files, file_table, version_table

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GROUPS = (("contact", "By zone and contact"), ("zone", "By zone"),
          ("region", "By region"), ("block", "By block"), ("unit", "By unit"))  # fmt: skip
MOST_DETAILS = 6  # sums with a chart of their own: the largest ones
MOST_REASONS = 20
MILLION = 1e6


@running("report")
def report_ensemble(
    result: xarray.Dataset,
    folder: str | os.PathLike[str],
    *,
    title: str = "Ensemble",
    made: str = "",
    inputs: Mapping[str, Any] | None = None,
    relative_to: str | os.PathLike[str] | None = None,
    include: str = "reservoir",
) -> Path:
    """
    Write ``index.html``: quantiles, convergence, parameters, maps and failures of an ensemble.

    The page is one file, which needs no network. Its charts are PNG files, too, in the folder
    ``pictures``.

    Parameters
    ----------
    result : xarray.Dataset
        Of `run_ensemble` or `open_ensemble`.
    folder : path-like
        Folder of the page. It is created if it does not exist.
    title : str
        Heading of the page.
    made : str
        A date or a name to print below the title. By default the page has no date, so the same
        results give the same page.
    inputs : mapping of str to path-like, optional
        Files that the model was made of: the page lists their paths, sizes and hashes.
    relative_to : path-like, optional
        Folder that printed paths start from. Default: the current folder.
    include : {"reservoir", "all"}
        ``"all"``: also over- and underburden.

    Returns
    -------
    pathlib.Path
        File of the page.

    Raises
    ------
    InputError
        If the result is not of an ensemble, no realisation was built, or the files or their
        folder are not named as above.
    OutputError
        If a file cannot be written.
    DependencyError
        If matplotlib, which draws the charts, is not installed.

    Examples
    --------
    >>> import tempfile
    >>> import geosurf as gs
    >>> from geosurf.ensemble import ContactLevel, Uniform, report_ensemble
    >>> world = gs.synthetic.tilted_planes(n=3)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2200.0})
    >>> level = ContactLevel("OWC", shift=Uniform(-9.0, 9.0))
    >>> result = gs.run_ensemble(scene, 3, uncertain=[level], progress=False)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     report_ensemble(result, folder, title="Two planes").name
    'index.html'
    """
    need_plots()
    folder = path_of(folder, "report_ensemble")
    expect_ensemble(result, "report_ensemble")
    built, failed = (int((result.status == code).sum()) for code in (1, 2))
    waiting = result.sizes["realization"] - built - failed
    facts = f"{counted(built, 'realisation')} built, {failed} failed; seed {result.attrs['seed']}."
    if waiting:
        facts += f" {waiting} have not run yet."
    facts += words_of_tears(result)
    facts += f" {left_out(result, include)}".rstrip()
    result = included(result, include)
    header = [page.paragraph(made, "faint")] if made else []
    header += [
        page.paragraph(facts),
        page.paragraph("P90 is the volume that 90 % of the realisations exceed.", "faint"),
    ]
    # Before any picture is drawn: a wrong argument is refused at once.
    given = _inputs(result, {} if inputs is None else inputs, relative_to)
    versions = Section("Versions", page.html_table(version_table()))
    sections = [*_sections(result, folder), given, versions]
    html = page.fill_page(str(title), "\n".join(header), sections)
    target = folder / "index.html"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, html.encode("utf-8"))
    except OSError as error:
        raise OutputError(
            f"{target}: the report cannot be written ({error.strerror}). "
            "Choose a folder that you can write to."
        ) from error
    return target


def _sections(result: xarray.Dataset, folder: Path) -> Iterator[Section]:
    """Answers first, then what they rest on."""
    pictures = folder / "pictures"
    names = _largest(result)
    chart = save_png(png_of(quantile_chart(result, names, "contact")), pictures / "quantiles.png")
    tables = "\n".join(
        page.folded(words, page.html_table(quantile_table(result, by)))
        if by != "contact" else page.html_table(quantile_table(result, by))
        for by, words in GROUPS
    )  # fmt: skip
    drawn = page.figure("P90 to P10 by zone and contact.", chart)
    yield Section("Gross rock volume (GRV) [million m³]", f"{drawn}\n{tables}", name="volumes")

    details, parts = [], names[:MOST_DETAILS]
    for k, name in enumerate(parts):
        path = save_png(png_of(detail_chart(result, name, "contact")), pictures / f"volume_{k}.png")
        details.append(f"<h3>{escape(name)}</h3>\n{page.figure(_settled(result, name), path)}")
    yield Section("The largest volumes in detail", "\n".join(details))

    if "probability" in result:
        yield _maps(result, pictures)
    if "juxtaposed_area" in result:
        yield _juxtaposition(result, pictures)
    yield Section("Uncertain numbers", page.html_table(parameter_table(result)))
    failures = failure_table(result)
    yield Section("Failed realisations", page.html_table(failures) if failures.rows else "")


def _maps(result: xarray.Dataset, pictures: Path) -> Section:
    """Maps of each layer; a layer that no realisation has is named only."""
    maps, absent = [], []
    for k, layer in enumerate(result.layer.values.tolist()):
        if not (result.probability.sel(layer=layer) > 0).any():
            absent.append(str(layer))
            continue
        path = save_png(png_of(map_chart(result, layer)), pictures / f"map_{k}.png")
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
    """How many realisations were torn with the remedies of the base case; empty if none was torn.

    Examples
    --------
    >>> import xarray as xr
    >>> counts = {"torn": ("realization", [4, 4, 4]), "searched": ("realization", [0, 1, 0])}
    >>> words_of_tears(xr.Dataset({"status": ("realization", [1, 1, 2]), **counts}))
    ' The remedies of the base case closed all torn horizons in 1 of 2; 1 needed a search.'
    """
    # Results that are stored by an older version have no counts.
    if "torn" not in result or not (result.torn > 0).any():
        return ""
    torn = (result.torn > 0) & (result.status == 1)
    searched = int((torn & (result.searched > 0)).sum())
    n = int(torn.sum())
    return (
        f" The remedies of the base case closed all torn horizons in {n - searched} of {n}; "
        f"{searched} needed a search."
    )


def distribution_table(result: xarray.Dataset) -> Table:
    """The distribution of each parameter, in words with units."""
    names, words = (result[k].values.tolist() for k in ("parameter", "parameter_distribution"))
    rows = tuple((str(name), str(word)) for name, word in zip(names, words, strict=True))
    return Table(("parameter", "distribution"), rows, n_label=2)


def _juxtaposition(result: xarray.Dataset, pictures: Path) -> Section:
    """How likely zones face each other across each fault, and over what area."""
    found = juxtaposition(result)
    drawn = {}
    for k, fault in enumerate(dict.fromkeys(found.fault.values.tolist())):
        path = pictures / f"fault_{k}.png"
        words = f"{fault}: share of the realisations in which two zones face each other."
        drawn[words] = save_png(png_of(juxtaposition_chart(found, fault)), path)
    table = page.folded("Areas [m²]", page.html_table(juxtaposition_table(found)))
    return Section("Juxtaposition", f"{page.html_pictures(drawn)}\n{table}" if drawn else "")


def juxtaposition_table(found: xarray.Dataset) -> Table:
    """Areas of pairs of zones across faults [m2], and in what share of the realisations."""
    keys = ("P90", "P50", "P10", "mean")
    rows = [
        (
            *(str(found[key].values[k]) for key in ("fault", "hanging_zone", "foot_zone")),
            f"{100.0 * float(found.probability[k]):.0f} %",
            *(number(float(found[key][k])) for key in keys),
        )
        for k in range(found.sizes["pair"])
    ]
    return Table(("fault", "hanging wall", "footwall", "probability", *keys), tuple(rows), 3)


def _largest(result: xarray.Dataset) -> list[str]:
    """Sums by zone and contact, the largest first."""
    found = quantiles(result, "contact")
    order = found.P50.values.argsort(kind="stable")[::-1]
    return [found.contact.values.tolist()[k] for k in order]


def _settled(result: xarray.Dataset, name: str) -> str:
    """The caption of a sum: the parameter that matters most, if one does."""
    if not result.sizes["parameter"] or int((result.status == 1).sum()) < LEAST:
        return f"{name}."
    found = tornado(result, name, "contact")
    most = found.isel(parameter=0)
    rank, noise = float(most.rank_correlation), found.attrs["noise"]
    if abs(rank) <= noise:
        return f"{name}: no rank correlation is above {noise:.2f}, which may be chance."
    return f"{name}: depends most on {most.parameter.item()} (rank correlation {number(rank, 2)})."


def quantile_table(result: xarray.Dataset, by: str) -> Table:
    """Quantiles of volumes [million m3], and in what share of the realisations each is present."""
    found = quantiles(result, by)
    keys = ("P90", "P50", "P10", "mean", "sd", "base")
    rows = [
        (
            str(name),
            *(number(float(found[key][row]) / MILLION, 3) for key in keys),
            f"{100.0 * float(found.present[row]):.0f} %",
        )
        for row, name in enumerate(found[by].values.tolist())
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
        (str(int(result.realization[k])), str(result.reason.values[k]))
        for k in failed[:MOST_REASONS]
    ]
    if len(failed) > MOST_REASONS:
        rows.append((NOTHING, f"and {len(failed) - MOST_REASONS} more: result.reason"))
    return Table(("realisation", "reason"), tuple(rows), n_label=2)


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
