"""Write the report of a model: one HTML page with tables, pictures and the certificate.

===========  ====================================================================
tables.py    tables of inputs, the model, its faults and wells, and of the run
page.py      tables, pictures and the interactive view as HTML
assets/      style sheets and scripts
===========  ====================================================================

The page contains its pictures, scripts and style sheet, so it is one file that needs no network and
prints well; its policy forbids the network. The same scene gives the same page, byte for byte.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import counted
from geosurf.conventions.axes import need_depth
from geosurf.conventions.crs import label
from geosurf.conventions.machine import warning_without_pictures
from geosurf.conventions.running import running
from geosurf.errors import InputError, warn
from geosurf.files import write_into_folder
from geosurf.model import Certificate
from geosurf.model.expected import expect, number_of, path_of
from geosurf.model.protocols import ReportedModel, missing_members
from geosurf.model.units import left_out
from geosurf.report import page, tables
from geosurf.report.page import NOTHING, Section, Table, number, viewer_part
from geosurf.report.tables import InputFile, described_files

__all__ = ["report_scene"]


@running("report")
def report_scene(
    scene: ReportedModel,
    folder: str | os.PathLike[str],
    pictures: Mapping[str, str | os.PathLike[str]] | None = None,
    *,
    title: str = "Reservoir model",
    certificate: Certificate | None = None,
    regions: Mapping[str, tuple[float, str]] | None = None,
    inputs: Mapping[str, str | os.PathLike[str]] | None = None,
    relative_to: str | os.PathLike[str] | None = None,
    include: str = "reservoir",
    volumetrics: Any = None,
) -> Path:
    """Write ``index.html``: volumes, pictures, certificate, inputs and run log of a model.

    The page has an interactive view of the units in three dimensions. It is one file, which needs
    no network.

    Parameters
    ----------
    scene : Scene
        Or any object with the members of ``geosurf.model.protocols.ReportedModel``.
    folder : path-like
        Folder of the page. It is created if it does not exist.
    pictures : mapping of str to path-like, optional
        Caption and PNG file of each picture. Default: the pictures that
        ``scene.render_pictures(folder)`` draws; where matplotlib is not installed, none: a
        `GeosurfWarning` states it.
    title : str
        Heading of the page. It has no date by default, so that the same scene gives the same page.
    certificate : Certificate, optional
        Result of an earlier ``scene.check()``. Default: that of the scene, which is checked if it
        was not before.
    regions : mapping of str to (float, str), optional
        Volumes [m3] of the same model from another program, by region, each with the name of
        the unit at that location, or ''.
    inputs : mapping of str to path-like, optional
        Files of the inputs, by name: the page lists their sizes and hashes. Default: those inputs
        of the scene that are paths.
    relative_to : path-like, optional
        Paths of files are printed relative to this folder. Default: the current folder.
    include : {"reservoir", "all"}
        ``"all"``: volumes and pictures also of over- and underburden.
    volumetrics : xarray.Dataset, optional
        Result of `Scene.volumetrics`.

    Returns
    -------
    Path
        File of the page.

    Raises
    ------
    InputError
        If a picture cannot be read, or for another word in `include`.
    OutputError
        If the page cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=3)
    >>> scene = gs.Scene(world.horizons, world.faults, world.box)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = report_scene(scene, folder, pictures={}, title="Two planes")
    ...     "<h1>Two planes</h1>" in page.read_text(encoding="utf-8")
    True
    """
    # all arguments are checked before the first picture is drawn, which takes seconds
    folder = path_of(folder, "report_scene")

    # the loop raises at the first missing member; a complete scene passes through it
    for needed in missing_members(scene, ReportedModel):
        raise InputError(
            f"report_scene takes a Scene; {type(scene).__name__} has no attribute {needed!r}. "
            "Make a scene with geosurf.Scene(horizons, faults, box)."
        )
    need_depth(scene.units.time, "reports")
    if certificate is not None:
        expect(certificate, Certificate, "certificate takes a Certificate", "scene.check() is one")

    regions = _checked_regions(regions)
    if pictures is None and (note := warning_without_pictures()) is not None:
        warn(note)
        pictures = {}
    if pictures is None:
        pictures = scene.render_pictures(folder, include=include)
    how = "give {caption: path of a PNG file}"
    expect(pictures, Mapping, "pictures takes a mapping", how)
    files = {str(key): path_of(path, f"picture {key!r}") for key, path in pictures.items()}
    sources = described_files(scene.input_files if inputs is None else inputs, relative_to)

    # last: the check of a large model is the most expensive step of the page
    certificate = certificate or getattr(scene, "certificate", None) or scene.check()
    html = build_page(scene, files, str(title), certificate, regions, sources, include, volumetrics)
    return write_into_folder(folder / "index.html", html.encode("utf-8"), "the report")


def _checked_regions(regions: Any) -> dict[str, tuple[float, str]]:
    """Return volumes of another program and names of units, by region."""
    how = "give {region: (volume in m3, name of a unit or '')}"
    expect({} if regions is None else regions, Mapping, "regions takes a mapping", how)
    volumes = {}
    for key, value in (regions or {}).items():
        if not (isinstance(value, tuple | list) and len(value) == 2):
            raise InputError(f"regions[{key!r}] is {value!r}; {how}.")
        volumes[str(key)] = number_of(value[0], f"the volume of region {key!r}"), str(value[1])
    return volumes


# ---- sections ----------------------------------------
# The sections of the page, in the order of a reader's questions.
#
# What is wrong, how much is there, what does it look like, what was it made of; then what geosurf
# changed, how the model fits the wells, each fault, the proof, and the run.


# ---- fault parts ----------------------------------------
# One part of the page per fault: Allan diagram, throw profile, juxtaposition, what was changed.


# files of pictures that show one fault, as `geosurf.scene.pictures` names them: kind and row
OF_FAULT = re.compile(r"(allan|throw)_(\d+)_.*\.png")


def pictures_of_faults(
    scene: ReportedModel, pictures: Mapping[str, Path]
) -> tuple[dict[str, dict[str, Path]], dict[str, Path]]:
    """Return the pictures of each fault, and all other pictures."""
    names = scene.fault_names
    by_fault: dict[str, dict[str, Path]] = {}
    others = {}
    for caption, path in pictures.items():
        found = OF_FAULT.fullmatch(path.name)
        if found and int(found[2]) < len(names):
            by_fault.setdefault(names[int(found[2])], {})[caption] = path
        else:
            others[caption] = path
    return by_fault, others


def fault_parts(
    scene: ReportedModel, pictures: Mapping[str, Mapping[str, Path]], include: str = "reservoir"
) -> list[tuple[str, str]]:
    """Return the name and the HTML of each fault with something to show."""
    extended, truncated = tables.fault_tables(scene.fault_actions)
    thrown = tables.sheet_table(scene.sheets)
    inside = set(scene.faults_inside)
    changed = {row[0] for table in (extended, truncated) for row in table.rows}

    # in the order of the inputs; faults outside of the model count where they were changed
    faults: list[tuple[str, str]] = []
    for name in dict.fromkeys([*scene.fault_names, *scene.faults_inside, *sorted(changed)]):
        if name not in inside | changed and name not in pictures:
            continue
        across = [scene.juxtaposition(name, include)] if name in inside else []
        parts = [
            page.html_pictures(pictures.get(name, {})),
            _part("Juxtaposition", _rows(tables.juxtaposition_table(across), name, 0)),
            _part("Throw and heave of torn horizons", _rows(thrown, name, 1)),
            _part("Extended", _rows(extended, name, 0)),
            _part("Truncated", _rows(truncated, name, 0)),
        ]
        head = f'<h3 id="{page.part_name("fault", len(faults))}">{escape(name)}</h3>'
        faults.append((name, "\n".join([head, *filter(None, parts)])))
    return faults


def _rows(table: Table, fault: str, column: int) -> Table:
    """The rows of one fault, without the column of its name."""
    rows = tuple((*row[:column], *row[column + 1 :]) for row in table.rows if row[column] == fault)
    head = (*table.head[:column], *table.head[column + 1 :])
    return replace(table, head=head, rows=rows, n_label=table.n_label - 1)


def _part(heading: str, table: Table) -> str:
    return f"<h4>{heading}</h4>\n{page.html_table(table)}" if table.rows else ""


def build_page(
    scene: ReportedModel,
    pictures: Mapping[str, Path],
    title: str,
    certificate: Certificate,
    regions: Mapping[str, tuple[float, str]] | None = None,
    files: Iterable[InputFile] = (),
    include: str = "reservoir",
    volumetrics: Any = None,
) -> str:
    """Return the whole page as text."""
    surfaces, units, curves = tuple(scene.surfaces), scene.units, scene.curves
    slivers = counted(len(units.slivers), "sliver")
    apart = f" ({slivers} among them)" if units.slivers else ""
    facts = (
        f"{counted(len(units), 'unit')} from {counted(len(surfaces), 'surface')}{apart}; "
        f"{number(curves.length / 1000.0, 1)} km of intersection lines."
    )

    # whole metres where the box has them, decimetres otherwise
    west, east, south, north, bottom, top = map(_metres, scene.box)
    box = (
        f"Model box: easting {west} to {east} m, northing {south} to {north} m, "
        f"elevation {bottom} to {top} m."
    )
    if units.crs is not None:
        box += f" Coordinate reference system: {label(units.crs)}."
    header = "\n".join(
        [
            page.paragraph(facts),
            page.paragraph(box, "faint"),
            page.verdict(certificate.ok, len(certificate.checks)),
            page.badge(*tables.throw_in_words(scene.sheets)),
        ]
    )
    sections = _sections(scene, pictures, certificate, regions or {}, tuple(files), include)
    if volumetrics is not None:
        where = [section.name for section in sections].index("volumes") + 1
        fluids = volumetrics_table(volumetrics)
        sections[where:where] = _listed("Fluids in place [millions]", fluids)
    return page.fill_page(title, header, sections)


def _sections(
    scene: ReportedModel,
    pictures: Mapping[str, Path],
    certificate: Certificate,
    regions: Mapping[str, tuple[float, str]],
    files: tuple[InputFile, ...],
    include: str,
) -> list[Section]:
    """All sections; those without content are left out by the page."""
    of_faults, others = pictures_of_faults(scene, pictures)
    view, others = _view(scene, others)
    faults = fault_parts(scene, of_faults, include)
    return [
        *_listed("Warnings", tables.warning_table(scene.warnings)),
        Section("Gross rock volume (GRV) [million m³]", _volumes(scene, include), name="volumes"),
        Section("Interactive view", view, name="view"),
        Section("Inputs", _inputs(scene, files)),
        *_listed("Regions of the input file and the units",
                 tables.region_table(scene.units, regions)),
        *_changes(scene, include),
        Section("Well tops and the model", _wells(scene)),
        Section("Pictures", page.html_pictures(others)),
        Section("Faults", "\n".join(html for _, html in faults), tuple(n for n, _ in faults)),
        Section("Fault polygons", _polygons(scene)),
        Section("Reports of torn horizons", _sheets(scene)),
        Section("Certificate", page.html_table(tables.check_table(certificate))),
        Section("Intersection lines", _lines(scene)),
        Section("Run log", _run_log(scene)),
        Section("Versions", page.html_table(tables.version_table())),
    ]  # fmt: skip


def _volumes(scene: ReportedModel, include: str) -> str:
    """The table of volumes and what it adds up to."""
    how = 'To list them: include="all" (in a scenario: in [output]).'
    notes = left_out(scene.units, how, include), scene.units.included(include).ends_at_box
    words = [*filter(None, notes), tables.balance(scene.units), *tables.accuracy(scene)]
    table = page.html_table(tables.volume_table(scene.units, include))
    return "\n".join([table, *map(page.paragraph, words)])


def volumetrics_table(volumes: Any) -> Table:
    """Return what `Scene.volumetrics` found, in millions: one row per zone, region and fluid."""
    columns = list(volumes.data_vars.values())
    head = [
        f"{column.attrs['long_name']} [{column.attrs['units']}]".replace("m3", "m³")
        for column in columns
    ]
    values = np.stack([column.values for column in columns], axis=1) / 1e6
    decimals = [6 if column.attrs["units"] == "acre-ft" else 3 for column in columns]
    labels = [key for key in ("zone", "region", "fluid") if key in volumes.coords]
    names = list(zip(*(volumes[key].values.tolist() for key in labels), strict=True))
    rows = []
    for name in dict.fromkeys(names):
        sums = values[[label == name for label in names]].sum(axis=0)
        cells = (
            NOTHING if np.isnan(total) else number(total, decimal)
            for total, decimal in zip(sums, decimals, strict=True)
        )
        rows.append((*(word or NOTHING for word in name), *cells))
    foot = ("all", *[""] * (len(labels) - 1), *map(number, np.nansum(values, axis=0), decimals))
    words = (key.capitalize() for key in labels)
    return Table((*words, *head), tuple(rows), n_label=len(labels), foot=foot)


def _view(scene: ReportedModel, pictures: Mapping[str, Path]) -> tuple[str, dict[str, Path]]:
    """The interactive view with a still picture for paper, and the other pictures."""
    view = scene.view_3d()
    others = dict(pictures)
    if view is None or not view.bodies:
        return "", others

    # the exploded view shows the same units: where WebGL is missing, it is what readers see
    still = next((key for key, path in others.items() if path.name == "units_exploded.png"), None)
    html = viewer_part(view)
    if still is not None:
        html += f'\n<div class="still">{page.figure(still, others.pop(still))}</div>'
    return html, others


def _inputs(scene: ReportedModel, files: tuple[InputFile, ...]) -> str:
    """Files of the inputs, and how much of each surface is inside the model."""
    crs = "" if scene.units.crs is None else label(scene.units.crs)
    listed = page.html_table(tables.file_table(files, crs))
    surfaces = page.html_table(tables.surface_table(scene.surfaces, scene.coverage))
    words = page.paragraph("Share of each surface inside the model, and its extent [m].")
    return "\n".join(filter(None, [listed, words, surfaces]))


def _changes(scene: ReportedModel, include: str) -> Iterable[Section]:
    """What geosurf made of the inputs: contacts, slivers, pieces, clipped horizons."""
    units = scene.units
    clipped, thin = (units.report.get(key, ()) for key in ("clipped", "thin"))
    small = {sliver.name for sliver in units.slivers}
    pieces = [piece for piece in units.remnants() if piece.name not in small]
    yield from _listed("Virtual walls", tables.virtual_table(scene.virtual_walls))
    yield from _listed("Compartments of blocks", tables.compartment_table(units, include))
    yield from _listed(
        "Horizons clipped by the stratigraphic column", tables.clipped_table(clipped)
    )
    yield from _listed("Fluid contacts", tables.contact_table(scene))
    yield from _listed("Units not covered by a fluid contact", tables.left_out_table(units))
    if units.slivers:
        table = page.html_table(tables.remnant_table(units.slivers))
        count = counted(len(units.slivers), "sliver")
        heading = f"Slivers: units {units.sliver_settings.rule}"
        yield Section(heading, page.folded(count, table), name="slivers")
    yield from _listed("Slivers merged into their neighbours", tables.merged_table(units.merged))
    yield from _listed("Detached pieces", tables.remnant_table(pieces))
    listed = tables.remnant_table(thin, ".1e")
    yield from _listed("Units thinner than the rounding error", listed)


def _lines(scene: ReportedModel) -> str:
    """Intersection lines of all pairs of surfaces."""
    lengths = page.html_table(tables.curve_table(scene.curves))
    return lengths or page.paragraph("No two surfaces intersect.")


def _run_log(scene: ReportedModel) -> str:
    """Counts of the stages, and the steps that ran or were skipped."""
    # these entries have sections of their own, or `explain` lists them
    elsewhere = ("clipped", "without_contact", "outside", "thin")
    carved = {key: value for key, value in scene.units.report.items() if key not in elsewhere}
    rebuilt = dict(scene.patches.report)
    if "dropped_area" in rebuilt:  # the keys are rows of surfaces: the page prints names
        names = scene.patches.names
        rebuilt["dropped_area"] = {names[i]: a for i, a in rebuilt["dropped_area"].items()}

    # work counts instead of seconds: they do not depend on the machine, so pages can be compared
    costs = tables.count_table(
        ("intersect", scene.curves.cost), ("rebuild", rebuilt), ("carve", carved)
    )
    # each step once, as it ran: how often its result was at hand depends on the free memory
    steps = {(step.stage, step.subject): step for step in reversed(scene.steps)}
    width = max((len(subject) for _, subject in steps), default=0)
    log = "\n".join(
        replace(step, outcome=step.outcome.replace("from memory", "ran")).words(
            width, seconds=False
        )
        for step in reversed(steps.values())
    )
    return f"{page.html_table(costs)}\n<pre>{escape(log)}</pre>"


def _wells(scene: ReportedModel) -> str:
    """Misfits of well tops, if the scene has some."""
    if scene.tops is None:
        return ""
    misfit = scene.misfit()
    words = map(page.paragraph, tables.misfit_words(misfit))
    return "\n".join([page.html_table(tables.misfit_table(misfit)), *words])


def _polygons(scene: ReportedModel) -> str:
    """Fault polygons of all horizons inside the model, if there are faults."""
    if not scene.faults_inside:
        return ""
    names = scene.horizons_inside
    found = (scene.fault_polygons(name) for name in names)
    return page.html_table(tables.polygon_table(found))


def _sheets(scene: ReportedModel) -> str:
    """The report of each torn sheet."""
    sheets = scene.sheets
    reports = "\n\n".join(f"{name}\n{sheet.report}" for name, sheet in sheets.items())
    return f"<pre>{escape(reports)}</pre>" if sheets else ""


def _listed(heading: str, table: Table) -> list[Section]:
    """A section of its own, if the table has rows."""
    return [Section(heading, page.html_table(table))] if table.rows else []


def _metres(value: float) -> str:
    return number(value, 0 if value == round(value) else 1)
