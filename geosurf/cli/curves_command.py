"""The command ``curves``: the intersection lines of two surface files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from geosurf.cli.answer import Answer
from geosurf.errors import FormatError


def curves_command(options: argparse.Namespace) -> Answer:
    """Find the curves of two surface files, and write them."""
    from geosurf.conventions import area_text, counted, length_text
    from geosurf.intersect import intersect_surfaces
    from geosurf.write import write

    # what a file states itself wins; these fill in the rest (`otherwise`)
    words = {"positive": options.positive, "length_unit": options.length_unit}
    surfaces = [_surface(Path(path), words) for path in (options.first, options.second)]

    # curves name their surfaces: files of one name are distinguished by their paths
    if surfaces[0].name == surfaces[1].name:
        surfaces = [surfaces[0].renamed(options.first), surfaces[1].renamed(options.second)]
    curves = intersect_surfaces(surfaces)
    closed = int(curves.closed.sum())
    paths = write(curves, options.out)
    lines = [
        f"{path}: {counted(curves.n_curve, 'curve')}, {closed} closed, "
        f"{length_text(curves.length, 5)}"
        for path in paths
    ]

    # the file holds curves only: other contacts are printed
    points = sum(contact.kind == "point" for contact in curves.contacts)
    if points:
        lines.append(f"The surfaces also touch at {counted(points, 'point')}.")
    area = sum(contact.area for contact in curves.contacts)
    if len(curves.contacts) > points:
        covered = area_text(area, 6)
        lines.append(f"They coincide over {covered}; curves follow the outline of that area.")
    data = {
        "files": [str(path) for path in paths],
        "curves": curves.n_curve,
        "closed": closed,
        "length_m": curves.length,
        "touching_points": points,
        "coincident_area_m2": area,
    }
    return Answer(data, "\n".join(lines))


def _surface(path: Path, words: dict[str, str | None]) -> Any:
    """Read one surface: a horizon or a fault, by content, else by suffix; NetCDF by dimensions."""
    from geosurf.read import FAULT_FORMATS, GRID_FORMATS, otherwise, read_fault, read_nodes
    from geosurf.read._detect import detect
    from geosurf.read.netcdf import holds_fault
    from geosurf.triangulate import triangulate_fault, triangulate_horizon

    # the content decides where it can; a file that neither content nor suffix shows is refused
    suffix = path.suffix.lower()
    formats = (*GRID_FORMATS.values(), *FAULT_FORMATS.values())
    known = {word for _, _, suffixes in formats for word in suffixes}
    found = detect(path) if path.is_file() else None
    if suffix not in known and found not in {*GRID_FORMATS, *FAULT_FORMATS}:
        missing = "" if path.exists() else " and the file does not exist"
        raise FormatError(
            f"{path}: the suffix {path.suffix!r} is not that of a surface file{missing}. "
            f"Surface files end with {', '.join(sorted(known))}. Rename the file, or save it "
            "in one of these formats."
        )

    # NetCDF holds grids and faults; its dimensions decide
    by_suffix = any(suffix in suffixes for _, _, suffixes in GRID_FORMATS.values())
    gridded = found in GRID_FORMATS if found else by_suffix
    if found == "netcdf" or (found is None and suffix in GRID_FORMATS["netcdf"][2]):
        gridded = not holds_fault(path)
    if gridded:
        return triangulate_horizon(read_nodes(path, **otherwise(words)), name=path.stem)

    # some files hold triangles, others sticks or grids, which become triangles here
    fault = read_fault(path, **otherwise(words))
    return fault if hasattr(fault, "triangles") else triangulate_fault(fault, name=path.stem)
