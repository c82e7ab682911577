"""Units of a sealed model in a file: GOCAD Model3d, whose regions list their parts, or RESQML.

``LAYER`` states the zone of a region of a Model3d, ``FAULT_BLOCK`` its block; models that geosurf
wrote hold all labels of their units. What parts and regions mean is in
`geosurf.read.sealed_model`.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from geosurf.errors import FormatError
from geosurf.model import Units
from geosurf.model.expected import path_of
from geosurf.read._common import Request, read_text
from geosurf.read._detect import detect
from geosurf.read.gocad import read_tsurf
from geosurf.read.model3d import own_lines, part_counts, region_lists, roles_of, surfaces_of
from geosurf.read.resqml.units import resqml_model
from geosurf.read.sealed_model import SealedModel, labels_of, units_of


def read_units(
    path: str | PathLike[str], *, positive: str | None = None, length_unit: str | None = None
) -> Units:
    """
    Read the units of a sealed model: GOCAD Model3d (``.ml``), or RESQML 2.0.1 (``.epc``).

    Parameters
    ----------
    path : path-like
    positive : {"up", "down"}, optional
        For ``.ml`` without ZPOSITIVE; default ``"up"``, the default of GOCAD.
    length_unit : str, optional
        Unit of elevations, for ``.ml`` without AXIS_UNIT; default ``"m"``. RESQML states both.

    Returns
    -------
    Units
        One for each region but ``Universe``, in the order of the file. ``zone`` is the layer of the
        region and ``block`` its fault block; the region's own name stands where the file has none.
        RESQML names the zone of a region only.
        Models that geosurf wrote come back with all labels.

    Raises
    ------
    FormatError
        If the file is neither of both, has no regions, or a region is not closed; or a line cannot
        be understood.
    InputError
        If `positive` or `length_unit` contradicts the file or is unknown.
    DependencyError
        If the file is RESQML and h5py is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import geosurf as gs
    >>> world = gs.synthetic.tilted_planes(n=5)
    >>> units = gs.Scene(world.horizons, world.faults, world.box).units
    >>> (file,) = gs.write(units, pathlib.Path(tempfile.mkdtemp()) / "model.ml")
    >>> list(read_units(file)) == list(units)
    True
    """
    path = path_of(path, "read_units")
    if detect(path) == "resqml":
        return units_of(resqml_model(path, Request(positive=positive, length_unit=length_unit)))
    return units_of(_model(path, Request(positive=positive, length_unit=length_unit)))


def _model(path: Path, request: Request) -> SealedModel:
    """What a Model3d states."""
    lines = read_text(path, final_line_end=False).split("\n")
    roles = roles_of(path, lines)
    regions = [(name, signed) for name, signed, _ in region_lists(path, lines)]
    if not any(name != "Universe" for name, _ in regions):
        raise FormatError(
            f"{path}: the model has no regions. Read its surfaces with "
            "geosurf.read.model3d.read_model3d and build a Scene of them."
        )
    tsurfs = read_tsurf(path, request)
    sources = list(surfaces_of(path, lines, roles, tsurfs).values())
    counts = part_counts(path, lines, sum(len(one.triangles) for one in tsurfs))
    inside = [(name, signed) for name, signed in regions if name != "Universe"]
    own = own_lines(path, lines, "model")
    labels = _labels(path, lines, inside)
    box = own[0] if own else ()
    return SealedModel(path, tsurfs, sources, counts, inside, labels, box, "TFACE")


def _labels(
    path: Path, lines: list[str], regions: list[tuple[str, list[int]]]
) -> list[dict[str, Any]]:
    """Labels of each unit."""
    own = own_lines(path, lines, "unit")
    if own:
        return labels_of(path, own, len(regions), "the header")
    return _labels_of_groups(lines, [name for name, _ in regions])


def _labels_of_groups(lines: list[str], names: list[str]) -> list[dict[str, Any]]:
    """Labels of units by the layers and fault blocks of the file."""
    zones, blocks = _groups(lines, "LAYER"), _groups(lines, "FAULT_BLOCK")
    pairs = [
        (zones.get(number, name), blocks.get(number, "whole"))
        for number, name in zip(_region_numbers(lines), names, strict=True)
    ]
    order = list(dict.fromkeys(zone for zone, _ in pairs))
    return [
        {
            "name": name,
            "zone": zone,
            "zone_index": order.index(zone),
            # regions that share layer and block have their own names as blocks
            "block": block if pairs.count((zone, block)) == 1 else name,
        }
        for name, (zone, block) in zip(names, pairs, strict=True)
    ]


def _region_numbers(lines: list[str]) -> list[int]:
    """Number of each region but ``Universe``."""
    words = (line.split(maxsplit=2) for line in lines if line.startswith("REGION "))
    return [int(w[1]) for w in words if len(w) == 3 and w[2].strip() != "Universe"]


def _groups(lines: list[str], key: str) -> dict[int, str]:
    """Name of the LAYER or FAULT_BLOCK that lists each number."""
    found: dict[int, str] = {}
    title = None
    for line in lines:
        words = line.split()
        if words == ["END"]:
            break
        if words[:1] == [key]:
            title = " ".join(words[1:])
        elif title is not None and all(word.isdecimal() for word in words):
            found.update((int(word), title) for word in words if word != "0")
            title = None if "0" in words else title
        else:
            title = None
    return found
