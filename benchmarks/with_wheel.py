"""A benchmark with an installed wheel, as users have it.

``python -m benchmarks.with_wheel pictures`` draws the pictures of that benchmark, for example.
A wheel has kernels that are compiled already, and does not load numba. It is built first, which
takes minutes. Further words go to the benchmark: ``with_wheel ensembles throw --n 100``.
"""

from __future__ import annotations

import compileall
import os
import subprocess
import sys
from pathlib import Path

from benchmarks.installed import PACKAGE, installed


def main() -> int:
    """Run a benchmark in a folder where this package and the wheel's geosurf stand side by side."""
    if len(sys.argv) < 2:
        sys.stderr.write(f"{__doc__}\n")
        return 2
    found = installed()
    sys.stdout.write(f"geosurf: {found.words}\n")
    sys.stdout.flush()
    if not found.site:
        return 1
    beside = Path(found.site) / "benchmarks"
    beside.symlink_to(PACKAGE.parent / "benchmarks", target_is_directory=True)
    # the folder comes first for processes that a benchmark starts, too; bytecode is there, as after
    # an installation or a first run
    compileall.compile_dir(Path(found.site) / "geosurf", quiet=2)
    environment = dict(os.environ, PYTHONPATH=found.site)
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", f"benchmarks.{sys.argv[1]}", *sys.argv[2:]]
    return subprocess.run(command, cwd=found.site, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
