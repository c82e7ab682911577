"""Write the report of a model: one HTML page with tables, pictures and the certificate.

===========  ====================================================================
sections.py  the sections of the page, in their order; a part for each fault
tables.py    tables of inputs, the model, its faults and wells, and of the run
page.py      tables and pictures as HTML
viewer.py    the interactive view in three dimensions
assets/      style sheets and scripts
===========  ====================================================================

The page contains its pictures, scripts and style sheet, so it is one file that needs no network and
prints well; its policy forbids the network. The same scene gives the same page, byte for byte.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geosurf.conventions.machine import warning_without_pictures
from geosurf.conventions.running import running
from geosurf.errors import InputError
from geosurf.files import write_into_folder
from geosurf.model import Certificate
from geosurf.model.expected import expect, number_of, path_of
from geosurf.model.protocols import ReportedModel, missing_members
from geosurf.report.sections import build_page
from geosurf.report.tables import input_files
from geosurf.warning import warn

__all__ = ["report_scene"]


@running("report")
def report_scene(
    scene: ReportedModel,
    folder: str | os.PathLike[str],
    pictures: Mapping[str, str | os.PathLike[str]] | None = None,
    *,
    title: str = "Reservoir model",
    made: str = "",
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
        Heading of the page.
    made : str
        A date or a name to print below the title. By default the page has no date, so
        the same scene gives the same page.
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
    sources = input_files(scene, inputs, relative_to)

    # last: the check of a large model is the most expensive step of the page
    certificate = certificate or getattr(scene, "certificate", None) or scene.check()
    words = str(title), str("" if made is None else made)
    html = build_page(scene, files, *words, certificate, regions, sources, include, volumetrics)
    return write_into_folder(folder / "index.html", html.encode("utf-8"), "the report")


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
