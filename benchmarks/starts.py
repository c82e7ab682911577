"""Starts of whole processes: from the start of Python to files with results."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import weakref
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.installed import Start, prepare_start
from benchmarks.scenes import Setting

_COMMAND = "from geosurf.cli import main; raise SystemExit(main())"
IMPORTS = "imports and kernels"
# the same, with the processor time of all imports (the outermost ones, wherever they are) at last
_SPLIT = """
import builtins, json, sys, time
began, real, inside, imports = time.process_time(), builtins.__import__, False, 0.0
def imported(*names, **words):
    global inside, imports
    if inside:
        return real(*names, **words)
    inside, start = True, time.process_time()
    try:
        return real(*names, **words)
    finally:
        inside, imports = False, imports + time.process_time() - start
builtins.__import__ = imported
from geosurf.cli import main
assert main() == 0
sys.stderr.write(json.dumps([began + imports, time.process_time()]))
"""
_SCENARIO = """positive = "up"
length_unit = "m"
[[horizons]]
name = "one"
file = "one.gri"
[[horizons]]
name = "two"
file = "two.gri"
[[faults]]
name = "F1"
file = "F1.ts"
"""


def start_process(code: str, environment: dict[str, str] | None = None, *words: str) -> int:
    """Run some Python in a new interpreter, from its start to its end; not from this folder."""
    return subprocess.run(
        [sys.executable, "-P", "-c", code, *words],
        check=True, env=environment, stdout=subprocess.DEVNULL,
    ).returncode  # fmt: skip


def _start_with_grids(options: dict, base: float) -> tuple[Start, Path]:
    """What a start is timed in, and a folder with two grids as Irap files, the second at `base`."""
    from geosurf.synthetic.world import make_horizon
    from geosurf.write import write

    start, folder = prepare_start(options), Path(tempfile.mkdtemp(prefix="geosurf-start-"))
    weakref.finalize(start, shutil.rmtree, folder, ignore_errors=True)
    levels = {"one": lambda x, y: -1800.0 + 0.02 * x, "two": lambda x, y: base + 0.01 * y}
    for name, level in levels.items():
        grid = make_horizon(name, (0.0, 2000.0, 0.0, 2000.0), 41, level, (0.0, 0.0, 0.0))
        write(grid, folder / f"{name}.gri")
    return start, folder


def two_files(setting: Setting, options: dict) -> tuple[Start, Path]:
    """What a start is timed in, and a folder with two grids as Irap files that cross."""
    return _start_with_grids(options, base=-1790.0)


def start_from_files(made: tuple[Start, Path], options: dict) -> int:
    """The curve of the two files, by the command that users have, as a file; its size."""
    start, folder = made
    one, two, out = (str(folder / name) for name in ("one.gri", "two.gri", "curve.vtp"))
    words = ("curves", one, two, "-o", out, "--positive", "up", "--length-unit", "m")
    start_process(_COMMAND, start.environment, *words)
    return Path(out).stat().st_size


def small_scenario(setting: Setting, options: dict) -> tuple[Start, Path]:
    """What a start is timed in, and a folder with a scenario: two grids and a fault."""
    from geosurf.model import TriSurface
    from geosurf.write import write

    start, folder = _start_with_grids(options, base=-1900.0)
    corners = [[900, -500, -2500], [900, 2500, -2500], [1100, -500, -1200], [1100, 2500, -1200]]
    fault = TriSurface("F1", "fault", corners, [[0, 1, 3], [0, 3, 2]])
    write(fault, folder / "F1.ts")
    (folder / "scenario.toml").write_text(_SCENARIO, encoding="utf-8")
    return start, folder


def start_of_run(made: tuple[Start, Path], options: dict) -> tuple[Start, Path]:
    """All results of the scenario but pictures, by the command that users have."""
    start, folder = made
    start_process(_COMMAND, start.environment, *_words_of_run(folder))
    return made


def parts_of_run(made: tuple[Start, Path]) -> dict[str, Any]:
    """Size of the page, and processor time of imports and of the rest: medians of three runs."""
    start, folder = made
    found = []
    for _ in range(3):
        said = subprocess.run(
            [sys.executable, "-P", "-c", _SPLIT, *_words_of_run(folder)],
            env=start.environment, check=True, capture_output=True, text=True,
        ).stderr  # fmt: skip
        imports, whole = json.loads(said.splitlines()[-1])
        found.append((imports, whole - imports))
    imports, work = (median(column) for column in zip(*found, strict=True))
    page = folder / "out" / "report" / "index.html"
    return {"bytes": page.stat().st_size, "cpu_seconds_of_parts": {IMPORTS: imports, "work": work}}


def _words_of_run(folder: Path) -> tuple[str, ...]:
    """The command that runs the scenario."""
    scenario, out = str(folder / "scenario.toml"), str(folder / "out")
    return "run", scenario, "-o", out, "--no-pictures", "--quiet"
