"""Reference systems of what a scene is made of: well tops and area next to surfaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from geosurf.conventions.crs import crs_of, refuse_other_crs, warn_of_unclear_crs
from geosurf.conventions.foreign import crs_of_foreign
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


def check_system_of_places(scene: Callable[[], str | None], places: Any, name: str) -> None:
    """Refuse places in another reference system than the scene; warn of one that may be another.

    Parameters
    ----------
    scene : callable
        Returns that of the scene, or None.
    places : table, xarray object or object of another package
        As for `Scene.sample`.
    name : str
        What they are, for messages.

    Raises
    ------
    InputError
        If one of them is provably another one.
    """
    own = _declared(places)
    known = None if own is None else scene()
    if own is not None and known is not None:
        refuse_other_crs(name, own, {"scene": known})
        warn_of_unclear_crs({"scene": known, name: own})


def crs_of_outline(aoi: Any) -> str | None:
    """Return the reference system that an area of interest declares; files of features have one."""
    if isinstance(aoi, str | Path):
        return _of_file(Path(aoi))
    return _declared(aoi)


def _declared(value: Any) -> str | None:
    """The system of an object; a geometry of shapely has none."""
    return crs_of_foreign(value) if hasattr(value, "geom_type") else crs_of(value)


def _of_file(path: Path) -> str | None:
    """The system of a file of features or of GOCAD lines; other outlines have none."""
    if not path.is_file():
        return None
    from geosurf.read._detect import detect
    from geosurf.read.features import features
    from geosurf.read.gocad import crs_of_gocad_lines

    key = detect(path)
    if key == "pline":
        return crs_of_gocad_lines(path)
    if key not in FEATURES:
        return None
    return features(path).crs
