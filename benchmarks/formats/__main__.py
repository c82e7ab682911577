"""``python -m benchmarks.formats``: measure all formats, and write the page."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from benchmarks.formats.damaged import damaged_rows
from benchmarks.formats.field_files import field_rows
from benchmarks.formats.hostile import hostile_rows
from benchmarks.formats.page import page
from benchmarks.formats.peers import Peers
from benchmarks.formats.round_trips import round_trips
from benchmarks.formats.speed import timings
from benchmarks.formats.subjects import subjects


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
    options = parser.parse_args(argv)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        peers = Peers(options.peer, folder)
        rows = round_trips(subjects(), folder)
        peers.compare(rows)
        hostile = hostile_rows(folder)
        damaged = damaged_rows(rows)
        field = field_rows(peers)
        speed = timings(peers, folder, 0.1 if options.quick else 1.0)
    text = page(
        rows, hostile, damaged, field, speed, sorted(peers.home), f"{datetime.now(UTC):%d %B %Y}"
    )
    if options.out:
        Path(options.out).write_text(text, encoding="utf-8")
    else:
        print(text)
    return int(any(wrong for *_, wrong in (*hostile, *damaged)))


if __name__ == "__main__":
    sys.exit(main())
