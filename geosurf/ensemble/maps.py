"""Maps of one realisation: the thickness of each layer on nodes that all realisations share."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from geosurf.carve.column import names_of_zones
from geosurf.errors import InputError
from geosurf.measure.thickness import nodes_of, thickness_map
from geosurf.scene import Scene


@dataclass(frozen=True, eq=False)
class Layers:
    """
    Zones, and their parts between fluid contacts, on the nodes of a map.

    Attributes
    ----------
    names : tuple of str
        ``"Top/Base"``, ``"Top/Base above OWC"`` ...
    zones, contacts : tuple of str
        Of each layer; the contact interval is empty for a whole zone.
    easting, northing : ndarray of float64
        Nodes of the map [m], one-dimensional.

    Examples
    --------
    >>> from geosurf.synthetic import tilted_planes
    >>> world = tilted_planes(n=9)
    >>> scene = Scene(world.horizons, world.faults, world.box, contacts={"OWC": -2000.0})
    >>> layers = Layers.of(scene, 500.0)
    >>> layers.names
    ('Top/Base', 'Top/Base above OWC', 'Top/Base below OWC')
    >>> layers.thickness(scene).shape
    (3, 6, 8)
    """

    names: tuple[str, ...]
    zones: tuple[str, ...]
    contacts: tuple[str, ...]
    easting: np.ndarray
    northing: np.ndarray

    @classmethod
    def of(cls, scene: Scene, grid: Any) -> Layers:
        """Return the layers of a scene; zones above the first and below the last horizon are not.

        Parameters
        ----------
        scene : Scene
        grid : float or xarray object
            As for `Scene.thickness`: the width of cells [m], or a grid with unrotated axes.
        """
        # True stands for the default width of cells.
        nodes = nodes_of(None if grid is True else grid, scene.box)
        if len(nodes.shape) != 2 or nodes.coords["easting"][1].ndim != 1:
            raise InputError(
                "maps= has rotated or curved axes. Give the width of a cell [m], or a grid with "
                "northing and easting of one dimension each."
            )
        found = []
        # The outermost zones have no second horizon, hence no thickness.
        for zone in names_of_zones(scene.horizon_names)[1:-1]:
            found.append((zone, zone, ""))
            # A contact may be given for some zones only.
            fluids = [one for one in scene.contacts if not one.zones or zone in one.zones]
            parts = _intervals(list(dict.fromkeys(one.name for one in fluids)))
            found += [(f"{zone} {part}", zone, part) for part in parts]
        names, zones, contacts = (tuple(row[k] for row in found) for k in range(3))
        return cls(names, zones, contacts, nodes.coords["easting"][1], nodes.coords["northing"][1])

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of layers, rows and columns."""
        return len(self.names), len(self.northing), len(self.easting)

    @property
    def identity(self) -> str:
        """A hash of layers and nodes."""
        # Names and nodes: an ensemble with other layers cannot be continued.
        digest = hashlib.sha256(repr(("juxtaposition", self.names)).encode())
        digest.update(self.easting.tobytes() + self.northing.tobytes())
        return digest.hexdigest()

    def thickness(self, scene: Scene) -> np.ndarray:
        """Return the vertical thickness of each layer (n_layer, n_row, n_col) [m], 0 if absent."""
        import xarray as xr

        # One grid for all realisations, so that maps can be summed.
        grid = xr.DataArray(
            np.empty(self.shape[1:]),
            coords={"northing": self.northing, "easting": self.easting},
            dims=("northing", "easting"),
        )
        made = np.zeros(self.shape, dtype=np.float32)
        # What is absent in this realisation has thickness 0 there, and is not computed.
        there = {(unit.zone, unit.contact) for unit in scene.units.values()}
        for k, (zone, part) in enumerate(zip(self.zones, self.contacts, strict=True)):
            if part and (zone, part) not in there:
                continue
            if not any(zone == other for other, _ in there):
                continue
            found = thickness_map(scene.units, zone, grid, contact=part or None)
            # Blocks are summed: a layer is one map.
            made[k] = np.nan_to_num(found.values).sum(axis=0)
        return made


def _intervals(names: list[str]) -> list[str]:
    """Intervals between fluid contacts from the top down, as units call them."""
    if not names:
        return []
    # The names that units have.
    between = [f"{a}/{b}" for a, b in pairwise(names)]
    return [f"above {names[0]}", *between, f"below {names[-1]}"]
