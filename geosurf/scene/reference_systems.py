"""Reference systems of what a scene is made of: well tops and area next to surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geosurf.conventions.crs import crs_of, refuse_other_crs
from geosurf.model.tops import Tops

FEATURES = ("geojson", "shapefile")


def refuse_other_systems(
    known: Mapping[str, str], crs: str | None, tops: Tops | None, aoi: Any
) -> dict[str, str]:
    """Refuse well tops or an area in another reference system than the surfaces.

    Parameters
    ----------
    known : mapping of str to str
        Reference systems of the surfaces, by name.
    crs : str or None
        That of the scene.
    tops : Tops or None
    aoi : array_like, path or None
        Area of interest.

    Returns
    -------
    dict of str to str
        All systems, by the name of what declares them.

    Raises
    ------
    InputError
        If one of them is provably another one.
    """
    found = dict(known)
    if crs is not None:
        found.setdefault("crs", crs)
    more = {"tops": None if tops is None else tops.crs, "aoi": crs_of_outline(aoi)}
    for name, other in more.items():
        if other is not None:
            refuse_other_crs(name, other, found)
            found[name] = other
    return found


def crs_of_outline(aoi: Any) -> str | None:
    """Return the reference system that an area of interest declares; files of features have one."""
    if isinstance(aoi, str | Path):
        return _of_file(Path(aoi))
    return crs_of(aoi)


def _of_file(path: Path) -> str | None:
    """The system of a file of features; other outlines have none."""
    if not path.is_file():
        return None
    from geosurf.read._detect import detect
    from geosurf.read.features import geojson, shapefile

    key = detect(path)
    if key not in FEATURES:
        return None
    found: str | None = (geojson if key == "geojson" else shapefile).features(path).crs
    return found


__all__ = ["crs_of_outline", "refuse_other_systems"]
