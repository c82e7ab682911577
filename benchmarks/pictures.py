"""What a first picture takes: ``python -m benchmarks.pictures``.

Noisy hills and a listric fault of 2e7 triangles seen from the southwest, and the exploded units of
2e6. Each is drawn in a process of its own, which reports the peak of what is resident beyond its
grids, model included, and the time from grids to the file. A scene copies grids that can be written
to; the view is drawn of such grids and of read-only ones. Without frozen kernels, numba takes 60 to
100 MB more. pyvista loads mypy where it is installed, 18 MB; who draws pictures rarely has it, and
here it counts as absent.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.scenes import make_setting

READ_ONLY = "view of read-only grids"
PICTURES = {"view": 2e7, READ_ONLY: 2e7, "exploded units": 2e6}
ASKED = {"view": "2 s, 400 MB", READ_ONLY: "", "exploded units": "1.5 s, 400 MB"}


def resident() -> tuple[float, float]:
    """What is resident, and its peak [MB]; of Linux."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    found = dict(line.split(":", 1) for line in lines if ":" in line)
    now, peak = (int(found[key].split()[0]) / 1000.0 for key in ("VmRSS", "VmHWM"))
    return now, peak


def draw(what: str, size: float) -> dict[str, float]:
    """Draw one picture in this process: megabytes, seconds by the clock and of the processor."""
    from geosurf import Scene

    setting = make_setting("S1", size)
    for _, _, grid in setting.sources:
        for one in grid.data_vars.values() if hasattr(grid, "data_vars") else [grid]:
            one.values.flags.writeable = what != READ_ONLY
    scene = Scene(setting.by_role("horizon"), setting.by_role("fault"), setting.box)
    before, start, busy = resident()[0], time.perf_counter(), time.process_time()
    shown = {} if what in ("view", READ_ONLY) else {"show": ("units",), "exploded": 0.3}
    with tempfile.TemporaryDirectory() as folder:
        scene.plot.view(path=Path(folder) / "picture.png", **shown)
    return {
        "megabytes": resident()[1] - before,
        "seconds": time.perf_counter() - start,
        "busy": time.process_time() - busy,
    }


def main() -> None:
    """Print the table, or draw one picture of it."""
    if len(sys.argv) > 1:
        what = sys.argv[1]
        sys.modules["mypy"] = None  # type: ignore[assignment] # as if it were not installed
        sys.stdout.write(json.dumps(draw(what, PICTURES[what])))
        return
    sys.stdout.write("| picture | MB beyond grids | by the clock [s] | processor [s] | asked |\n")
    sys.stdout.write("|---|---|---|---|---|\n")
    for what, size in PICTURES.items():
        command = [sys.executable, "-m", "benchmarks.pictures", what]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        found = json.loads(said.splitlines()[-1])
        sys.stdout.write(
            f"| {what}, {size:g} triangles | {found['megabytes']:.0f} | {found['seconds']:.2f} "
            f"| {found['busy']:.2f} | {ASKED[what]} |\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
