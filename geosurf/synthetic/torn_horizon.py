"""Faulted horizons whose cut-offs are known: smeared or noisy picks, and the truth.

Every side of the faults (a sector) has a smooth sheet of its own, defined everywhere:
the relief, lowered by half the throw on a hanging wall and raised on a footwall. The horizon is
each sheet on its own side of the faults, at its own height.

Around a fault that ends, walls move as they do around a crack in an elastic body (see
`displacement`): smooth but at the two tips, and fading away from the fault.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np

from geosurf.conventions import check_word, is_number
from geosurf.errors import InputError
from geosurf.lazy import xarray
from geosurf.synthetic.world import (
    Offset,
    World,
    check_count,
    check_numbers,
    make_fault,
    make_horizon,
    shifted,
)

# ---- torn picks ----------------------------------------
# Picks of a torn horizon: one value per node, smeared over the faults, or scattered points.


def single_valued(
    faults: Mapping[str, Fault],
    x: np.ndarray,
    y: np.ndarray,
    heights: Mapping[Any, np.ndarray],
    there: Mapping[Any, np.ndarray],
) -> np.ndarray:
    """One value per node: the highest sheet, and the fault itself in gaps."""
    # (n_sheet, n, n): elevations of sheets where they exist, NaN elsewhere
    every = np.stack([np.where(there[s], z, np.nan) for s, z in heights.items()])
    none = np.isnan(every).all(axis=0)

    # the highest sheet where walls overlap; a map has one value per node
    top = np.where(none, -np.inf, np.nan_to_num(every, nan=-np.inf).max(axis=0))

    # in a gap no sheet exists: the fault lies between the sheets that would meet there
    low, high = np.min(list(heights.values()), axis=0), np.max(list(heights.values()), axis=0)
    gap = 0.5 * (low + high)
    for fault in faults.values():
        s, r = fault.along_across(x, y)
        a, b = low.copy(), high.copy()
        for _ in range(40):  # where the fault is between the sheets, by halving
            middle = 0.5 * (a + b)
            under = fault.across(s, middle) > r
            a, b = np.where(under, middle, a), np.where(under, b, middle)

        # the fault between both sheets, else the middle of them
        inside = (a > low) & (b < high)
        gap = np.where(inside, 0.5 * (a + b), gap)
    return np.where(none, gap, top)


def smeared(values: np.ndarray, there: dict, width: int) -> np.ndarray:
    """The mean over a square where sheets meet in it, the value itself elsewhere."""
    if width == 0:
        return values

    # nodes whose window shows several sets of sheets are near a fault: only these are smeared
    code = np.zeros(values.shape, dtype=np.int64)  # which sheets there are, one bit for each
    for number, mask in enumerate(there.values()):
        if number % 32 == 31:  # bits run out; equal ones stay equal
            code = np.unique(code, return_inverse=True)[1].reshape(values.shape)
        code = 2 * code + mask
    k = 2 * width + 1
    shape = (k, k)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, width, mode="edge"), shape)
    codes = np.lib.stride_tricks.sliding_window_view(np.pad(code, width, mode="edge"), shape)
    mixed = codes.min(axis=(2, 3)) != codes.max(axis=(2, 3))
    return np.where(mixed, windows.mean(axis=(2, 3)), values)


def scattered(
    faults: Mapping[str, Fault],
    sheets: Mapping[Any, Any],
    side: float,
    number: int,
    noise: float = 0.0,
    seed: int = 5,
) -> np.ndarray:
    """Points (n, 3) at random places, on each sheet that exists there."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0.0, side, (2, number))
    clouds = []
    for signs, sheet in sheets.items():
        z = sheet(x, y)
        clouds.append(np.stack([x, y, z], axis=1)[exists(faults, signs, x, y, z)])
    points = np.concatenate(clouds)
    points[:, 2] += noise * rng.standard_normal(len(points))
    return points


# ---- torn faults ----------------------------------------
# Faults of worlds with a torn horizon: traces, throw profiles, and the worlds that have a name.


DATUM = -1800.0
STEP = 25.0
DYING = ("parabola", "ellipse", "bell")
PROFILES = (*DYING, "constant", "scissors")


