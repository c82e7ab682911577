"""What is true of an exported field: elevations, cut-offs, throw, volumes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.conventions import did_you_mean
from geosurf.errors import InputError
from geosurf.synthetic.export.areas import inside, quadrature
from geosurf.synthetic.export.cutoffs import cutoff_line, throw_line
from geosurf.synthetic.export.geology import (
    OUTLINE,
    Geology,
    Horizon,
    fault_elevation,
    to_local,
    to_world,
)
from geosurf.synthetic.torn_faults import exists


@dataclass(frozen=True, eq=False)
class FieldTruth:
    """What is true of a field that `field_export` wrote; metres, elevation positive up.

    Attributes
    ----------
    variant : str
    files : mapping of str to pathlib.Path
        By the name of the horizon or fault; ``"outline"`` and ``"scenario"``, too.
    horizons, faults : tuple of str
        Horizons youngest first.
    missing : mapping of str to mapping of str to float
        By how much faults were picked too short [m]: ``{"F1": {"down": 30.0}, ...}``. ``"up"``
        and ``"down"``: between the end of the sticks and the farthest horizon; ``"start"`` and
        ``"end"``, along strike by the right-hand rule: between sticks and the main fault.
    outline : ndarray (n, 2)
        Easting and northing of a polygon inside of which all horizons have data.
    """

    variant: str
    files: Mapping[str, Path]
    geology: Geology = field(repr=False)
    missing: Mapping[str, Mapping[str, float]]

    @property
    def horizons(self) -> tuple[str, ...]:
        """Names of the horizons, youngest first."""
        return tuple(horizon.name for horizon in self.geology.horizons)

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the faults, main faults first."""
        return tuple(self.geology.faults)

    @property
    def outline(self) -> np.ndarray:
        """A polygon (n, 2) inside of which all horizons have data."""
        return np.stack(to_world(*OUTLINE.T), axis=1)

    def elevation(self, horizon: str, easting: Any, northing: Any) -> np.ndarray:
        """
        Elevation of a horizon at places in the map.

        Parameters
        ----------
        horizon : str
        easting, northing : array_like
            [m]

        Returns
        -------
        ndarray of float64
            [m], positive up; NaN in the gap between the two cut-offs of a fault.

        Raises
        ------
        InputError
            If the horizon is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> float(truth.elevation("Top", 463000.0, 5933000.0).round(1))
        -1743.9
        """
        # formulas are in the frame of the grids
        x, y = np.broadcast_arrays(*to_local(easting, northing))
        found = np.full(x.shape, np.nan)

        # where sheets overlap (a reverse fault) the highest counts; no sheet, as in a gap, leaves
        # NaN
        for signs, z in self.geology.sheets(self._horizon(horizon), x, y).items():
            there = exists(self.geology.faults, signs, x, y, z)
            found = np.where(there, np.fmax(found, z), found)
        return found

    def cutoff(self, horizon: str, fault: str, wall: str) -> np.ndarray:
        """
        Cut-off line of a horizon on one wall of a fault, inside the outline.

        Parameters
        ----------
        horizon, fault : str
        wall : {"+", "-"}
            Hanging wall or footwall.

        Returns
        -------
        ndarray (n, 3) of float64
            Easting, northing, elevation [m], every 5 m along strike.

        Raises
        ------
        InputError
            If a name is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> truth.cutoff("Top", "F1", "+").shape[1]
        3
        """
        if wall not in ("+", "-"):
            raise InputError(f'wall is {wall!r}; give "+" (hanging wall) or "-" (footwall).')

        # the line runs past the grids; what is outside the outline is cut off here
        _, x, y, z = cutoff_line(self.geology, self._horizon(horizon), self._fault(fault), wall)
        here = inside(OUTLINE, x, y)
        return np.stack([*to_world(x[here], y[here]), z[here]], axis=1)

    def throw(self, horizon: str, fault: str, easting: Any, northing: Any) -> np.ndarray:
        """
        Throw of a fault at places along it: footwall minus hanging wall, across its mean strike.

        Parameters
        ----------
        horizon, fault : str
        easting, northing : array_like
            Places on the fault or next to it [m], such as the ``stations`` of a `FaultCut`.

        Returns
        -------
        ndarray of float64
            [m]; 0 beyond the tips of a fault. NaN beyond its main fault, and where another fault
            lies between its walls.

        Raises
        ------
        InputError
            If a name is unknown.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> east, north, _ = truth.cutoff("Top", "F1", "-").T
        >>> round(float(np.nanmax(truth.throw("Top", "F1", east, north))))
        86
        """
        name = self._fault(fault)

        # read by the distance along the fault, so that places next to it do
        s = self.geology.faults[name].along_across(*to_local(easting, northing))[0]
        found = np.interp(
            s, *throw_line(self.geology, self._horizon(horizon), name), left=np.nan, right=np.nan
        )
        return np.where(np.abs(s) >= self.geology.faults[name].half, 0.0, found)

    def volumes(self, area: Any = None, *, step: float = 10.0) -> dict[tuple[str, str], float]:
        """
        Volumes of the zones between horizons, block by block, within an area.

        Each column is divided exactly; columns are added up by a rule of second order.

        Parameters
        ----------
        area : array_like (n, 2), optional
            Polygon of easting and northing [m]. Default: the outline.
        step : float
            Between columns [m].

        Returns
        -------
        dict
            ``{(zone, block): m3}``, for ``scene.units[zone, block].volume``.

        Raises
        ------
        InputError
            If the area is not a polygon.

        Examples
        --------
        >>> import tempfile
        >>> from geosurf.synthetic import field_export
        >>> truth = field_export(tempfile.mkdtemp())
        >>> round(truth.volumes()["Top/Middle", "F1+ F2-"] / 1e6)
        117
        """
        polygon = OUTLINE if area is None else _polygon(area)
        x, y, weight = quadrature(polygon, _positive(step))

        # for each horizon its sheets by sector, each defined everywhere in the map
        sheets = [self.geology.sheets(h, x, y) for h in self.geology.horizons]
        planes = {n: fault_elevation(f, x, y) for n, f in self.geology.faults.items()}
        zones = [f"{upper}/{lower}" for upper, lower in pairwise(self.horizons)]
        found = {(zone, block.name): 0.0 for zone in zones for block in self.geology.blocks}
        for signs in self.geology.sectors:
            by_name = dict(zip(self.faults, signs, strict=True))

            # the block of the sector in each column: hanging walls lie above their fault, footwalls
            # below
            floor = np.full(x.shape, -np.inf)
            roof = np.full(x.shape, np.inf)
            for name, sign in by_name.items():
                if sign > 0:
                    floor = np.maximum(floor, planes[name])
                elif sign < 0:
                    roof = np.minimum(roof, planes[name])
            block = next(b for b in self.geology.blocks if b.holds(by_name))
            for zone, (upper, lower) in zip(zones, pairwise(sheets), strict=True):
                # each column of each zone, cut by the faults: exact in z, so that only the sum over
                # columns has an error
                top, base = np.minimum(upper[signs], roof), np.maximum(lower[signs], floor)
                found[zone, block.name] += float((weight * np.maximum(top - base, 0.0)).sum())
        return found

    def _horizon(self, name: str) -> Horizon:
        if name not in self.horizons:
            raise InputError(
                f"no horizon of the field is called {name!r}; it has {', '.join(self.horizons)}."
                f"{did_you_mean(str(name), self.horizons)}"
            )
        return self.geology.horizon(name)

    def _fault(self, name: str) -> str:
        if name not in self.faults:
            raise InputError(
                f"no fault of the field is called {name!r}; it has {', '.join(self.faults)}."
                f"{did_you_mean(str(name), self.faults)}"
            )
        return name


def _polygon(area: Any) -> np.ndarray:
    """A polygon in the local frame."""
    try:
        corners = np.asarray(area, dtype=np.float64)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] not in (2, 3):
        raise InputError("area takes a polygon of three corners or more: (easting, northing) each.")
    if not np.isfinite(corners).all():
        raise InputError("area has a corner that is not finite; give (easting, northing) each.")
    return np.stack(to_local(corners[:, 0], corners[:, 1]), axis=1)


def _positive(step: float) -> float:
    if not (np.isfinite(step) and step >= 0.1):
        raise InputError(f"step is {step!r}; give metres, 0.1 or more.")
    return float(step)
