"""Random fault networks with a horizon whose cut-offs are known, for `benchmarks.torn_networks`.

`geosurf.synthetic.torn` has one sheet for each combination of the sides of all faults, 4096 for
twelve faults. Here sides are chosen place by place: only faults that may pass a place at one of its
possible heights are taken on both sides.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geosurf.conventions import HORIZON_DIMS
from geosurf.synthetic.torn_horizon import DATUM, Fault, fault_mesh, relief, side_of, smeared, trace

CELL = 25.0
SIDE = 2000.0  # of a map with one group of faults [m]
TILE = 1700.0  # of a map with several, each [m]
EVERY = 5.0  # metres along strike between points of true cut-offs
FAR = np.inf
TRANSFER = 0.3  # how soon the displacement of a branch dies towards the tips of its main fault


@dataclass(frozen=True, eq=False)
class Network:
    """A horizon, its faults, and its cut-offs as they are: what `tests.sheets.table.measure` takes.

    `truth` has ``"faults"`` and ``"cutoffs"`` as `geosurf.synthetic.torn` states them.
    """

    family: str
    horizon: Any
    faults: dict[str, Any]
    box: tuple[float, float, float, float]
    truth: dict[str, Any]


def random_network(family: str, rng: np.random.Generator, smear: int) -> Network:
    """
    Draw a network of some family.

    Parameters
    ----------
    family : str
        One of `GROUPS`, or ``"mixed"``: two to six groups of any kind.
    rng : numpy.random.Generator
    smear : int
        Half width of the mean that smears the horizon over its faults [nodes].

    Returns
    -------
    Network

    Examples
    --------
    >>> network = random_network("Y", np.random.default_rng(2), smear=1)
    >>> list(network.faults), network.horizon.shape
    (['F1', 'F2'], (81, 81))
    """
    while True:  # until all branches meet their main faults
        if family in THROUGH and rng.random() < 0.5:
            shape, groups = (1, 1), [GROUPS[family](rng, np.full(2, 0.5 * SIDE), True)]
        else:
            count = 1 if family != "mixed" else int(rng.integers(2, 7))
            shape = (1, count) if count < 4 else (2, (count + 1) // 2)
            centres = [TILE * (np.array([k % shape[1], k // shape[1]]) + 0.5) for k in range(count)]
            kinds = [family if family in GROUPS else str(rng.choice(list(GROUPS))) for _ in centres]
            groups = [GROUPS[kind](rng, at, False) for kind, at in zip(kinds, centres, strict=True)]
        faults = _numbered(groups)
        size = (SIDE, SIDE) if shape == (1, 1) else (TILE * shape[1], TILE * shape[0])
        if shape == (1, 1) and np.isfinite([fault.half for fault in faults.values()]).all():
            size = (TILE, TILE)
        meshes = {name: fault_mesh(name, faults, max(size), CELL, (0, 0, 0)) for name in faults}
        if all(map(_is_whole, meshes.values(), faults.values())):
            return network_of(family, faults, meshes, size, smear)


def network_of(
    family: str,
    faults: dict[str, Fault],
    meshes: dict[str, Any],
    size: tuple[float, float],
    smear: int,
) -> Network:
    """The horizon and its true cut-offs, for given faults and a map from (0, 0)."""
    import xarray as xr

    x, y = (np.arange(0.0, length + 1.0, CELL) for length in size)
    values = heights(faults, *np.meshgrid(x, y), smear)
    grid = xr.DataArray(
        values, dict(zip(HORIZON_DIMS, (y, x), strict=True)), attrs={"units": "m", "positive": "up"}
    )
    cutoffs = {
        (name, wall): _cutoff(faults, name, sign, size)
        for name in faults
        for wall, sign in (("+", 1), ("-", -1))
    }
    truth = {"faults": faults, "cutoffs": cutoffs}
    return Network(family, grid, meshes, (0.0, size[0], 0.0, size[1]), truth)


def _numbered(groups: list[list[Fault]]) -> dict[str, Fault]:
    """Faults of all groups by name; in a group, branches are on its first fault."""
    found: dict[str, Fault] = {}
    for group in groups:
        main = f"F{len(found) + 1}"
        for fault in group:
            sign = None if fault.branch is None else fault.branch[1]
            own = fault if sign is None else replace(fault, branch=(main, sign))
            found[f"F{len(found) + 1}"] = own
    return found


def _is_whole(mesh: Any, fault: Fault) -> bool:
    """Whether a branch meets its main fault at all depths, clearly inside its own length."""
    if fault.branch is None:
        return True
    s = fault.along_across(mesh["easting"].values, mesh["northing"].values)[0][:, -1]
    half = min(fault.half, 0.75 * SIDE)
    return bool((s > 4.0 * CELL - half).all() and (s < half - 4.0 * CELL).all())


# groups of faults around a place
def _tips(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """Two faults that die inside the map, one steep and one gentle, side by side."""
    strike = rng.uniform(0, 360)
    aside = 380.0 * _across(strike)
    return [
        _fault(rng, at - aside, strike, False, dips=(35.0, 50.0), halves=(350.0, 550.0)),
        _fault(rng, at + aside, strike, False, dips=(70.0, 88.0), halves=(350.0, 550.0)),
    ]


def _relay(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """Two faults that overlap for a part of their length, 10 to 14 cells from each other."""
    strike, turn = rng.uniform(0, 360), rng.uniform(-8, 8)
    shift = 0.5 * rng.uniform(250, 350) * _across(strike) + 220.0 * _along(strike)
    options = {"dips": (55.0, 85.0), "halves": (380.0, 480.0)}
    return [
        _fault(rng, at - shift, strike, False, **options),
        _fault(rng, at + shift, strike + turn, False, **options),
    ]


def _parallel(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """Two steep faults, 9 to 12 cells from each other: a trim of 3 leaves data between them."""
    strike, dip = rng.uniform(0, 360), rng.uniform(70, 85)
    shift = 0.5 * rng.uniform(225, 300) * _across(strike)
    options = {"dips": (dip, dip), "halves": (400.0, 600.0)}
    pair = [_fault(rng, at + k * shift, strike, through, **options) for k in (-1, 1)]
    return [replace(fault, wave=0.0) for fault in pair]


def _cross(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """Two faults that cross at 40 to 90 degrees."""
    strike = rng.uniform(0, 360)
    other = strike + rng.uniform(40, 90) + rng.choice([0, 180])
    return [_fault(rng, at, s, through, dips=(60.0, 85.0)) for s in (strike, other)]


def _y(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """A branch at 55 to 90 degrees."""
    return _branched(rng, at, through, rng.uniform(55, 90), (60.0, 80.0))


def _lambda(rng: np.random.Generator, at: np.ndarray, through: bool) -> list[Fault]:
    """A branch at 25 to 45 degrees."""
    return _branched(rng, at, through, rng.uniform(25, 45), (68.0, 82.0))


def _branched(
    rng: np.random.Generator, at: np.ndarray, through: bool, angle: float, dips: tuple[float, float]
) -> list[Fault]:
    """A main fault and a branch that ends on it; the branch's throw is largest there."""
    strike = rng.uniform(0, 360)
    main = _fault(rng, at, strike, through, dips=dips, halves=(500.0, 650.0))
    s = rng.uniform(-150, 150)
    place = np.array(main.place(s, main.across(s, DATUM)))
    toward = strike + rng.choice([-1, 1]) * angle + rng.choice([0, 180])
    branch = _fault(rng, place, toward, through, dips=dips, halves=(500.0, 650.0))
    side = int(side_of(main, *branch.place(-300.0, branch.across(-300.0, DATUM)), DATUM))
    return [main, replace(branch, branch=("", side))]


