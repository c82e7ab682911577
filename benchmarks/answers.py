"""Each question of ``geosurf new`` on Drogon answered: ``python -m benchmarks.answers [points]``.

Every answer is a scenario of its own, whose model is built and measured without pictures. A change
of how sheets are closed has to build all of them: run it before such a change, and after it.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from pathlib import Path

from benchmarks.folders import drogon_folder
from benchmarks.real_fields import answered
from geosurf.cli import main as geosurf
from geosurf.errors import GeosurfError
from geosurf.scenario import read_scenario
from geosurf.scenario.build import build_scene

FILES = {"grids": ("drogon_xtgeo", "drogon/fault_sticks_pol"), "points": ("drogon",)}


def scenarios(field: str, folder: Path) -> Iterator[tuple[str, Path]]:
    """What `geosurf new` writes for a field, then each answer to what it asks."""
    at = folder / "scenario.toml"
    data = [str(drogon_folder() / part) for part in FILES[field]]
    if geosurf(["new", "--quiet", str(folder), *data]):
        raise SystemExit(f"geosurf new {' '.join(data)} failed")
    text = at.read_text(encoding="utf-8")
    yield "as it is", at
    for k, question in enumerate(re.findall(r"# QUESTION: (.*)", text)):
        path = folder / f"answer_{k}.toml"
        path.write_text(answered(text, k), encoding="utf-8")
        yield question, path


def main() -> int:
    """Print units and processor time of each answer; 1 if one of them is refused."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("field", choices=tuple(FILES), nargs="?", default="grids")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    refused = 0
    with tempfile.TemporaryDirectory() as folder:
        for question, path in scenarios(asked.field, Path(folder)):
            start = time.process_time()
            try:
                scene = build_scene(read_scenario(path))
                said = f"{len(scene.units)} units, {scene.units.volume:.6e} m³"
            except GeosurfError as error:
                refused, said = 1, f"REFUSED {error}"
            seconds = time.process_time() - start
            sys.stdout.write(f"{said}; processor {seconds:.1f} s: {question}\n")
            sys.stdout.flush()
    return refused


if __name__ == "__main__":
    sys.exit(main())
