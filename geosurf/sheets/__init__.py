"""Horizon data and faults -> horizon sheets that are torn at the faults.

Two ways lead to a `Sheet`. `tear_horizon` rebuilds a horizon that gridding smeared across its
faults; `throw_horizon` moves a horizon that is still continuous by the throw of its faults.

==============  ===================================================================
tear            `tear_horizon`: the steps of the first way, in order
throw/          `throw_horizon`: the second way
extend          `extend_horizon`: grids continued beyond their rim, holes filled
tie/            horizons that meet well tops: data corrected, then torn again
report/         what the user learns about a sheet: cut-offs, misfit, trim
mesh/           heights and cut links -> a torn mesh that the faults close exactly
heights/        heights of all nodes, each wall from data of its own side only
faults/         faults on the lattice of a horizon: traces, cut links, tips, slip
lattice/        the lattice of a horizon, its data, and the smoothest surface on it
==============  ===================================================================

A room uses rooms below it in this table only. The surface minimises its third differences
(Briggs 1974), is torn by virtual nodes (Molino, Bao & Fedkiw 2004), and is cut exactly.

`geosurf.rebuild` cuts, `geosurf.triangulate` reads grids and faults: `sheets` lies above both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geosurf.lazy import lazily

if TYPE_CHECKING:  # pragma: no cover - the same names for editors and type checkers
    from geosurf.sheets.extend import extend_horizon as extend_horizon
    from geosurf.sheets.faults.slip import EllipticThrow as EllipticThrow
    from geosurf.sheets.report.propose_trim import propose_trim as propose_trim
    from geosurf.sheets.tear import tear_horizon as tear_horizon
    from geosurf.sheets.throw.throw_horizon import throw_horizon as throw_horizon
else:
    __getattr__, __all__ = lazily(__name__)
