"""A scene as one HTML page: what went in, what came out, whether it is sealed.

The page holds its pictures and its style, asks the network for nothing, prints
well, and is the same, byte for byte, each time the same scene is reported.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from geosurf.conventions import counted
from geosurf.errors import InputError, OutputError
from geosurf.files.atomic import write_whole
from geosurf.model import Certificate
from geosurf.model.expected import expect, number_of, path_of
from geosurf.report import page, tables

__all__ = ["report_scene"]


def report_scene(
    scene: Any,
    folder: str | os.PathLike[str],
    pictures: Mapping[str, str | os.PathLike[str]] | None = None,
    *,
    title: str = "Reservoir model",
    made: str = "",
    certificate: Certificate | None = None,
    min_volume: float = 0.0,
    regions: Mapping[str, tuple[float, str]] | None = None,
) -> Path:
    """Write ``index.html``: inputs, volumes, curves, certificate, pictures, cost.

    Parameters
    ----------
    scene : Scene
        Or anything with ``surfaces``, ``units``, ``curves``, ``patches``, ``box`` and ``check()``;
        ``explain(seconds=False)``, ``render_pictures(folder)``, ``sheets``, ``warnings``, and
        ``faults_inside`` with what is measured along them are used where they exist.
    folder : path-like
        Is created if need be.
    pictures : mapping of str to path-like, optional
        Caption and PNG file of each picture. Default: what
        ``scene.render_pictures(folder)`` draws, if the scene can.
    title : str
    made : str
        A date or a name to print below the title. Nothing is printed by itself,
        so that the same scene gives the same page.
    certificate : Certificate, optional
        What ``scene.check()`` gave, if it is there already. Default: it is asked.
    min_volume : float
        Units smaller than this are listed as remnants, along with numbered ones [m3].
    regions : mapping of str to (float, str), optional
        Volumes that somebody else found for the same model [m3], each with the name of the unit
        that lies there, or ''.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    InputError
        If a picture cannot be read.
    OutputError
        If the page cannot be written.

    Examples
    --------
    A box of 1 km by 1 km by 100 m that nothing cuts:

    >>> import tempfile
    >>> from types import SimpleNamespace
    >>> import numpy as np
    >>> from geosurf.model import Certificate, Curves, Units
    >>> none = np.empty((0, 2), dtype=np.int64)
    >>> scene = SimpleNamespace(
    ...     surfaces=(),
    ...     curves=Curves((), np.empty((0, 3)), np.zeros(3), none, none, (), none, np.empty(0)),
    ...     patches=SimpleNamespace(report={}),
    ...     units=Units([], (0, 1000, 0, 1000, -100, 0)),
    ...     box=(0, 1000, 0, 1000, -100, 0),
    ...     check=lambda: Certificate(()),
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = report_scene(scene, folder, title="An empty box")
    ...     "<h1>An empty box</h1>" in page.read_text(encoding="utf-8")
    True
    """
    folder = path_of(folder, "report_scene")
    for needed in ("surfaces", "units", "curves", "patches", "box", "check"):
        if not hasattr(scene, needed):
            raise InputError(
                f"report_scene takes a Scene, not {type(scene).__name__}, which has no {needed}; "
                "make one with geosurf.Scene(horizons, faults, box)."
            )
    min_volume = number_of(min_volume, "min_volume", "give cubic metres")
    if certificate is not None:
        expect(certificate, Certificate, "certificate takes a Certificate", "scene.check() is one")
    regions = _checked_regions(regions)
    if pictures is None:
        draw = getattr(scene, "render_pictures", None)
        pictures = draw(folder) if draw is not None else {}
    how = "give {caption: path of a PNG file}"
    expect(pictures, Mapping, "pictures takes a mapping", how)
    files = {str(key): path_of(path, f"picture {key!r}") for key, path in pictures.items()}
    certificate = certificate or scene.check()
    html = build_page(
        scene,
        files,
        str(title),
        str("" if made is None else made),
        certificate,
        min_volume,
        regions,
    )
    return _write(folder / "index.html", html)


def _checked_regions(regions: Any) -> dict[str, tuple[float, str]]:
    """Volumes that somebody else found, and names of units, by region."""
    how = "give {region: (volume in m3, name of a unit or '')}"
    expect({} if regions is None else regions, Mapping, "regions takes a mapping", how)
    found = {}
    for key, value in (regions or {}).items():
        if not (isinstance(value, tuple | list) and len(value) == 2):
            raise InputError(f"regions[{key!r}] is {value!r}; {how}.")
        found[str(key)] = number_of(value[0], f"the volume of region {key!r}"), str(value[1])
    return found


def build_page(
    scene: Any,
    pictures: Mapping[str, Path],
    title: str,
    made: str,
    certificate: Certificate,
    min_volume: float = 0.0,
    regions: Mapping[str, tuple[float, str]] | None = None,
) -> str:
    """Return the whole page as text."""
    surfaces, units, curves = tuple(scene.surfaces), scene.units, scene.curves
    facts = (
        f"{counted(len(surfaces), 'surface')} meet along {counted(curves.n_curve, 'curve')} "
        f"({tables.number(curves.length, 1)} m) and bound {counted(len(units), 'unit')}."
    )
    west, east, south, north, bottom, top = map(_metres, scene.box)
    box = (
        f"Model box: easting {west} to {east} m, northing {south} to {north} m, "
        f"elevation {bottom} to {top} m."
    )
    header = "\n".join(
        [
            *([page.paragraph(made, "faint")] if made else []),
            page.paragraph(facts),
            page.paragraph(box, "faint"),
            page.verdict(certificate.ok),
        ]
    )
    return page.fill_page(
        title, header, _sections(scene, pictures, certificate, min_volume, regions or {})
    )


def _sections(
    scene: Any,
    pictures: Mapping[str, Path],
    certificate: Certificate,
    min_volume: float,
    regions: Mapping[str, tuple[float, str]],
) -> list[tuple[str, str]]:
    """Headings, and what stands below each; what is empty is left out."""
    units, curves = scene.units, scene.curves
    volumes = page.html_table(tables.volume_table(units))
    balance = [tables.balance(units), *filter(None, [tables.simplified(scene)])]
    lengths = page.html_table(tables.curve_table(curves))
    clipped, remnants = units.report.get("clipped", ()), units.remnants(min_volume)
    told = (
        "clipped",
        "without_contact",
        "outside",
        "thin",
    )  # in sections of their own, and by explain
    carved = {key: value for key, value in units.report.items() if key not in told}
    rebuilt = dict(scene.patches.report)
    if "dropped_area" in rebuilt:  # by row of the surfaces
        names = scene.patches.names
        rebuilt["dropped_area"] = {names[i]: a for i, a in rebuilt["dropped_area"].items()}
    costs = tables.cost_table(("intersect", curves.cost), ("rebuild", rebuilt), ("carve", carved))
    return [
        *_listed("Warnings", tables.warning_table(getattr(scene, "warnings", ()))),
        ("Volumes [million m³]", "\n".join([volumes, *map(page.paragraph, balance)])),
        *_listed("Regions of the file beside the units", tables.region_table(units, regions)),
        *_listed("Horizons clipped by the column", tables.clipped_table(clipped)),
        *_listed("Fluid contacts", tables.contact_table(scene)),
        *_listed("Units that a fluid contact leaves out", tables.left_out_table(units)),
        *_listed("Remnants: numbered and small units", tables.remnant_table(remnants)),
        *_listed("Units as thin as rounding", tables.thin_table(units.report.get("thin", ()))),
        ("Pictures", page.html_pictures(pictures)),
        ("Across the faults: areas of contact", _across(scene)),
        ("Fault polygons", _polygons(scene)),
        ("Torn horizons: throw and heave at their faults", _sheets(scene)),
        ("Certificate", page.html_table(tables.check_table(certificate))),
        ("Faults: what was extended and truncated", _fault_work(scene)),
        ("Surfaces, with their bounds [m]", page.html_table(tables.surface_table(scene.surfaces))),
        ("Curves", lengths or page.paragraph("No two surfaces meet.")),
        ("What it took", page.html_table(costs) + _explanation(scene)),
        ("Versions", page.html_table(tables.version_table())),
    ]


def _across(scene: Any) -> str:
    """Areas of juxtaposition, where the scene can measure them."""
    names = getattr(scene, "faults_inside", ())
    return page.html_table(
        tables.juxtaposition_table(map(scene.juxtaposition, names) if names else ())
    )


def _polygons(scene: Any) -> str:
    """Fault polygons of all horizons inside the model, where there are faults."""
    if not getattr(scene, "faults_inside", ()):
        return ""
    names = scene.horizons_inside
    return page.html_table(tables.polygon_table(scene.fault_polygons(name) for name in names))


def _sheets(scene: Any) -> str:
    """How horizons were torn, where any is: a table, and what was distrusted and missed."""
    sheets = getattr(scene, "sheets", {})
    told = "\n\n".join(f"{name}\n{sheet.report}" for name, sheet in sheets.items())
    table = page.html_table(tables.sheet_table(sheets))
    return f"{table}\n<pre>{escape(told)}</pre>" if sheets else ""


def _fault_work(scene: Any) -> str:
    """Extensions and truncations, where the scene has made any."""
    extensions, truncations = tables.fault_tables(getattr(scene, "fault_actions", ()))
    return "\n".join(filter(None, map(page.html_table, (extensions, truncations))))


def _listed(heading: str, table: tables.Table) -> list[tuple[str, str]]:
    """A section of its own, if there is anything to list."""
    return [(heading, page.html_table(table))] if table.rows else []


def _metres(value: float) -> str:
    return tables.number(value, 0 if value == round(value) else 1)


def _explanation(scene: Any) -> str:
    """What ran and what was skipped, where the scene can tell; no times, so that pages agree."""
    explain = getattr(scene, "explain", None)
    return f"\n<pre>{escape(str(explain(seconds=False)))}</pre>" if explain is not None else ""


def _write(target: Path, html: str) -> Path:
    """Write the page in one go: readers see the old page or the new one, never half of it."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, html.encode("utf-8"))
    except OSError as error:
        raise OutputError(
            f"{target}: the report cannot be written ({error.strerror}). "
            "Choose a folder that you may write to."
        ) from error
    return target
