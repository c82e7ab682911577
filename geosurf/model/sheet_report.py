"""What is known about how a torn horizon was made."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from geosurf.conventions import place
from geosurf.errors import GeosurfWarning
from geosurf.model.base import Noun, frozen


@dataclass(frozen=True, eq=False)
class FaultCut(Noun):
    """Where one fault cuts a sheet.

    Attributes
    ----------
    fault : str
    cutoffs : dict of str to tuple of ndarray (n, 3)
        Lines of the hanging wall ``"+"`` (the side that the fault's normal points into) and of the
        footwall ``"-"``: easting, northing, elevation [m]. Their points lie on the fault.
    stations : ndarray (n, 3)
        Points of the mid trace, about one per cell [m].
    along : ndarray (n,)
        Distance along the trace [m].
    throw, heave : ndarray (n,)
        [m]: throw positive where the hanging wall is down, heave positive where there is a gap; NaN
        where a wall has no cut-off. Of `tear_horizon` both are read straight across, in the map,
        in the dip direction that the fault has at the station; of `throw_horizon` along its lines
        down the dip, as `Scene.throw` reads them. On a plane that is the same.
    ends : tuple of str
        How each trace ends: ``"tip"``, ``"rim"`` (leaves the data), ``"branch of F1"``.
    """

    fault: str
    cutoffs: dict[str, tuple[np.ndarray, ...]]
    stations: np.ndarray
    along: np.ndarray
    throw: np.ndarray
    heave: np.ndarray
    ends: tuple[str, ...]

    def __post_init__(self) -> None:
        # Frozen dataclass: arrays become read-only as they are taken over.
        for key in ("stations", "along", "throw", "heave"):
            object.__setattr__(self, key, frozen(getattr(self, key), np.float64))
        lines = {
            wall: tuple(frozen(line, np.float64) for line in of)
            for wall, of in self.cutoffs.items()
        }
        object.__setattr__(self, "cutoffs", lines)

    def __repr__(self) -> str:
        # Stations where a wall has no cut-off have no throw.
        known = self.throw[np.isfinite(self.throw)]
        throw = f"throw {known.min():.4g} to {known.max():.4g} m" if len(known) else "no throw"
        ends = f", ends: {', '.join(self.ends)}" if self.ends else ""
        return f"<FaultCut {self.fault!r}: {len(self.along)} stations, {throw}{ends}>"


# kinds of warnings about what closed a sheet where its faults alone did not
REMEDIES = (
    "fault extended",
    "tear ended early",
    "tear left out",
    "trim changed",
    "wall made level",
)


def _grouped(number: int) -> str:
    """A whole number with spaces between its thousands."""
    return f"{number:,}".replace(",", " ")


@dataclass(frozen=True, repr=False)
class SheetReport:
    """How a sheet was made, in numbers; lengths in metres, except where cells are named.

    Attributes
    ----------
    trim : float
        Data closer to a fault than this were ignored [cells of the grid]: the widest of `trims`.
    trims : dict of str to float
        The same by fault.
    cell : float
        One cell [m].
    n_data, n_ignored, n_solved : int
        Data in total, data that were ignored near faults, nodes that were interpolated.
    misfit : dict of str to float
        Misfit of the surface at the data in use: ``mean``, ``median``, ``p95``, ``max`` [m].
    holdout_misfit : dict of str to float
        The same at the ignored data, which test the surface: each against the wall that it is on.
    extrapolation : list of dict
        Places farthest from data of their own side: ``cells``, ``place`` (3,), ``fault``.
    sign_changes : dict of str to int
        By fault, changes of the sign of throw beyond 5 % of the largest: nearly always a
        trim that is too small.
    tips, declared_tips : int
        Tips of the mesh, and free ends of the faults: they should agree.
    shortened : dict of str to int
        Links by which tears end earlier than their faults, by fault.
    noise : float or None
        Standard deviation of the noise that data were taken to have [m].
    filled_blocks : list of dict
        Blocks without data that were filled from a neighbouring block: ``nodes``, ``over`` (the
        fault between the two), ``place`` (2,).
    notes : list of str
        Sentences for the user.
    warnings : tuple of GeosurfWarning
        What closed the sheet where its faults alone did not (kinds in `REMEDIES`), and throw that
        the data show where a fault ends, and the sheet does not have.
    """

    trim: float = 0.0
    trims: dict[str, float] = field(default_factory=dict)
    cell: float = 0.0
    n_data: int = 0
    n_ignored: int = 0
    n_solved: int = 0
    misfit: dict[str, float] = field(default_factory=dict)
    holdout_misfit: dict[str, float] = field(default_factory=dict)
    extrapolation: list[dict[str, Any]] = field(default_factory=list)
    sign_changes: dict[str, int] = field(default_factory=dict)
    tips: int = 0
    declared_tips: int = 0
    shortened: dict[str, int] = field(default_factory=dict)
    noise: float | None = None
    filled_blocks: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    warnings: tuple[GeosurfWarning, ...] = ()

    @property
    def remedies(self) -> tuple[GeosurfWarning, ...]:
        """Those of ``warnings`` that closed the sheet; none if its faults alone did."""
        return tuple(warning for warning in self.warnings if warning.kind in REMEDIES)

    def _trims(self) -> str:
        """The trim of all faults, or of each."""
        # Mostly one trim for all faults; each by name only where they differ.
        if len(set(self.trims.values())) < 2:
            return f"{self.trim:g}"
        return ", ".join(f"{trim:g} ({name})" for name, trim in self.trims.items())

    def __repr__(self) -> str:
        def figures(values: dict[str, float]) -> str:
            """Figures of a misfit in one line."""
            return ", ".join(f"{key} {value:.3g}" for key, value in values.items()) or "none"

        # Throw that changes its sign along a fault is nearly always an artefact of the trim.
        changes = sum(self.sign_changes.values())
        lines = [
            f"trim {self._trims()} cells of {self.cell:.6g} m",
            f"{_grouped(self.n_ignored)} of {_grouped(self.n_data)} data ignored near faults",
            f"{_grouped(self.n_solved)} nodes interpolated",
            f"misfit at the data in use [m]: {figures(self.misfit)}",
            f"misfit at the ignored data [m]: {figures(self.holdout_misfit)}",
            f"tips: {self.tips} in the mesh, {self.declared_tips} in the faults",
            f"changes of the sign of throw: {changes}",
        ]
        # The worst places only; the report of the scene lists all.
        lines += [
            f"extrapolated over {e['cells']:g} cells next to fault {e['fault']!r} at "
            f"({e['place'][0]:.0f}, {e['place'][1]:.0f}, {e['place'][2]:.0f})"
            for e in self.extrapolation[:3]
        ]
        lines += [
            f"{_grouped(c['nodes'])} nodes without data filled across fault {c['over']!r} at "
            f"({c['place'][0]:.0f}, {c['place'][1]:.0f})"
            for c in self.filled_blocks[:3]
        ]
        return "\n".join([*lines, *self.notes])


@dataclass(frozen=True, repr=False)
class TrimProposal:
    """How far data are smeared across their faults, and the trim that follows.

    Attributes
    ----------
    trim : float
        The proposal for ``tear_horizon(trim=)`` [cells of the grid].
    smear : float or None
        Half width of the smear [cells]. 0 if there is none; None if it cannot be determined,
        because the surface misses data far from the faults as well.
    misfit : tuple of float
        90th percentile of the misfit of ignored data, by distance from the nearest fault: below one
        cell, one to two, and so on [m].
    of_fault : dict of str to float
        The proposal for each fault alone [cells]; `trim` where too few data are near it.
    """

    trim: float
    smear: float | None
    misfit: tuple[float, ...]
    of_fault: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        # Bins of one cell each, from the fault outwards.
        bins = ", ".join(f"{value:.3g}" for value in self.misfit)
        # The reason is part of the proposal: without a smear a small trim is enough.
        why = "the width of the smear cannot be determined"
        if self.smear is not None:
            why = f"data are smeared over {self.smear:g} cells"
        return (
            f"proposed trim: {self.trim:g} cells ({why})\n"
            f"misfit of ignored data by distance from a fault in cells [m]: {bins}"
            + "".join(f"\n{name}: {trim:g} cells" for name, trim in self.of_fault.items())
        )


@dataclass(frozen=True)
class LostThrow:
    """Throw that cells are too coarse for, next to the tip of a fault.

    Attributes
    ----------
    fault : str
    place : (easting, northing, elevation)
        Where most is lost [m].
    requested, measured : float
        Throw there, as given and as read between the cut-offs [m].
    cell : float
        Cell of the horizon [m].
    suggested_cell : float
        Cell on which 2 % of the largest throw would be lost [m].
    """

    fault: str
    place: tuple[float, float, float]
    requested: float
    measured: float
    cell: float
    suggested_cell: float

    def __str__(self) -> str:
        return (
            f"Fault {self.fault!r} has {self.measured:.3g} m of the requested {self.requested:.3g} "
            f"m of throw next to its tip at {place(self.place)}: cells of {self.cell:.3g} m are "
            f"too coarse there. On cells of {self.suggested_cell:.2g} m or less, at most 2 % of "
            "the largest throw is lost."
        )


@dataclass(frozen=True, repr=False)
class ThrowReport:
    """How a sheet was made from a continuous horizon and throw.

    Attributes
    ----------
    throw : dict of str to dict
        By fault, the largest throw that was ``requested`` at the elevations of the horizon, and the
        largest that was ``measured`` between the cut-offs [m]. Throws of branches add to it.
    branches : dict of str to tuple of str
        Faults that end on others, which act on one side of those only.
    tips, declared_tips : int
        As in `SheetReport`.
    shortened : dict of str to int
        Links by which tears end earlier than their faults, by fault; throw is lost there.
    lost : tuple of LostThrow
        Tips next to which more than 2 % of the largest throw of a fault are missing.
    n_outside : int
        Nodes whose rock was outside of the data before it moved: the horizon is extrapolated there.
    farthest_outside : float
        How far, at most [m].
    attempts : int
        Meshes that were cut with the faults until one was closed; 0 where no fault tears.
    notes : list of str
        Sentences for the user.
    warnings : tuple of GeosurfWarning
    """

    throw: dict[str, dict[str, float]] = field(default_factory=dict)
    branches: dict[str, tuple[str, ...]] = field(default_factory=dict)
    tips: int = 0
    declared_tips: int = 0
    shortened: dict[str, int] = field(default_factory=dict)
    lost: tuple[LostThrow, ...] = ()
    n_outside: int = 0
    farthest_outside: float = 0.0
    attempts: int = 0
    notes: list[str] = field(default_factory=list)
    warnings: tuple[GeosurfWarning, ...] = ()

    def __repr__(self) -> str:
        lines = [
            f"throw of {name!r}: up to {of['requested']:.6g} m requested, "
            f"{of['measured']:.6g} m measured"
            for name, of in self.throw.items()
        ]
        lines += [
            f"{name!r} ends on {', '.join(map(repr, mains))}"
            for name, mains in self.branches.items()
        ]
        lines.append(f"tips: {self.tips} in the mesh, {self.declared_tips} in the faults")
        if self.n_outside:
            lines.append(
                f"{_grouped(self.n_outside)} nodes came from up to {self.farthest_outside:.3g} m "
                "outside of the data"
            )
        lines += [
            f"the tear of {name!r} ends {n} lattice links before the fault does"
            for name, n in self.shortened.items()
        ]
        return "\n".join([*lines, *self.notes])