def _fault(
    rng: np.random.Generator,
    at: np.ndarray,
    strike: float,
    through: bool,
    dips: tuple[float, float] = (50.0, 85.0),
    halves: tuple[float, float] = (400.0, 600.0),
) -> Fault:
    """One normal fault."""
    profile = "constant" if through else str(rng.choice(["parabola", "ellipse", "bell"]))
    half = FAR if through else rng.uniform(*halves)
    throw, dip = rng.uniform(25, 70), rng.uniform(*dips)
    return Fault(*map(float, at), strike % 360.0, dip, half, throw, profile)


def _along(strike: float) -> np.ndarray:
    return np.array([np.sin(np.radians(strike)), np.cos(np.radians(strike))])


def _across(strike: float) -> np.ndarray:
    return np.array([np.cos(np.radians(strike)), -np.sin(np.radians(strike))])


Group = Callable[[np.random.Generator, np.ndarray, bool], list[Fault]]
GROUPS: dict[str, Group] = {
    "Y": _y,
    "lambda": _lambda,
    "X": _cross,
    "relay": _relay,
    "parallel": _parallel,
    "tips": _tips,
}
THROUGH = ("Y", "lambda", "X", "parallel")  # may run right through a map of their own


def heights(faults: Mapping[str, Fault], x: np.ndarray, y: np.ndarray, smear: int) -> np.ndarray:
    """One elevation per node, as a gridder gives it: on the fault in gaps, smeared over faults."""
    moves = _moves(faults, x, y)
    bound = sum(np.maximum(abs(up), abs(down)) for up, down in moves) + 1.0
    fixed = _sides(faults, x, y, relief(x, y))
    doubtful = _sides(faults, x, y, relief(x, y) - bound) != _sides(
        faults, x, y, relief(x, y) + bound
    )
    value = np.full(x.shape, -np.inf)
    low, high = np.full(x.shape, np.inf), np.full(x.shape, -np.inf)
    chosen = np.zeros_like(fixed)
    patterns, of = np.unique(doubtful.reshape(len(faults), -1).T, axis=0, return_inverse=True)
    for number, pattern in enumerate(patterns):
        mine = of.reshape(x.shape) == number
        for signs in itertools.product((1, -1), repeat=int(pattern.sum())):
            side = fixed[:, mine].copy()
            side[pattern] = np.array(signs)[:, None]
            side = _without_branches(faults, side)
            own = [(up[mine], down[mine]) for up, down in moves]
            z = _sheet(x[mine], y[mine], own, side)
            low[mine], high[mine] = np.minimum(low[mine], z), np.maximum(high[mine], z)
            there = ((_sides(faults, x[mine], y[mine], z) == side) | (side == 0)).all(axis=0)
            better = there & (z > value[mine])
            value[mine] = np.where(better, z, value[mine])
            chosen[:, mine] = np.where(better, side, chosen[:, mine])
    gap = np.isneginf(value)
    value[gap] = _on_faults(faults, x[gap], y[gap], low[gap], high[gap])
    return _smeared_at_faults(faults, x, y, value, chosen, smear)


