"""The curves of a scene, pair by pair, and what a tolerance does to them and to volumes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from geosurf.arrangement import find_contacts, search_voxels
from geosurf.conventions import counted, is_number
from geosurf.errors import InputError
from geosurf.intersect import curves_of, intersect_surfaces, merge_curves
from geosurf.intersect.shared import is_torn, shared_curves
from geosurf.model import Curves, Sheet, TriSurface, VoxelSearch
from geosurf.model.base import in_crs_of
from geosurf.model.expected import name_of
from geosurf.scene.inputs import boxes_meet
from geosurf.scene.measures import Measured
from geosurf.triangulate.coarsen import coarsen_lattice, volume_error


def check_scene_tolerance(tolerance: Any, horizons: Mapping[str, Any]) -> float | None:
    """Return the tolerance of a scene [m] or None, or say why it cannot be."""
    if tolerance is None:
        return None
    if not (is_number(tolerance) and tolerance > 0):
        raise InputError(
            f"tolerance is {tolerance!r}; give a length above 0 m, or None for all nodes."
        )
    for name, value in horizons.items():
        if isinstance(value, Sheet) or "ghost" in getattr(value, "vertex_data", ()):
            raise InputError(
                f"horizon {name!r} is a sheet torn at faults, and a tolerance would move its "
                "cut-offs. Leave tolerance out, or give the horizon as a grid that is not torn."
            )
    return float(tolerance)


class Joined(Measured):
    """What `geosurf.Scene` can be asked about curves, and about its tolerance."""

    _tolerance: float | None
    _self: bool
    _voxel_size: float | None
    _frame: Callable[[Sequence[TriSurface]], np.ndarray]
    _plain: Callable[[str], TriSurface]
    surface: Callable[[str], TriSurface]
    surfaces: tuple[TriSurface, ...]
    box: tuple[float, float, float, float, float, float]

    @property
    def tolerance(self) -> float | None:
        """How far grids may be simplified, and the error of curves [m]; None: not at all."""
        return self._tolerance

    @cached_property
    def curves(self) -> Curves:
        """Curves of all pairs of surfaces; with a tolerance, see `curves_between`.

        With `self_intersections` of each surface with itself, too: not with a tolerance, and not of
        torn sheets.
        """
        names = [*self._horizons, *self._faults]
        alone = self._self and self._tolerance is None
        parts = []
        for i, first in enumerate(names):
            own = alone and not is_torn(self._plain(first))
            for j in range(i if own else i + 1, len(names)):
                part = self.curves_between(first, names[j])
                if part is not None:
                    parts.append(((i, j), part))
        if self._tolerance is not None:
            from geosurf.intersect.dial import merge_smooth

            smooth = merge_smooth(tuple(names), self._frame(self.surfaces), parts)
            return in_crs_of(smooth, self.surfaces)
        plain = merge_curves(tuple(names), self._frame(self.surfaces), parts)
        return in_crs_of(plain, self.surfaces)

    def curves_between(self, first: str, second: str) -> Curves | None:
        """Return the curves of two surfaces; None where their boxes do not meet.

        Parameters
        ----------
        first, second : str
            Names of two surfaces; of one twice: the curves along which it crosses itself.

        Returns
        -------
        Curves or None
            With a tolerance, those of the smooth surfaces through all nodes (`intersect_surfaces`):
            `Curves.error_bound` and `Curves.places` say how far that went. Patches and units
            meet in the curves of the simplified surfaces.
        """
        first, second = name_of(first, "surface"), name_of(second, "surface")
        pair = tuple(self._plain(name) for name in dict.fromkeys((first, second)))
        subject = f"{first} x {second}"
        if any(map(is_torn, pair)):  # it ends on its faults
            return shared_curves(self.patches, first, second)
        if not boxes_meet(pair[0].bounds, pair[-1].bounds):
            self._memory.note("curves", subject, "skipped", "boxes do not meet")
            return None

        origin = self._frame(pair)

        def run() -> Curves:
            """Compute it; called unless it is remembered."""
            if self._tolerance is not None:
                return intersect_surfaces(
                    pair,
                    tolerance=self._tolerance,
                    voxel_size=self._voxel_size,
                    self_intersections=len(pair) == 1,
                )
            options = {"origin": origin, "voxel_size": self._voxel_size}
            return curves_of(find_contacts(pair, pairs=[(0, len(pair) - 1)], **options))

        keys = (self._memory.key_of(s) for s in pair)
        key = ("curves", *keys, origin.tobytes(), self._voxel_size, self._tolerance)
        return self._memory.get_or_compute(
            "curves", subject, key, run, lambda c: counted(c.n_curve, "curve")
        )

    def search(self, first: str, second: str) -> VoxelSearch | None:
        """Return what the voxel search found for two surfaces, for `render_search`."""
        return search_voxels(self.surface(first), self.surface(second), self._voxel_size)

    @property
    def volume_error_bound(self) -> float:
        """By how much the volume of units, one or several, may differ from that of all nodes [m3].

        The volume inside the box between each horizon as it is given and as it is simplified, all
        horizons together; 0 without a tolerance. It holds where both models have the same units.

        Examples
        --------
        >>> import geosurf as gs
        >>> world = gs.synthetic.waves(n=41)
        >>> scene = gs.Scene(world.horizons, world.faults, world.box, tolerance=5.0)
        >>> exact = scene.replace(tolerance=None)
        >>> off = abs(scene.volumes - exact.volumes).max().item()
        >>> 0.0 < off <= scene.volume_error_bound, exact.volume_error_bound
        (True, 0.0)
        """
        sides = self.box[:4]
        return sum((volume_error(self.surface(name), sides) for name in self._horizons), 0.0)

    def _simplified(self, name: str, plain: TriSurface) -> TriSurface:
        """A horizon with as few triangles as the tolerance allows; one without a grid as it is."""
        if self._tolerance is None or plain.lattice is None:
            return plain
        tolerance, lattice = self._tolerance, plain.lattice
        key = ("simplified", self._memory.key_of(plain), name, tolerance)
        return self._memory.get_or_compute(
            "simplify",
            name,
            key,
            lambda: coarsen_lattice(name, lattice, tolerance),
            lambda s: f"{s.n_triangle} of {plain.n_triangle} triangles, within {tolerance:g} m",
            again=False,
        )