@dataclass(frozen=True)
class Fault:
    """One fault of a torn world: places in m, angles in degrees.

    `strike` with the dip to its right; `half` its half length (inf: through-going); `throw` at
    its centre, negative for reverse; `profile`: of the throw along strike, "parabola", "ellipse",
    "bell" (not that of a crack), "constant" or "scissors"; `flatten` bends it with depth [1/m];
    `branch`: the main fault and the side of it on which this one is.
    """

    x: float
    y: float
    strike: float = 20.0
    dip: float = 60.0
    half: float = 700.0
    throw: float = 60.0
    profile: str = "parabola"
    flatten: float = 0.0
    wave: float = 20.0
    branch: tuple[str, int] | None = None

    def __post_init__(self) -> None:
        refusal = f"profile of a torn world's fault is {self.profile!r}; it must be one of"
        check_word(self.profile, PROFILES, f"{refusal} {', '.join(PROFILES)}.")
        if self.profile in DYING and not np.isfinite(self.half):
            raise InputError(
                f"a torn world's fault has no end (half = {self.half}), but its throw, of profile "
                f"{self.profile!r}, dies there. Give half in metres, or another profile."
            )

    def along_across(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Coordinates along strike and across it, down dip."""
        # x = s sin(strike) + r cos(strike), y = s cos(strike) - r sin(strike): strike is clockwise
        # from north.
        a = np.radians(self.strike)
        dx, dy = x - self.x, y - self.y
        return dx * np.sin(a) + dy * np.cos(a), dx * np.cos(a) - dy * np.sin(a)

    def place(self, s: Any, r: Any) -> tuple[Any, Any]:
        """The inverse of `along_across`."""
        a = np.radians(self.strike)
        return self.x + s * np.sin(a) + r * np.cos(a), self.y + s * np.cos(a) - r * np.sin(a)

    def across(self, s: Any, z: Any) -> Any:
        """Where the fault is, across strike, at a place along it and an elevation."""
        # The cotangent of the dip is heave per depth; `flatten` makes it grow with depth.
        down = DATUM - z
        cot = 0.0 if self.dip == 90 else 1.0 / np.tan(np.radians(self.dip))
        return self.wave * np.sin(s / 450.0) + down * (cot + self.flatten * (down + 300.0))

    def moved(self, s: Any, r: Any, sign: int, level: float) -> Any:
        """How far a wall (+1 hanging) has gone down at places along and across [m]."""
        # each wall moves by half: the fault stays where it is, and the trace does not depend on
        # throw
        half = 0.5 * self.throw
        if self.profile == "constant":
            return sign * half * np.ones_like(s)
        if self.profile == "scissors":
            return sign * half * s / 1000.0

        # distance from the trace at this level, in half lengths: the crack is straight in these
        # coordinates
        away = (r - np.interp(s, *trace(self, level))) / self.half
        if self.profile == "bell":  # no crack: both walls die away as they do along strike
            dies = np.maximum(1.0 - (s / self.half) ** 2, 0.0) ** 2
            return sign * half * dies * np.exp(-2.0 * away**2)
        return sign * half * displacement(self.profile, s / self.half, sign * away)


@lru_cache(maxsize=32)
def trace(fault: Fault, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Where, across strike, a fault meets the horizon as it was before: along and across [m]."""
    s = np.arange(-2.5 * fault.half, 2.5 * fault.half + 1.0, 0.25)  # linear between, to 1e-8 m

    # Bisection: elevations above the horizon come down, others go up; 60 halvings reach rounding.
    low, high = np.full(len(s), DATUM - 330.0), np.full(len(s), DATUM + 330.0)
    for _ in range(60):
        z = 0.5 * (low + high)
        above = z > relief(*fault.place(s, fault.across(s, z))) + level
        low, high = np.where(above, low, z), np.where(above, z, high)
    return s, fault.across(s, z)


def displacement(profile: str, s: Any, r: Any) -> Any:
    """Share of half the largest throw by which a wall moves, next to a fault from s = -1 to 1.

    The real part of an analytic function of s + i r: harmonic, 0 far away and straight on past
    the tips, and on the fault (r = 0) the square root of 1 - s^2 (``"ellipse"``, a crack in
    anti-plane shear, Pollard & Segall 1987) or 1 - s^2 itself (``"parabola"``). The wall is on
    the side where r > 0, and goes on analytically past the fault.
    """
    inside = np.abs(s) < 1.0
    side = np.where(inside | (r >= 0), 1.0, -1.0)  # past the tips both walls are one
    tiny = np.finfo(np.float64).tiny
    zeta = s + 1j * np.where(inside, r, np.maximum(np.abs(r), tiny))
    # On the fault (r = 0) this is sqrt(1 - s^2), an ellipse.
    if profile == "ellipse":
        share = np.sqrt(1.0 - zeta * zeta).real - zeta.imag
        return side * share

    # On the fault this is 1 - s^2, a parabola; beyond the tips its limit is 0.
    # log is singular at both tips, where the product with 1 - zeta^2 is 0: replaced below
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.where(
            inside,
            np.log(1.0 + zeta) - np.log(1.0 - zeta) - 1j * np.pi,
            np.log((zeta + 1.0) / (zeta - 1.0)),
        )
        share = -((1.0 - zeta * zeta) * log + 2.0 * zeta).imag / np.pi
    return side * np.where(np.abs(zeta * zeta - 1.0) > 0, share, 0.0)


def named_faults(side: float) -> dict[str, dict[str, Fault]]:
    """Faults of each kind of world, for a square of a given side."""
    c = 0.5 * side
    through: dict[str, Any] = {"half": np.inf, "profile": "constant"}
    return {
        "normal": {"F1": Fault(c, c)},
        "gentle": {"F1": Fault(c, c, dip=35.0)},
        "vertical": {"F1": Fault(c, c, dip=90.0)},
        "ellipse": {"F1": Fault(c, c, profile="ellipse")},
        "through": {"F1": Fault(c, c, **through)},
        "listric": {"F1": Fault(c, c, dip=55.0, flatten=4e-4)},
        "scissors": {"F1": Fault(c, c, half=np.inf, profile="scissors")},
        "reverse": {"F1": Fault(c, c, dip=45.0, throw=-60.0)},
        "thrust": {"F1": Fault(c, c, dip=30.0, throw=-100.0)},
        "Y": {
            "F1": Fault(c, c, **through),
            "F2": Fault(c, c, strike=95.0, throw=40.0, branch=("F1", -1), **through),
        },
        "X": {
            "F1": Fault(c, c, dip=70.0, **through),
            "F2": Fault(c, c, strike=100.0, dip=70.0, throw=40.0, **through),
        },
        "acute Y": {
            "F1": Fault(c, c, **through),
            "F2": Fault(c, c, strike=40.0, throw=40.0, branch=("F1", -1), **through),
        },
        "acute X": {
            "F1": Fault(c, c, dip=70.0, **through),
            "F2": Fault(c, c, strike=42.0, dip=70.0, throw=40.0, **through),
        },
        "parallel": {
            "F1": Fault(c - 2.2 * STEP, c, strike=12.0, dip=80.0, wave=0.0, **through),
            "F2": Fault(c + 2.2 * STEP, c, strike=12.0, dip=80.0, wave=0.0, throw=40.0, **through),
        },
    }


def relief(x: Any, y: Any) -> Any:
    """The horizon before it was faulted [m]."""
    # a broad relief and a finer oblique one, so that no axis of the grid is special
    k, m = 2 * np.pi / 4000.0, 2 * np.pi / 1200.0
    broad = 60.0 * np.sin(k * x + 0.3) * np.cos(k * y - 0.4)
    return DATUM + broad + 15.0 * np.sin(m * (0.8 * x + 0.6 * y))


def sectors(faults: dict[str, Fault]) -> list[tuple[int, ...]]:
    """Sides of all faults, 0 for a branch on the side of its main fault where it is not."""
    names = list(faults)
    combinations = []

    # A branch ends at its main fault: beyond it, its two sides are one.
    for signs in itertools.product((1, -1), repeat=len(names)):
        # off: the sign of the main fault is not the side that the branch is on
        branch = [faults[name].branch for name in names]
        off = [b is not None and signs[names.index(b[0])] != b[1] for b in branch]
        signs = tuple(0 if gone else s for s, gone in zip(signs, off, strict=True))
        if signs not in combinations:
            combinations.append(signs)
    return combinations


def side_of(fault: Fault, x: Any, y: Any, z: Any) -> Any:
    """Return on which side of a fault places are: 1 hanging wall, -1 footwall."""
    s, r = fault.along_across(x, y)
    return np.where(r > fault.across(s, z), 1, -1)


def exists(
    faults: Mapping[str, Fault], signs: Sequence[int], x: np.ndarray, y: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """Where a sheet is on its own side of all faults; beyond tips all sheets are one."""
    there = np.ones(np.shape(x), dtype=bool)

    # 0: the sector does not touch this fault
    for fault, sign in zip(faults.values(), signs, strict=True):
        if sign:
            there &= side_of(fault, x, y, z) == sign
    return there


MOST_METRES = 1e6  # between nodes, or of noise


def torn(
    kind: str | Mapping[str, Fault] = "normal",
    n: int = 81,
    *,
    step: float = STEP,
    smear: int = 1,
    noise: float = 0.0,
    level: float = 0.0,
    seed: int = 5,
    offset: Offset = (0.0, 0.0, 0.0),
) -> World:
    """A faulted horizon as it is picked: smeared over its faults, or noisy.

    Parameters
    ----------
    kind : str or mapping of str to Fault
        Faults of your own (``torn_horizon.Fault``), placed in a square from (0, 0), or
        ``"normal"`` (60 degrees, up to 60 m of throw, dying at both tips), ``"gentle"`` (35
        degrees), ``"vertical"``, ``"ellipse"`` (profile of the throw), ``"through"`` (cuts
        right through), ``"listric"``, ``"reverse"``, ``"thrust"`` (30 degrees, overlap),
        ``"scissors"`` (throw changes its sign along strike), ``"Y"``, ``"X"``, ``"acute Y"`` and
        ``"acute X"`` (at some 20 degrees), or ``"parallel"`` (two faults about four cells apart).
    n : int
        Nodes per side.
    step : float
        Distance of nodes [m].
    smear : int
        Half width of the square mean that smears the map where faults are [nodes].
    noise : float
        Standard deviation of noise on all data [m].
    level : float
        How much higher the horizon lies than at its usual level [m], for a second one on the same
        faults; -200 to 200.
    seed : int
        Another number gives other noise.
    offset : (float, float, float)
        Added to all coordinates [m].

    Returns
    -------
    World
        Horizon ``Top``, one value per node. `truth` has ``"points"`` (n, 3), every sheet wherever
        it exists: several per node where they overlap; ``"scattered"``: a function of a number,
        noise [m] and a seed, that many points (n, 3) anywhere on it, before the offset;
        ``"cutoffs"``: by fault and wall (``"+"`` hanging wall), lines (n, 3); and ``"faults"``: the
        formulas of the faults (`Fault`), before the offset.

    Raises
    ------
    InputError
        If the kind is unknown or a size out of range.

    Examples
    --------
    >>> world = torn("normal", n=41)
    >>> foot, hang = (world.truth["cutoffs"]["F1", wall] for wall in "-+")
    >>> round(float((foot - hang)[:, 2].max()))
    56
    """
    # elevations within 300 m of the datum: the box and the faults reach no farther
    if not (is_number(level) and -200.0 <= level <= 200.0):
        raise InputError(f"level is {level} m, expected -200 to 200, within the faults.")
    for word, value, least in (("n", n, 2), ("smear", smear, 0)):
        check_count(value, word, least)
    if seed is not None:
        check_count(seed, "seed", 0)
    for word, size, fits in (("step", step, "above 0"), ("noise", noise, "0 or more")):
        lowest = 0.0 if fits == "0 or more" else 1e-9
        if not (is_number(size) and lowest <= size <= MOST_METRES):
            raise InputError(f"{word} is {size!r}; give metres, {fits}, up to {MOST_METRES:g}.")
    offset = check_numbers(offset, 3, "offset")

    side = (n - 1) * step
    faults = _faults_of(kind, side)
    axis = np.linspace(0.0, side, n)
    x, y = np.meshgrid(axis, axis)
    # One sheet for each sector of the faults; nodes exist where the sheet is on its own side.
    sheets = {signs: _sheet(faults, signs, level) for signs in sectors(faults)}
    heights = {signs: sheet(x, y) for signs, sheet in sheets.items()}
    there = {signs: exists(faults, signs, x, y, z) for signs, z in heights.items()}

    # one stream for all noise, in this order: the same seed gives the same world
    rng = np.random.default_rng(seed)
    # Picks as a gridder leaves them: one value per node, smeared over the faults, then noise.
    values = smeared(single_valued(faults, x, y, heights, there), there, smear)
    values = values + noise * rng.standard_normal(values.shape)
    box = (0.0, side, 0.0, side, DATUM - 300.0, DATUM + 300.0)

    # All sheets as points in space, at all nodes where they exist.
    points = [np.stack([x, y, z], axis=-1)[there[s]] for s, z in heights.items()]
    cloud = np.concatenate(points) + offset
    cloud[:, 2] += noise * rng.standard_normal(len(cloud))

    truth = {
        "points": cloud,
        "faults": faults,
        "scattered": partial(scattered, faults, sheets, side),
        "cutoffs": {
            (name, wall): _cutoff(faults, name, wall, sheets, side) + offset
            for name in faults
            for wall in "+-"
        },
    }

    top = make_horizon("Top", box, n, lambda *_: values, offset)
    meshes = {name: fault_mesh(name, faults, side, step, offset) for name, fault in faults.items()}
    formula = (
        f"Relief of 60 m at 4 km and 15 m at 1.2 km wavelength, torn by {', '.join(faults)}: half "
        f"of the throw on either side. Smeared over {smear} nodes, noise {noise:g} m."
    )
    title = kind if isinstance(kind, str) else "_".join(faults)
    return World(f"torn_{title}", {"Top": top}, meshes, shifted(box, offset), truth, formula)


def _faults_of(kind: str | Mapping[str, Fault], side: float) -> dict[str, Fault]:
    """Faults of a kind of world, shorter in a small map; or those that are given."""
    kinds = named_faults(side)
    if isinstance(kind, Mapping):
        odd = [name for name, fault in kind.items() if not isinstance(fault, Fault)]
        if odd or not kind:
            what = f"{odd[0]!r}, a {type(kind[odd[0]]).__name__}," if odd else "no fault"
            raise InputError(
                f"the faults of a torn world have {what} among them; give "
                "{name: torn_horizon.Fault(x, y, ...)}."
            )
        return dict(kind)
    refusal = f"no torn world is called {kind!r}; there are {', '.join(kinds)}, or give faults of"
    check_word(kind, kinds, f"{refusal} your own.")

    # A small map has shorter faults, so that they still end inside.
    small = side / 2000.0 if side < 1500.0 else 1.0
    return {k: replace(f, half=f.half * small) for k, f in kinds[kind].items()}


def _sheet(
    faults: dict[str, Fault], signs: tuple[int, ...], level: float
) -> Callable[[Any, Any], Any]:
    def height(x: Any, y: Any) -> Any:
        """Height of the sheet: relief, level and half of each throw."""
        z = relief(x, y) + level
        for fault, sign in zip(faults.values(), signs, strict=True):
            z = z - fault.moved(*fault.along_across(x, y), sign, level) if sign else z
        return z

    return height


def _cutoff(
    faults: Mapping[str, Fault], name: str, wall: str, sheets: Mapping[Any, Any], side: float
) -> np.ndarray:
    """One wall's cut-off line, every 5 m along strike, where the sheet is on its side of others."""
    fault, sign = faults[name], 1 if wall == "+" else -1
    which = list(faults).index(name)
    half = min(fault.half, side)

    # a point each 5 m, where one is on a sheet
    s = np.linspace(-half, half, int(2 * half / 5.0) + 1)
    lines = []
    # Bisection between fault and sheet, as in `trace`.
    for signs, sheet in sheets.items():
        if signs[which] != sign:
            continue
        a, b = np.full(len(s), DATUM - 330.0), np.full(len(s), DATUM + 330.0)
        for _ in range(60):
            z = 0.5 * (a + b)
            above = z > sheet(*fault.place(s, fault.across(s, z)))
            a, b = np.where(above, a, z), np.where(above, z, b)
        x, y = fault.place(s, fault.across(s, z))
        # The cut-off ends where another fault takes the sheet away, and at the rim of the map.
        others = tuple(0 if k == which else v for k, v in enumerate(signs))
        mine = exists(faults, others, x, y, z)
        mine &= (x >= 0) & (x <= side) & (y >= 0) & (y <= side)
        lines.append(np.stack([x, y, z], axis=1)[mine])
    return np.concatenate(lines)


def fault_mesh(
    name: str, faults: dict[str, Fault], side: float, step: float, offset: Offset
) -> xarray.Dataset:
    """A fault as a grid, finer than the horizon along strike."""
    fault = faults[name]
    half = min(fault.half, 0.75 * side)

    # 20 m along strike; three rows do for a plane, 41 follow one that bends
    n = max(int(2 * half / 20.0), 8) + 1

    # 20 m beyond the box at top and bottom
    z = np.linspace(DATUM + 320.0, DATUM - 320.0, 3 if fault.flatten == 0 else 41)[:, None]
    ends = np.array([-half, half])[:, None, None] * np.ones((1, len(z), 1))
    if fault.branch is not None:
        main, sign = faults[fault.branch[0]], fault.branch[1]
        a, b = -half * np.ones_like(z), half * np.ones_like(z)
        for _ in range(60):  # where the branch meets its main fault, by halving
            s = 0.5 * (a + b)
            on = side_of(main, *fault.place(s, fault.across(s, z)), z) == sign
            a, b = np.where(on, s, a), np.where(on, b, s)
        # half a cell too long, as interpreters draw them
        ends[1] = s + 0.5 * step
    s = ends[0] + (ends[1] - ends[0]) * np.linspace(0.0, 1.0, n)[None, :]
    x, y = fault.place(s, fault.across(s, z))
    return make_fault(name, x, y, z, offset)