def _smeared_at_faults(
    faults: Mapping[str, Fault],
    x: np.ndarray,
    y: np.ndarray,
    value: np.ndarray,
    chosen: np.ndarray,
    smear: int,
) -> np.ndarray:
    """Smear heights over each fault as far as it goes: past its tips there is nothing to smear."""
    found = value.copy()
    for k, fault in enumerate(faults.values()):
        near = np.abs(fault.along_across(x, y)[0]) < fault.half + (smear + 1) * CELL
        mixed = smeared(value, {"+": chosen[k] == 1, "none": chosen[k] == 0}, smear)
        found = np.where(near, np.where(mixed != value, mixed, found), found)
    return found


def _on_faults(
    faults: Mapping[str, Fault], x: np.ndarray, y: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Elevation of a fault between two heights; the mean of both where none is."""
    found = 0.5 * (low + high)
    for fault in faults.values():
        s, r = fault.along_across(x, y)
        a, b = low.copy(), high.copy()
        for _ in range(40):
            middle = 0.5 * (a + b)
            under = fault.across(s, middle) > r
            a, b = np.where(under, middle, a), np.where(under, b, middle)
        found = np.where((a > low) & (b < high), 0.5 * (a + b), found)
    return found


def _moves(faults: Mapping[str, Fault], x: Any, y: Any) -> list[tuple[np.ndarray, np.ndarray]]:
    """How far hanging walls and footwalls of each fault have gone down at places."""
    found = []
    for fault in faults.values():
        s, r = fault.along_across(x, y)
        share = 1.0 if fault.branch is None else _share_of_branch(faults[fault.branch[0]], x, y)
        found.append((share * fault.moved(s, r, 1, 0.0), share * fault.moved(s, r, -1, 0.0)))
    return found


def _share_of_branch(main: Fault, x: Any, y: Any) -> Any:
    """How much of a branch's displacement there is on its side of the main fault.

    It ends on the main fault, so it has to be nothing past the tips of that: otherwise the horizon
    would jump there without a fault. With h = Re sqrt(1 - zeta^2), which is 0 past the tips and
    1 in the middle of the main fault, the share has three smooth derivatives there.
    """
    if not np.isfinite(main.half):
        return 1.0
    s, r = main.along_across(x, y)
    zeta = s / main.half + 1j * (r - np.interp(s, *trace(main, 0.0))) / main.half
    square = np.sqrt(1.0 - zeta * zeta).real ** 2
    return (square / (TRANSFER + square)) ** 2


def _sheet(x: Any, y: Any, moves: list[tuple[np.ndarray, np.ndarray]], side: np.ndarray) -> Any:
    """Height of the sheet on given sides of all faults, which may differ from place to place."""
    z = relief(x, y)
    for (up, down), sign in zip(moves, side, strict=True):
        z = z - np.where(sign > 0, up, np.where(sign < 0, down, 0.0))
    return z


def _sides(faults: Mapping[str, Fault], x: Any, y: Any, z: Any) -> np.ndarray:
    """Side of every fault (n_fault, ...) at places: 1 hanging wall, -1 footwall."""
    return np.stack([side_of(fault, x, y, z) for fault in faults.values()])


def _without_branches(faults: Mapping[str, Fault], side: np.ndarray) -> np.ndarray:
    """The same sides, 0 for branches where they are on the other side of their main faults."""
    names, found = list(faults), side.copy()
    for k, fault in enumerate(faults.values()):
        if fault.branch is not None:
            found[k][side[names.index(fault.branch[0])] != fault.branch[1]] = 0
    return found


def _cutoff(
    faults: Mapping[str, Fault], name: str, sign: int, size: tuple[float, float]
) -> np.ndarray:
    """One wall's cut-off (n, 3), where the sheet that is cut is on its side of the other faults."""
    fault, which = faults[name], list(faults).index(name)
    half = min(fault.half, max(size))
    s = np.linspace(-half, half, int(2 * half / EVERY) + 1)
    z = np.full(len(s), DATUM)
    used = np.full((len(faults), len(s)), 9)
    for _ in range(6):  # sides at the last height, until they agree with it
        side = _sides(faults, *fault.place(s, fault.across(s, z)), z)
        side[which] = sign
        side = _without_branches(faults, side)
        agrees = (side == used).all(axis=0)
        if agrees.all():
            break
        a, b = np.full(len(s), DATUM - 310.0), np.full(len(s), DATUM + 310.0)
        for _ in range(36):
            z = 0.5 * (a + b)
            x, y = fault.place(s, fault.across(s, z))
            above = z > _sheet(x, y, _moves(faults, x, y), side)
            a, b = np.where(above, a, z), np.where(above, z, b)
        used = side
    x, y = fault.place(s, fault.across(s, z))
    mine = agrees & (used[which] == sign)
    mine &= (x >= 0) & (x <= size[0]) & (y >= 0) & (y <= size[1])
    return np.stack([x, y, z], axis=1)[mine]
