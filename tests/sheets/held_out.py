"""Worlds that nothing was chosen by: other faults, dips, strikes, throws and steps of the grid.

python -m tests.sheets.held_out          # as tests.sheets.table, minutes
python -m tests.sheets.held_out bell     # some of them only
"""

from __future__ import annotations

import sys

import numpy as np

import geosurf as gs
from geosurf.errors import GeometryError
from geosurf.synthetic.torn_horizon import Fault
from tests.sheets.table import HEAD, Measured, measure, row_of

FAR = np.inf
# name: faults, nodes per side, step [m], whether points with several values per node are needed
WORLDS: dict[str, tuple[dict[str, Fault], int, float, bool]] = {
    "steep": (
        {"F1": Fault(900, 1100, strike=63.0, dip=75.0, half=620.0, throw=35.0)},
        81,
        25.0,
        False,
    ),
    "west": (
        {"F1": Fault(1000, 950, strike=217.0, dip=52.0, half=550.0, throw=85.0)},
        81,
        25.0,
        False,
    ),
    "crack": (
        {
            "F1": Fault(
                1050, 1000, strike=131.0, dip=66.0, half=480.0, throw=45.0, profile="ellipse"
            )
        },
        81,
        25.0,
        False,
    ),
    "bell": (
        {"F1": Fault(1000, 1000, strike=75.0, dip=58.0, half=640.0, throw=55.0, profile="bell")},
        81,
        25.0,
        False,
    ),
    "coarse": (
        {"F1": Fault(2000, 2000, strike=28.0, dip=60.0, half=1500.0, throw=90.0)},
        81,
        50.0,
        False,
    ),
    "coarse crack": (
        {
            "F1": Fault(
                2000, 2000, strike=152.0, dip=55.0, half=1400.0, throw=80.0, profile="ellipse"
            )
        },
        81,
        50.0,
        False,
    ),
    "fine": (
        {"F1": Fault(640, 600, strike=101.0, dip=63.0, half=420.0, throw=30.0, wave=8.0)},
        97,
        12.5,
        False,
    ),
    "half in": (
        {"F1": Fault(1500, 700, strike=112.0, dip=60.0, half=800.0, throw=60.0)},
        81,
        25.0,
        False,
    ),
    "half crack": (
        {"F1": Fault(1600, 700, strike=112.0, dip=60.0, half=900.0, throw=50.0, profile="ellipse")},
        81,
        25.0,
        False,
    ),
    "relay": (
        {
            "F1": Fault(650, 900, strike=8.0, dip=65.0, half=520.0, throw=40.0),
            "F2": Fault(1250, 1250, strike=14.0, dip=65.0, half=560.0, throw=50.0),
        },
        81,
        25.0,
        False,
    ),
    "cross": (
        {
            "F1": Fault(
                1000, 1000, strike=73.0, dip=62.0, half=FAR, profile="constant", throw=70.0
            ),
            "F2": Fault(
                950, 1000, strike=141.0, dip=78.0, half=FAR, profile="constant", throw=30.0
            ),
        },
        81,
        25.0,
        False,
    ),
    "lambda": (
        {
            "F1": Fault(
                1000, 1000, strike=47.0, dip=64.0, half=FAR, profile="constant", throw=75.0
            ),
            "F2": Fault(
                1000,
                1000,
                strike=98.0,
                dip=70.0,
                half=FAR,
                profile="constant",
                throw=35.0,
                branch=("F1", -1),
            ),
        },
        81,
        25.0,
        False,
    ),
    "push": (
        {"F1": Fault(1000, 1000, strike=118.0, dip=38.0, half=650.0, throw=-50.0)},
        81,
        25.0,
        True,
    ),
    "push crack": (
        {
            "F1": Fault(
                1000, 1000, strike=200.0, dip=50.0, half=600.0, throw=-45.0, profile="ellipse"
            )
        },
        81,
        25.0,
        True,
    ),
}
DRAWS = range(40, 44)  # of noise


def rows_of(name: str, noise: float) -> list[str]:
    """Lines of the table: one world, smeared and clean or in points with noise."""
    faults, n, step, points = WORLDS[name]
    found: dict[str, list[Measured]] = {}
    for seed in DRAWS if noise else DRAWS[:1]:
        world = gs.synthetic.torn(faults, n, step=step, noise=noise, seed=seed)
        smeared = not (points or noise)
        picked = world.horizons["Top"] if smeared else world.truth["points"]
        trim = 0.25 if noise else 2.25
        try:
            sheet = gs.tear_horizon(picked, world.faults, name="Top", trim=trim, positive="up")
        except GeometryError as error:
            return [f"| {name} | draw {seed} refused: {error} |"]
        for fault in world.faults:
            found.setdefault(fault, []).append(measure(world, sheet, fault, cell=step))
    data = f"points, {noise:g} m" if noise else "smeared"
    return [row_of(name, data, fault, draws, 0) for fault, draws in found.items()]


def main() -> None:
    """Print the table."""
    sys.stdout.write(f"{HEAD}\n")
    for noise in (0.0, 2.0):
        for name in WORLDS:
            if len(sys.argv) < 2 or name in sys.argv[1:]:
                sys.stdout.write("\n".join([*rows_of(name, noise), ""]))
                sys.stdout.flush()


if __name__ == "__main__":
    main()
