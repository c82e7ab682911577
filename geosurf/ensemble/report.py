"""The report of an ensemble: one HTML page with quantiles, charts and maps."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.conventions import counted
from geosurf.conventions.packages import need_plots
from geosurf.conventions.running import running
from geosurf.ensemble.charts import (
    detail_chart,
    juxtaposition_chart,
    map_chart,
    png_of,
    quantile_chart,
)
from geosurf.ensemble.juxtapositions import juxtaposition
from geosurf.ensemble.record import expect_ensemble
from geosurf.ensemble.results import LEAST, quantiles, tornado
from geosurf.errors import OutputError
from geosurf.files.atomic import write_whole
from geosurf.model.expected import path_of
from geosurf.render.compose import save_png
from geosurf.report import page
from geosurf.report.input_tables import described_files, file_table
from geosurf.report.page import NOTHING, Section, Table, number
from geosurf.report.run_tables import version_table

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray

GROUPS = (("contact", "By zone and contact"), ("zone", "By zone"), ("block", "By block"),
          ("unit", "By unit"))  # fmt: skip
MOST_DETAILS = 6  # sums with a chart of their own: the largest ones
MOST_REASONS = 20
OUTSIDE = ("above ", "below ")  # zones whose volume depends on the model box
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
    names = _inside(result)
    chart = save_png(png_of(quantile_chart(result, names, "contact")), pictures / "quantiles.png")
    tables = "\n".join(
        page.folded(words, page.html_table(quantile_table(result, by)))
        if by != "contact" else page.html_table(quantile_table(result, by))
        for by, words in GROUPS
    )  # fmt: skip
    drawn = page.figure("P90 to P10 by zone and contact.", chart)
    yield Section("Volumes [million m³]", f"{drawn}\n{tables}")

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


def _inside(result: xarray.Dataset) -> list[str]:
    """Sums by zone and contact between two horizons, the largest first."""
    found = quantiles(result, "contact")
    order = found.P50.values.argsort(kind="stable")[::-1]
    names = [found.contact.values.tolist()[k] for k in order]
    between = [name for name in names if not name.startswith(OUTSIDE)]
    return between or names


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


__all__ = ["report_ensemble"]
