"""Faulted horizons whose cut-offs are known: smeared or noisy picks, and the truth.

Every side of the faults (a sector) has a smooth sheet of its own, defined everywhere:
the relief, lowered by half the throw on a hanging wall and raised on a footwall. The horizon is
each sheet on its own side of the faults, at its own height.

Around a fault that ends, walls move as they do around a crack in an elastic body (see
`displacement`): smooth but at the two tips, and fading away from the fault.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from geosurf.conventions import did_you_mean, is_number
from geosurf.errors import InputError
from geosurf.synthetic.torn_faults import (
    DATUM,
    STEP,
    Fault,
    exists,
    named_faults,
    relief,
    sectors,
    side_of,
)
from geosurf.synthetic.torn_picks import scattered, single_valued, smeared
from geosurf.synthetic.world import (
    Offset,
    World,
    check_count,
    check_numbers,
    make_fault,
    make_horizon,
    shifted,
)

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray


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
    if not isinstance(kind, str) or kind not in kinds:
        raise InputError(
            f"no torn world is called {kind!r}; there are {', '.join(kinds)}, or give faults of "
            f"your own.{did_you_mean(str(kind), kinds)}"
        )

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
