"""Accuracy of torn sheets on worlds with known cut-offs: docs/validation/torn_sheets.md.

    python -m tests.sheets.table            # minutes
    python -m tests.sheets.table thrust X   # some worlds only

Throw and depth are compared at one place along strike, every 5 m: where the plane across strike
meets the true and the found cut-off of each wall. Places within two cells of a tip, of another
fault or of the data's rim are left out. Maps smeared by one node are torn with a trim of 2.25
cells, points, which are not smeared, with one of a quarter of a cell, of 1 where scattered. In
reverse worlds the map is points, too, since a map cannot overlap. With noise, figures are means
over five draws, and the worst of them all.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

import geosurf as gs
from geosurf.errors import GeometryError

CELL = 25.0
DRAWS = range(5, 10)  # of noise
# world, whether points with several values per node are needed, options
WORLDS = [
    ("normal", False, {}),
    ("gentle", False, {}),
    ("vertical", False, {}),
    ("ellipse", False, {}),
    ("through", False, {}),
    ("listric", False, {}),
    ("reverse", True, {}),
    ("thrust", True, {}),
    ("scissors", True, {}),
    ("Y", False, {}),
    ("X", False, {}),
    ("acute Y", False, {}),
    ("acute X", False, {}),
    ("parallel", False, {"smear": 0, "trim": 1.0}),
]
HEAD = (
    f"| {'world':<9} | {'data':<11} | fault | cut-off [cells] | throw [% of largest] | "
    "depth varies by | edges open |"
)


@dataclass(frozen=True, eq=False)
class Measured:
    """How well one fault of a sheet is met.

    Attributes
    ----------
    places : ndarray (n,)
        Distances along strike that were looked at [m].
    lost : int
        Places where a wall was not found.
    position : ndarray (2 n,)
        Distance in the map from true cut-offs to found ones [cells].
    throw : ndarray (n,)
        Error of the throw, in per cent of the fault's largest.
    largest : float
        [m]
    variation : (float, float)
        Total variation of the found cut-offs' depth, in that of the true ones: walls + and -.
    """

    places: np.ndarray
    lost: int
    position: np.ndarray
    throw: np.ndarray
    largest: float
    variation: tuple[float, float]


def measure(world, sheet, name: str, margin: float = 2.0, cell: float = CELL) -> Measured:
    """Compare a fault's cut-offs with the truth, beyond some cells from all that ends it."""
    fault, true = world.truth["faults"][name], {}
    for wall in "+-":
        line = world.truth["cutoffs"][name, wall]
        s = fault.along_across(line[:, 0], line[:, 1])[0]
        true[wall] = dict(zip(np.rint(s / 5.0).astype(int).tolist(), line, strict=True))
    both = sorted(set(true["+"]) & set(true["-"]))
    at = {wall: np.array([true[wall][k] for k in both]) for wall in "+-"}
    s = 5.0 * np.array(both)
    keep = np.abs(s) < fault.half - margin * cell
    for wall in "+-":
        keep &= _inner(world, name, at[wall], margin * cell)
    s, at = s[keep], {wall: points[keep] for wall, points in at.items()}
    z = {wall: _depth(s, at[wall], sheet.cuts[name].cutoffs[wall], fault) for wall in "+-"}
    throw = at["-"][:, 2] - at["+"][:, 2]
    largest = float(np.abs([true["-"][k][2] - true["+"][k][2] for k in both]).max())
    error = np.abs(z["-"] - z["+"] - throw) / largest * 100.0
    position = [distances(at[wall], sheet.cuts[name].cutoffs[wall]) / cell for wall in "+-"]
    near = np.diff(s) < 5.5
    varies = [
        float(np.nansum(np.abs(np.diff(z[w]))[near]) / np.abs(np.diff(at[w][:, 2]))[near].sum())
        for w in "+-"
    ]
    lost = int(np.isnan(error).sum())
    return Measured(s, lost, np.concatenate(position), error, largest, (varies[0], varies[1]))


def assert_met(
    found: Measured,
    *,
    position: float = 0.1,
    mean: float = 1.0,
    worst: float = 5.0,
    variation: float = 0.05,
) -> None:
    """Walls are found at all places, and as near as asked.

    Distance of cut-offs [cells], mean and worst error of the throw [%], change of variation.
    """
    assert found.lost == 0
    assert found.position.max() < position
    assert found.throw.mean() < mean
    assert found.throw.max() < worst
    assert max(abs(varies - 1.0) for varies in found.variation) <= variation


def _inner(world, name: str, points: np.ndarray, margin: float) -> np.ndarray:
    """Points beyond a distance [m] from the rim of the data and from other faults."""
    w, e, s, n = world.box[:4]
    x, y = points[:, 0], points[:, 1]
    keep = np.min([x - w, e - x, y - s, n - y], axis=0) > margin
    for other in world.faults:
        if other != name:
            lines = np.concatenate([world.truth["cutoffs"][other, wall] for wall in "+-"])
            gap = np.hypot(*(points[:, None, :2] - lines[None, ::2, :2]).transpose(2, 0, 1))
            keep &= gap.min(axis=1) > margin
    return keep


