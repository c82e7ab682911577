"""Write the report of a model: one HTML page with tables, pictures and the certificate.

===============  ====================================================================
table.py         a table of text, the number format, plain-text output
tables.py        tables of a model: surfaces, volumes, contacts, intersection lines
fault_tables.py  tables of faults: extension, juxtaposition, polygons, throw and heave
well_tables.py   tables of well tops: misfits
run_tables.py    tables of a run: warnings, certificate, counts, versions
page.py          tables and pictures as HTML
===============  ====================================================================

The page contains its pictures and its style sheet, so it is one file that needs no network and
prints well. The same scene gives the same page, byte for byte.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from geosurf.conventions import counted
from geosurf.conventions.crs import label
from geosurf.errors import InputError, OutputError
from geosurf.files.atomic import write_whole
from geosurf.model import Certificate
from geosurf.model.expected import expect, number_of, path_of
from geosurf.model.protocols import ReportedModel, missing_members
from geosurf.report import fault_tables, page, run_tables, tables, well_tables
from geosurf.report.table import Table, number

__all__ = ["report_scene"]


def report_scene(
    scene: ReportedModel,
    folder: str | os.PathLike[str],
    pictures: Mapping[str, str | os.PathLike[str]] | None = None,
    *,
    title: str = "Reservoir model",
    made: str = "",
    certificate: Certificate | None = None,
    regions: Mapping[str, tuple[float, str]] | None = None,
) -> Path:
    """Write ``index.html``: volumes, pictures, certificate, inputs and run log of a model.

    Parameters
    ----------
    scene : Scene
        Or any object with the members of ``geosurf.model.protocols.ReportedModel``.
    folder : path-like
        Folder of the page. It is created if it does not exist.
    pictures : mapping of str to path-like, optional
        Caption and PNG file of each picture. Default: the pictures that
        ``scene.render_pictures(folder)`` draws.
    title : str
        Heading of the page.
    made : str
        A date or a name to print below the title. By default the page has no date, so
        the same scene gives the same page.
    certificate : Certificate, optional
        Result of an earlier ``scene.check()``. Default: the check is run.
    regions : mapping of str to (float, str), optional
        Volumes [m3] of the same model from another program, by region, each with the name of
        the unit at that location, or ''.

    Returns
    -------
    Path
        File of the page.

    Raises
    ------
    InputError
        If a picture cannot be read.
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
    if certificate is not None:
        expect(certificate, Certificate, "certificate takes a Certificate", "scene.check() is one")

    regions = _checked_regions(regions)
    if pictures is None:
        pictures = scene.render_pictures(folder)
    how = "give {caption: path of a PNG file}"
    expect(pictures, Mapping, "pictures takes a mapping", how)
    files = {str(key): path_of(path, f"picture {key!r}") for key, path in pictures.items()}

    # last: the check of a large model is the most expensive step of the page
    certificate = certificate or scene.check()
    html = build_page(
        scene,
        files,
        str(title),
        str("" if made is None else made),
        certificate,
        regions,
    )
    return _write(folder / "index.html", html)


def _checked_regions(regions: Any) -> dict[str, tuple[float, str]]:
    """Return volumes of another program and names of units, by region."""
    how = "give {region: (volume in m3, name of a unit or '')}"
    expect({} if regions is None else regions, Mapping, "regions takes a mapping", how)
    found = {}
    for key, value in (regions or {}).items():
        if not (isinstance(value, tuple | list) and len(value) == 2):
            raise InputError(f"regions[{key!r}] is {value!r}; {how}.")
        found[str(key)] = number_of(value[0], f"the volume of region {key!r}"), str(value[1])
    return found


def build_page(
    scene: ReportedModel,
    pictures: Mapping[str, Path],
    title: str,
    made: str,
    certificate: Certificate,
    regions: Mapping[str, tuple[float, str]] | None = None,
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
            *([page.paragraph(made, "faint")] if made else []),
            page.paragraph(facts),
            page.paragraph(box, "faint"),
            page.verdict(certificate.ok, len(certificate.checks)),
        ]
    )
    return page.fill_page(title, header, _sections(scene, pictures, certificate, regions or {}))


