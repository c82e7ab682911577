"""Stations of a survey: measured depths and directions that make one path."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geosurf.errors import FormatError

Three = tuple[np.ndarray, np.ndarray, np.ndarray]


def checked_stations(
    path: Path,
    name: str,
    lines: list[int],
    md: np.ndarray,
    inclination: np.ndarray,
    azimuth: np.ndarray,
) -> Three:
    """
    Return the stations of a well from measured depth 0 on, without repeated ones.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Of the well.
    lines : list of int
        Line of each station, from 1.
    md, inclination, azimuth : ndarray of float64, shape (n,)
        Measured depths [m], which do not fall, and angles [degrees].

    Raises
    ------
    FormatError
        For angles that are not degrees, two directions at one depth, opposite neighbours, and a
        first station that leaves the way from the well head open.
    """
    wrong = (inclination < 0.0) | (inclination > 180.0) | (np.abs(azimuth) > 360.0)
    if wrong.any():
        k = int(wrong.argmax())
        raise FormatError(
            f"{path}, line {lines[k]}: well {name!r} has the inclination {inclination[k]:g} and "
            f"the azimuth {azimuth[k]:g}. Inclinations are 0 to 180 degrees from the vertical, "
            "azimuths -360 to 360 degrees from grid north."
        )
    repeats = np.append(False, np.diff(md) == 0.0)
    turned = repeats & np.append(False, (np.diff(inclination) != 0.0) | (np.diff(azimuth) != 0.0))
    if turned.any():
        k = int(turned.argmax())
        raise FormatError(
            f"{path}, line {lines[k]}: well {name!r} has two directions at the measured depth "
            f"{md[k]:g} m. Delete one of the stations."
        )
    stations = np.column_stack([md, inclination, azimuth])[~repeats]
    lines = [line for line, repeat in zip(lines, repeats, strict=True) if not repeat]
    if stations[0, 0] != 0.0:
        if stations[0, 0] < 0.0 or stations[0, 1] != 0.0:
            raise FormatError(
                f"{path}, line {lines[0]}: the first station of well {name!r} is at the measured "
                f"depth {stations[0, 0]:g} m with the inclination {stations[0, 1]:g}, so the way "
                "there is unknown. Add a station at measured depth 0."
            )
        stations = np.concatenate([np.zeros((1, 3)), stations])  # straight down to the first one
        lines = [lines[0], *lines]
    back = _turns_back(*np.radians(stations[:, 1:]).T)
    if len(back):
        raise FormatError(
            f"{path}, line {lines[int(back[0]) + 1]}: well {name!r} turns by 180 degrees from one "
            "station to the next, so its arc is unknown. Correct the angles."
        )
    return stations[:, 0], stations[:, 1], stations[:, 2]


def _turns_back(inclination: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Rows after which the direction is opposite."""
    flat = np.sin(inclination)
    ways = np.column_stack([flat * np.sin(azimuth), flat * np.cos(azimuth), np.cos(inclination)])
    rows: np.ndarray = np.flatnonzero((ways[:-1] * ways[1:]).sum(axis=1) < -1.0 + 1e-12)
    return rows


__all__ = ["checked_stations"]
