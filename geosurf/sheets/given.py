"""A continuous horizon and the throw of its faults -> a sheet that is torn there.

No datum is distrusted and nothing is solved for: each wall is the horizon itself, moved along its
faults (`slip`, `moved`), so that ghosts are known as well as nodes. Traces, tearing and the exact
cut are those of sheets as picked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geosurf.conventions import place, rising_diagonal
from geosurf.errors import GeometryError, HorizonError
from geosurf.model import FaultCut, Sheet, ThrowReport, TriSurface
from geosurf.sheets.build import Builder, Built
from geosurf.sheets.cutoffs import LONGEST, profile
from geosurf.sheets.data import Picks, picks_of
from geosurf.sheets.describe import count_tips, fault_cuts
from geosurf.sheets.finish import fault_surfaces, refuse_leaks, sheet_of
from geosurf.sheets.frame import Frame
from geosurf.sheets.ghosts import ghost_heights
from geosurf.sheets.heights import MAP_REACH, Heights, walls_of
from geosurf.sheets.links import cuts_of, within
from geosurf.sheets.mesh import Torn, Triangles
from geosurf.sheets.moved import Before, sheet_heights
from geosurf.sheets.near import NearTrace
from geosurf.sheets.network import Network
from geosurf.sheets.section import section_of
from geosurf.sheets.slip import Slip, slips_of
from geosurf.sheets.traces import mesh_in_frame

DIES = 0.01  # of the largest throw: what may be left at a tip
SPARES = (1.0, 0.5, 1.5, 0.0)  # cells beyond an overlap that rings are tried to cover
FAR = 1e-6  # cells outside of the data from which a particle is told of


def throw_horizon(
    horizon: Any,
    faults: Mapping[str, Any] | Sequence[TriSurface],
    throw: Mapping[str, Any],
    *,
    name: str | None = None,
    reach: float | Mapping[str, float] | None = None,
    hanging_wall: float = 1.0,
    positive: str | None = None,
    units: str | None = None,
) -> Sheet:
    """
    Tear a horizon that is still continuous, by the throw of its faults.

    The hanging wall moves along each fault, also a curved or listric one, so that both cut-offs lie
    on it, one throw apart in each section across its mean strike.

    Parameters
    ----------
    horizon : xarray.DataArray or gridded TriSurface
        The horizon before it was faulted, as for `triangulate_horizon`.
    faults : mapping of str to fault, or sequence of TriSurface
        Anything that `triangulate_fault` takes, where they are today.
    throw : mapping of str to throw
        By fault, the youngest first; faults that are not named do not tear. Below 0 for reverse
        faults. Each is a number [m]; an array (n, 2) of distance along strike and throw, or a
        DataArray with coordinate ``along_strike``, linear between and constant beyond; a function
        of the distance; a DataArray over northing and easting; or an `EllipticThrow`.
        Distances count from the fault's first end by the right-hand rule, along its mean strike.
    name : str, optional
        Default: the name of the data.
    reach : float or mapping of str to float, optional
        Distance across strike over which the movement dies away from the fault [m], as its
        square: reverse drag. Default: never.
    hanging_wall : float
        Part of the throw that the hanging wall takes, 0 to 1; the footwall rises by the rest.
    positive, units : str, optional
        As for `triangulate_horizon`.

    Returns
    -------
    Sheet
        With cut-offs, throw and heave for each fault, and a `ThrowReport`.

    Raises
    ------
    HorizonError, InputError
        If the data or a throw cannot be used.
    GeometryError
        If a fault turns back on itself, throw is left at a tip inside the horizon, beds would
        fold over, or the sheet cannot be closed: names the place.

    See Also
    --------
    tear_horizon : for a horizon that was picked on both sides of its faults.

    Notes
    -----
    A fault that ends on another one acts on that side of it only, so that throws add up on the
    main fault beyond the contact. Where faults cross, each is taken where it is today on
    both sides of the other: exact for planes. See docs/sheets.md.

    Examples
    --------
    >>> import numpy as np, geosurf as gs
    >>> world = gs.synthetic.graben(n=41)
    >>> sheet = gs.throw_horizon(world.horizons["Top"], world.faults, {"F1": 60.0, "F2": 40.0})
    >>> [bool(np.allclose(sheet.cuts[f].throw, t)) for f, t in (("F1", 60.0), ("F2", 40.0))]
    [True, True]
    """
    surfaces = fault_surfaces(faults)
    picks = picks_of(horizon, name, positive, units)
    if len(picks.node) > len(np.unique(picks.node)):
        raise HorizonError(
            f"horizon {picks.name!r} has several values at one node, so that it is torn already. "
            "Give it as it was before faulting, or use tear_horizon."
        )
    frame = picks.frame
    sections = {
        s.name: section_of(s, frame.corner, 0.5 * frame.cell) for s in surfaces if s.name in throw
    }
    slips = slips_of(throw, sections, frame.corner, reach, hanging_wall)
    torn_by = {surface.name: surface for surface in surfaces}
    return _Thrown(picks, [torn_by[slip.section.name] for slip in slips], slips).sheet()


class _Thrown:
    """One horizon, its faults from the youngest to the oldest, and how they move it."""

    def __init__(self, picks: Picks, faults: list[TriSurface], slips: list[Slip]) -> None:
        self.picks, self.faults, self.slips = picks, faults, slips
        self.frame: Frame = picks.frame
        values = np.full(picks.n_node, np.nan)
        values[picks.node] = picks.z
        self.rising = rising_diagonal(self.frame.easting, self.frame.northing)
        grid = values.reshape(self.frame.shape)
        self.before = Before(picks.name, grid, self.frame, self.rising)
        self.xy = self.frame.uv_of_node(np.arange(picks.n_node)) @ self.frame.step
        low, high = float(picks.z.min()), float(picks.z.max())
        sizes = [slip.extremes(low, high) for slip in slips]
        self.largest = [throw for throw, _ in sizes]
        self.blend = [max(2.0 * heave, self.frame.cell) for _, heave in sizes]
        # main faults on which each one ends: fault, and the wall of it that is its own
        self.mains: list[dict[int, float]] = [{} for _ in slips]

    def sheet(self) -> Sheet:
        """Trace, move, tear and cut."""
        network = self._network()
        self._die_at_tips(network)
        near = [NearTrace(self.frame, trace, MAP_REACH) for trace in network.traces]
        self.labels = self._labels(network, near)
        values, was = self._moved(np.arange(self.picks.n_node), self.labels)
        cuts = cuts_of(network.traces, self.frame)
        cuts = cuts.take(np.flatnonzero(within(cuts, *network.solve.T)))
        none = np.empty(0, dtype=np.int64)
        everywhere = np.ones(len(self.picks.z), dtype=bool)
        state = Heights(
            values, network, cuts, near, [], none, everywhere, ~everywhere,
            np.empty((0, 3), dtype=np.int64), none, np.empty(0),
        )  # fmt: skip
        state.walls = walls_of(state, self.picks)
        built, triangles = self._closed(state)
        found = fault_cuts(self.frame, state, built, self.faults)
        cuts_by_fault = {
            slip.section.name: self._across_strike(found[slip.section.name], slip)
            for slip in self.slips
        }
        report = self._report(state, built, triangles, cuts_by_fault, was)
        return sheet_of(
            self.picks, state, built, self.faults, self.rising, cuts_by_fault, report
        )

    def _closed(self, state: Heights) -> tuple[Built, Triangles]:
        """The torn mesh, with as many rings where it overlaps as close it without an early end."""
        walls, best = state.walls, None
        overlaps = any((np.minimum(w.left, w.right) < 0).any() for w in walls)
        for spare in SPARES if overlaps else SPARES[:1]:
            state.walls = [
                replace(w, left=_wider(w.left, spare), right=_wider(w.right, spare)) for w in walls
            ]
            builder = Builder(self.picks, state, self.faults, self.rising, self._carry_on)
            built = builder.run()
            failed = bool(built.cut.leaks or built.cut.dead_ends), sum(built.shortened.values())
            if best is None or failed < best[0]:
                best = failed, built
            if failed == (False, 0):
                break
        state.walls = walls
        assert best is not None
        refuse_leaks(self.picks, best[1])
        return best[1], builder.triangles

    def _network(self) -> Network:
        """Traces on the horizon as it is moved, blended over each fault; twice, for branches."""
        meshes = [mesh_in_frame(fault, self.frame) for fault in self.faults]
        names = [fault.name for fault in self.faults]
        for _ in range(2):
            drape, _ = sheet_heights(
                self.before, self.slips, self.xy, self._blended, self.frame.cell
            )
            self.drape = drape
            network = Network(meshes, drape.reshape(self.frame.shape), self.frame.stretch)
            found: list[dict[int, float]] = [{} for _ in self.slips]
            for trace in network.traces:
                for end in trace.ends:
                    if end.startswith("branch of "):
                        main = names.index(end.removeprefix("branch of "))
                        found[trace.fault][main] = self._wall_of(main, trace)
            if found == self.mains:
                break
            self.mains = found
        return network

    def _wall_of(self, main: int, trace) -> float:
        """Wall of a main fault on which the middle of a branch's trace is: 1 hanging wall."""
        line = trace.line[int(0.5 * (trace.start + trace.stop))]
        xy = (line[None, :2] / self.frame.stretch) @ self.frame.step
        return float(self._beyond(main, xy, line[2:3])[0] > 0)

    def _beyond(self, fault: int, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Distance (n,) across strike from a fault at their elevation, into its hanging wall."""
        section = self.slips[fault].section
        s, r = section.of(xy)
        return r - section.across(s, z)

    def _blended(self, xy: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Walls (n_slip, n) that change gradually from 0 to 1 across each fault."""
        ramp = [
            np.clip(0.5 + self._beyond(k, xy, z) / (2.0 * width), 0.0, 1.0)
            for k, width in enumerate(self.blend)
        ]
        return self._with_mains(np.array(ramp).reshape(len(self.slips), len(xy)))

    def _with_mains(self, walls: np.ndarray) -> np.ndarray:
        """Branches do not act beyond their main faults: NaN there."""
        out = walls.copy()
        for k, mains in enumerate(self.mains):
            for main, wall in mains.items():
                out[k, (walls[main] > 0.5) != (wall > 0.5)] = np.nan
        return out

    def _labels(self, network: Network, near: list[NearTrace]) -> np.ndarray:
        """Wall (n_slip, n_node) of each node, 1 or 0: by the trace near it, else by the fault."""
        out = np.array(
            [self._beyond(k, self.xy, self.drape) > 0 for k in range(len(self.slips))], dtype=float
        ).reshape(len(self.slips), len(self.xy))
        for trace, close in zip(network.traces, near, strict=True):
            inner = (close.place > trace.start) & (close.place < trace.stop)
            out[trace.fault, close.node[inner]] = close.side[inner] > 0
        return out

    def _moved(self, node: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights over nodes of the sheets with labels (n_slip, n), and where particles were."""
        return sheet_heights(
            self.before, self.slips, self.xy[node], self._with_mains(labels), self.frame.cell
        )

    def _carry_on(self, torn: Torn, triangles: Triangles, bits: np.ndarray, state: Heights):
        """Ghosts are on the sheet of their anchor; the energy fills in where that has a hole."""
        heights, _ = self._moved(torn.node_of_ghost, self.labels[:, torn.anchor])
        fixed = {int(g): float(heights[g]) for g in np.flatnonzero(np.isfinite(heights))}
        return ghost_heights(
            torn, triangles, bits, state.values, self.frame.stretch, self.frame.cell, fixed
        )

    def _die_at_tips(self, network: Network) -> None:
        """Refuse throw that is left where a fault ends inside the horizon."""
        for trace in network.traces:
            slip, largest = self.slips[trace.fault], self.largest[trace.fault]
            for end, at in zip(trace.ends, (trace.start, trace.stop), strict=True):
                if end != "tip":
                    continue
                tip = trace.line[int(at)]
                xy = (tip[None, :2] / self.frame.stretch) @ self.frame.step
                s, _ = slip.section.of(xy)
                left = float(slip.amount(s.clip(0.0, slip.section.length), tip[2:3], xy)[0])
                if abs(left) > DIES * largest:
                    where = np.append(xy[0] + self.frame.corner, tip[2])
                    name = slip.section.name
                    raise GeometryError(
                        f"fault {name!r} ends inside horizon {self.picks.name!r} at {place(where)}, "
                        f"where its throw is still {left:.3g} m. Let throw die there, or extend the "
                        "fault past the horizon or to another fault.",
                        place=where, surfaces=(name, self.picks.name),
                    )  # fmt: skip

    def _across_strike(self, cut: FaultCut, slip: Slip) -> FaultCut:
        """Throw and heave in sections across the mean strike, as they were asked for."""
        direction = np.broadcast_to(slip.section.axes[1], (len(cut.stations), 2))
        reach = LONGEST * self.frame.cell
        walls = {wall: list(lines) for wall, lines in cut.cutoffs.items()}
        throw, heave = profile(cut.stations[:, :2], direction, walls, reach)
        return replace(cut, throw=throw, heave=heave)

    def _report(self, state, built: Built, triangles, cuts, was) -> ThrowReport:
        network = state.network
        shortened: dict[str, int] = {}
        for (trace, _), n in built.shortened.items():
            name = self.slips[network.traces[trace].fault].section.name
            shortened[name] = shortened.get(name, 0) + n
        outside = self.before.outside(was[np.isfinite(state.values)])
        found = {}
        for slip, largest in zip(self.slips, self.largest, strict=True):
            cut = cuts[slip.section.name]
            most = np.abs(cut.throw[np.isfinite(cut.throw)]).max(initial=0.0)
            found[slip.section.name] = {"asked": largest, "found": float(most)}
        return ThrowReport(
            throw=found,
            branches={
                slip.section.name: tuple(self.slips[m].section.name for m in sorted(mains))
                for slip, mains in zip(self.slips, self.mains, strict=True)
                if mains
            },
            tips=count_tips(built, triangles),
            declared_tips=network.declared_tips,
            shortened=shortened,
            n_outside=int((outside > FAR).sum()),
            farthest_outside=float(outside.max(initial=0.0)) * self.frame.cell,
            notes=[
                f"fault {name!r} does not meet the horizon"
                for name, cut in cuts.items()
                if not len(cut.along)
            ],
        )


def _wider(gap: np.ndarray, spare: float) -> np.ndarray:
    """Overlaps (gaps below 0) made larger, the small ones near tips by no more than they are."""
    return np.where(gap < 0, gap - spare * np.minimum(-gap, 1.0), gap)