def _depth(s: np.ndarray, true: np.ndarray, lines, fault) -> np.ndarray:
    """Elevation (n,) of lines where planes across strike meet them, nearest to the true place."""
    z, best = np.full(len(s), np.nan), np.full(len(s), np.inf)
    across = fault.along_across(true[:, 0], true[:, 1])[1]
    for line in lines:
        along, away = fault.along_across(line[:, 0], line[:, 1])
        for k in range(len(line) - 1):
            low, high = sorted(along[k : k + 2])
            for i in np.flatnonzero((s >= low) & (s <= high) & (high > low)):
                t = (s[i] - along[k]) / (along[k + 1] - along[k])
                far = abs(away[k] + t * (away[k + 1] - away[k]) - across[i])
                if far < best[i]:
                    best[i], z[i] = far, line[k, 2] + t * (line[k + 1, 2] - line[k, 2])
    return z


def distances(points: np.ndarray, lines) -> np.ndarray:
    """Distance (n,) of points to lines in the map [m]."""
    best = np.full(len(points), np.inf)
    for line in lines:
        for a, b in zip(line[:-1, :2], line[1:, :2], strict=True):
            t = b - a
            length = max(float(t @ t), 1e-30)
            f = np.clip((points[:, :2] - a) @ t / length, 0.0, 1.0)
            best = np.minimum(best, np.hypot(*(points[:, :2] - a - f[:, None] * t).T))
    return best


def open_edges(world, sheet) -> int:
    """Rims of the exactly cut sheet that are neither the data's own outline nor on a fault."""
    patches = gs.trim_sheets(gs.rebuild_surfaces([sheet.surface, *sheet.faults]))
    of = patches.surface_of_triangle
    edges = [
        np.sort(np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        for t in (patches.triangles[of == 0], patches.triangles[of > 0])
    ]
    own, times = np.unique(edges[0], axis=0, return_counts=True)
    shared = {tuple(e) for e in edges[1].tolist()}
    free = np.array([e for e in own[times == 1].tolist() if tuple(e) not in shared])
    x, y = patches.vertices[free][..., 0], patches.vertices[free][..., 1]
    lattice = sheet.lattice
    w, e, s, n = (f(c) for c in (lattice.easting, lattice.northing) for f in (np.min, np.max))
    sides = [abs(x - w), abs(x - e), abs(y - s), abs(y - n)]  # nodes without points are fitted
    border = np.any([(far < 1e-6).all(axis=1) for far in sides], axis=0)
    return int((~border).sum() + (times > 2).sum())


def rows_of(kind: str, points: bool, options: dict, data: str, n: int = 81) -> list[str]:
    """Lines of the table: one world, and data that are smeared, noisy or scattered."""
    chosen = dict(options)
    trim = chosen.pop("trim", 2.25)
    noise = 2.0 if data.endswith("2 m") else 0.0
    found: dict[str, list[Measured]] = {}
    leaks = 0
    for seed in DRAWS if noise else DRAWS[:1]:
        world = gs.synthetic.torn(kind, n, noise=noise, seed=seed, **chosen)
        picked = world.truth["points"] if points or data != "smeared" else world.horizons["Top"]
        if data != "smeared":
            trim = 0.25
        if data.startswith("scattered"):
            picked = world.truth["scattered"](n * n, noise, seed)
            trim = 1.0
        try:
            sheet = gs.tear_horizon(picked, world.faults, name="Top", trim=trim, positive="up")
        except GeometryError as error:
            return [f"| {kind} | {data} | draw {seed} refused: {error} |"]
        leaks += 0 if data.startswith("scattered") else open_edges(world, sheet)
        for name in world.faults:
            found.setdefault(name, []).append(measure(world, sheet, name))
    return [row_of(kind, data, name, draws, leaks) for name, draws in found.items()]


def row_of(kind: str, data: str, name: str, draws: list[Measured], leaks: int) -> str:
    position = [m.position for m in draws]
    throw = [m.throw for m in draws]
    varies = max((v - 1 for m in draws for v in m.variation), key=abs)
    lost = sum(m.lost for m in draws)
    return (
        f"| {kind:<9} | {data:<11} | {name:<5} | {np.mean(position):.3f}, "
        f"{np.max(position):.3f} | {np.nanmean(throw):.1f}, {np.nanmax(throw):.1f} | "
        f"{varies:+.1%} | {leaks} |" + (f" {lost} lost" if lost else "")
    )


def main() -> None:
    """Print the table."""
    sys.stdout.write(f"{HEAD}\n")
    for data in ("smeared", "points, 2 m", "scattered", "scattered, 2 m"):
        for kind, points, options in WORLDS:
            if len(sys.argv) < 2 or kind in sys.argv[1:]:
                sys.stdout.write("\n".join([*rows_of(kind, points, options, data), ""]))
                sys.stdout.flush()


if __name__ == "__main__":
    main()
