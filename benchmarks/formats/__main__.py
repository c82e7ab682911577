"""``python -m benchmarks.formats``: measure all formats, and write the page."""

from __future__ import annotations

import argparse
import contextlib
import pickle
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

from benchmarks.formats.damaged import damaged_rows
from benchmarks.formats.field_files import field_rows
from benchmarks.formats.hostile import hostile_rows
from benchmarks.formats.page import page
from benchmarks.formats.peers import Peers
from benchmarks.formats.round_trips import Row, round_trips
from benchmarks.formats.speed import timings
from benchmarks.formats.subjects import subjects

Result = TypeVar("Result")


def main(argv: Sequence[str] | None = None) -> int:
    """Print the page, or write it; 1 if something is wrong."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.formats",
        description="Write every kind of object in every format, and read it back.",
    )
    parser.add_argument(
        "--peer", action="append", default=[], metavar="PYTHON",
        help="interpreter with xtgeo, meshio, pyvista, trimesh, rioxarray, geopandas, pandas, "
        "opengeode (core, io, geosciences, geosciencesio), resqpy",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="small maps and meshes for times")
    parser.add_argument("-o", "--out", help="page to write (.md)")
    parser.add_argument(
        "--keep", metavar="FOLDER",
        help="keep files and the result of each step here; a run that was ended goes on from there",
    )  # fmt: skip
    options = parser.parse_args(argv)

    with contextlib.ExitStack() as stack:
        folder = Path(options.keep or stack.enter_context(tempfile.TemporaryDirectory()))
        folder.mkdir(parents=True, exist_ok=True)
        steps = Steps(folder)
        peers = steps.result("packages", lambda: Peers(options.peer, folder))
        rows = steps.result("written", lambda: _compared(peers, folder))
        hostile = steps.result("hostile objects", lambda: hostile_rows(folder))
        damaged = steps.result("hostile files", lambda: damaged_rows(rows))
        field = steps.result("field files", lambda: field_rows(peers))
        scale = 0.1 if options.quick else 1.0
        speed = steps.result("speed", lambda: timings(peers, folder, scale))
    text = page(
        rows, hostile, damaged, field, speed, sorted(peers.home), f"{datetime.now(UTC):%d %B %Y}"
    )
    if options.out:
        Path(options.out).write_text(text, encoding="utf-8")
    else:
        print(text)
    return int(any(wrong for *_, wrong in (*hostile, *damaged)))


def _compared(peers: Peers, folder: Path) -> list[Row]:
    """Rows of what is written, with what other packages make of it."""
    rows = round_trips(subjects(), folder)
    peers.compare(rows)
    return rows


class Steps:
    """
    Results of steps, kept in a folder so that a run can go on.

    Parameters
    ----------
    folder : pathlib.Path
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def result(self, name: str, run: Callable[[], Result]) -> Result:
        """Result of a step, from before or now; its time goes to standard error."""
        path = self.folder / f"step_{name.replace(' ', '_')}.pickle"
        if path.exists():
            kept: Result = pickle.loads(path.read_bytes())
            print(f"{name}: kept from before", file=sys.stderr, flush=True)
            return kept
        start = time.perf_counter()
        found = run()
        path.write_bytes(pickle.dumps(found))
        print(f"{name}: {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)
        return found


if __name__ == "__main__":
    sys.exit(main())
