"""By how much the depth of cut-offs varies too much or too little under noise, over many draws.

    python -m tests.sheets.variation               # some minutes
    python -m tests.sheets.variation 20 "acute Y"  # draws of noise, some worlds only

The table of docs/validation/torn_sheets.md has the worst of five draws, which is a draw itself:
here that is its median, over draws that the table does not have.
Worlds are those of the table and those held out.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

import geosurf as gs
from geosurf.errors import GeometryError
from tests.sheets import held_out, table

FIRST, DRAWS, GROUP = 1000, 40, 5
NOISE = 2.0  # m


def sheets_of(kind: str, draws: int) -> Iterator[tuple]:
    """World, sheet (None where it is refused) and step of the grid of each draw."""
    options = {name: options for name, _, options in table.WORLDS}
    for seed in range(FIRST, FIRST + draws):
        if kind in options:
            smear = {k: v for k, v in options[kind].items() if k != "trim"}
            world = gs.synthetic.torn(kind, 81, noise=NOISE, seed=seed, **smear)
            step = table.CELL
        else:
            faults, n, step, _ = held_out.WORLDS[kind]
            world = gs.synthetic.torn(faults, n, step=step, noise=NOISE, seed=seed)
        try:
            yield (
                world,
                gs.tear_horizon(world.truth["points"], world.faults, trim=0.25, positive="up"),
                step,
            )
        except GeometryError:
            yield world, None, step


def rows_of(kind: str, draws: int) -> Iterator[str]:
    """Lines of the table, one for each fault of a world."""
    found: dict[str, list[table.Measured]] = {}
    refused = 0
    for world, sheet, step in sheets_of(kind, draws):
        refused += sheet is None
        for name in world.faults if sheet is not None else ():
            found.setdefault(name, []).append(table.measure(world, sheet, name, cell=step))
    for name, measured in found.items():
        off = 100.0 * np.array([max(abs(v - 1.0) for v in m.variation) for m in measured])
        worst = [off[k : k + GROUP].max() for k in range(0, len(off) - GROUP + 1, GROUP)]
        throw = np.nanmean(np.concatenate([m.throw for m in measured]))
        yield (
            f"| {kind:<12} | {name} | {np.median(worst):.1f} | {off.max():.1f} | {throw:.1f} | "
            f"{refused} |"
        )


def main() -> None:
    """Print the table."""
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else DRAWS
    kinds = sys.argv[2:] or [*(name for name, _, _ in table.WORLDS), *held_out.WORLDS]
    sys.stdout.write(
        "| world | fault | varies: worst of five, median | worst | throw | refused |\n"
    )
    for kind in kinds:
        for row in rows_of(kind, draws):
            sys.stdout.write(f"{row}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