def _sections(
    scene: ReportedModel,
    pictures: Mapping[str, Path],
    certificate: Certificate,
    regions: Mapping[str, tuple[float, str]],
) -> list[tuple[str, str]]:
    """Headings and the HTML below each; empty sections are left out."""
    units, curves = scene.units, scene.curves
    volumes = page.html_table(tables.volume_table(units))
    balance = [tables.balance(units), *tables.accuracy(scene)]
    lengths = page.html_table(tables.curve_table(curves))
    clipped, thin = (units.report.get(key, ()) for key in ("clipped", "thin"))
    small = {sliver.name for sliver in units.slivers}
    pieces = [piece for piece in units.remnants() if piece.name not in small]

    # these entries have sections of their own, or `explain` lists them
    elsewhere = ("clipped", "without_contact", "outside", "thin")
    carved = {key: value for key, value in units.report.items() if key not in elsewhere}
    rebuilt = dict(scene.patches.report)
    if "dropped_area" in rebuilt:  # the keys are rows of surfaces: the page prints names
        names = scene.patches.names
        rebuilt["dropped_area"] = {names[i]: a for i, a in rebuilt["dropped_area"].items()}

    # work counts instead of seconds: they do not depend on the machine, so pages can be compared
    costs = run_tables.count_table(
        ("intersect", curves.cost), ("rebuild", rebuilt), ("carve", carved)
    )
    return [
        *_listed("Warnings", run_tables.warning_table(scene.warnings)),
        ("Volumes [million m³]", "\n".join([volumes, *map(page.paragraph, balance)])),
        # from here on the order is that of questions: what is there, where does it hurt, does it
        # fit the wells, what did geosurf change
        *_listed("Regions of the input file and the units", tables.region_table(units, regions)),
        *_listed("Virtual walls", tables.virtual_table(scene.virtual_walls)),
        *_listed("Compartments of blocks", tables.compartment_table(units)),
        *_listed("Horizons clipped by the stratigraphic column", tables.clipped_table(clipped)),
        *_listed("Fluid contacts", tables.contact_table(scene)),
        *_listed("Units not covered by a fluid contact", tables.left_out_table(units)),
        *_listed(
            f"Slivers: units {units.sliver_settings.rule}", tables.remnant_table(units.slivers)
        ),
        *_listed("Slivers merged into their neighbours", tables.merged_table(units.merged)),
        *_listed("Detached pieces", tables.remnant_table(pieces)),
        *_listed("Units thinner than the rounding error", tables.thin_table(thin)),
        ("Well tops and the model", _wells(scene)),
        ("Pictures", page.html_pictures(pictures)),
        ("Juxtaposition across faults", _across(scene)),
        ("Fault polygons", _polygons(scene)),
        ("Throw and heave of torn horizons", _sheets(scene)),
        ("Certificate", page.html_table(run_tables.check_table(certificate))),
        ("Extended and truncated faults", _fault_work(scene)),
        (
            "Surfaces and their extent [m]",
            page.html_table(tables.surface_table(scene.surfaces, scene.coverage)),
        ),
        ("Intersection lines", lengths or page.paragraph("No two surfaces intersect.")),
        ("Run log", page.html_table(costs) + _explanation(scene)),
        ("Versions", page.html_table(run_tables.version_table())),
    ]


def _wells(scene: ReportedModel) -> str:
    """Misfits of well tops, if the scene has some."""
    if scene.tops is None:
        return ""
    misfit = scene.misfit()
    words = map(page.paragraph, well_tables.misfit_words(misfit))
    return "\n".join([page.html_table(well_tables.misfit_table(misfit)), *words])


def _across(scene: ReportedModel) -> str:
    """Areas of juxtaposition, if the scene has faults inside the model."""
    found = map(scene.juxtaposition, scene.faults_inside)
    return page.html_table(fault_tables.juxtaposition_table(found))


def _polygons(scene: ReportedModel) -> str:
    """Fault polygons of all horizons inside the model, if there are faults."""
    if not scene.faults_inside:
        return ""
    names = scene.horizons_inside
    return page.html_table(fault_tables.polygon_table(scene.fault_polygons(name) for name in names))


def _sheets(scene: ReportedModel) -> str:
    """Throw and heave of torn horizons, and the report of each torn sheet."""
    sheets = scene.sheets
    reports = "\n\n".join(f"{name}\n{sheet.report}" for name, sheet in sheets.items())
    table = page.html_table(fault_tables.sheet_table(sheets))
    return f"{table}\n<pre>{escape(reports)}</pre>" if sheets else ""


def _fault_work(scene: ReportedModel) -> str:
    """Extensions and truncations, if the scene made any."""
    extensions, truncations = fault_tables.fault_tables(scene.fault_actions)
    return "\n".join(filter(None, map(page.html_table, (extensions, truncations))))


def _listed(heading: str, table: Table) -> list[tuple[str, str]]:
    """A section of its own, if the table has rows."""
    return [(heading, page.html_table(table))] if table.rows else []


def _metres(value: float) -> str:
    return number(value, 0 if value == round(value) else 1)


def _explanation(scene: ReportedModel) -> str:
    """The steps that ran or were skipped; without times, so that pages of two runs agree."""
    return f"\n<pre>{escape(scene.explain(seconds=False))}</pre>"


def _write(target: Path, html: str) -> Path:
    """Write the page atomically: readers see the old page or the new one, never a part."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, html.encode("utf-8"))
    except OSError as error:
        raise OutputError(
            f"{target}: the report cannot be written ({error.strerror}). "
            "Choose a folder that you can write to."
        ) from error
    return target
