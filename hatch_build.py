"""Build hook of hatchling: a wheel carries its kernels as machine code, where that can be made.

On a platform that geosurf/kernels/compile/platforms.py knows, with a C compiler: a wheel such as
``py3-none-linux_x86_64``, one for every Python, with a library that needs no numba at run time.
GEOSURF_PLATFORM names one of these platforms, whatever this machine is: zig is the compiler then.
On other platforms, or with GEOSURF_PURE=1: the pure wheel ``py3-none-any``, which compiles its
kernels when they are first called. A freeze that *fails* is an error and never a pure wheel.
Editable installs have no library, so that what is edited is run.

Numba, llvmlite, numpy and zig are pinned for the build to what constraints.txt says.
"""

from __future__ import annotations

import os
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NEEDED = ("numba", "llvmlite", "numpy")
LINKER = "ziglang"  # where another platform is named, and on Windows, which has no C compiler
NOT_HERE = 3  # exit code of the freezer where kernels cannot be frozen; others are failures
INSIDE = "geosurf/kernels/frozen"
PLATFORMS = "geosurf/kernels/compile/platforms.py"


class FrozenKernels(BuildHookInterface):
    """Freezes the kernels into the wheel."""

    PLUGIN_NAME = "custom"

    def dependencies(self) -> list[str]:
        """What the build needs beside hatchling: nothing for a pure wheel."""
        if self._pure():
            return []
        needed = {*NEEDED}
        if self._named() or sys.platform == "win32":
            needed.add(LINKER)
        pins = (Path(self.root) / "constraints.txt").read_text(encoding="utf-8").split()
        return [pin for pin in pins if re.split("==", pin)[0] in needed]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Freeze, and tell hatchling what to put where under which tag."""
        self._scratch: str | None = None
        if self.target_name != "wheel" or version == "editable":
            return
        if self._pure():
            why = f"there are no frozen kernels for {self._platform()}"
            self._say(f"GEOSURF_PURE is set, or {why}: a pure wheel.")
            return
        self._scratch = tempfile.mkdtemp()
        self._say("freezing the kernels, one to two minutes ...")
        if not self._freeze(Path(self._scratch)):
            return
        build_data["pure_python"] = False
        tag = self._known()["PLATFORMS"][self._platform()].wheel_tag
        build_data["tag"] = f"py3-none-{tag}"
        for file in sorted(Path(self._scratch).iterdir()):
            build_data["force_include"][str(file)] = f"{INSIDE}/{file.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what is in the wheel now."""
        if self._scratch is not None:
            shutil.rmtree(self._scratch)

    def _pure(self) -> bool:
        if os.environ.get("GEOSURF_PURE", "") not in ("", "0"):
            return True
        known = self._known()["PLATFORMS"]
        if self._named() and self._platform() not in known:
            raise ValueError(
                f"GEOSURF_PLATFORM={self._named()} is unknown; known are {', '.join(known)}."
            )
        return self._platform() not in known

    def _named(self) -> str:
        return os.environ.get("GEOSURF_PLATFORM", "")

    def _platform(self) -> str:
        return self._named() or str(self._known()["platform_name"]())

    def _known(self) -> dict[str, Any]:
        """What the freezer knows of platforms; geosurf itself cannot be imported here."""
        return runpy.run_path(str(Path(self.root) / PLATFORMS))

    def _freeze(self, out: Path) -> bool:
        """Let the freezer run on these sources; return whether there is a library now.

        They are found because they are in its working folder: where this checkout is installed
        as editable, too, pip's isolated environment strikes it from the paths.
        """
        named = ["--platform", self._named()] if self._named() else []
        done = subprocess.run(
            [sys.executable, "-m", "geosurf.kernels.compile.freeze", "--out", str(out), *named],
            cwd=self.root,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode == NOT_HERE:
            self._say(f"{done.stderr.strip()} A pure wheel.")
            return False
        if done.returncode:
            raise RuntimeError(
                f"the kernels could not be frozen; GEOSURF_PURE=1 builds without.\n{done.stderr}"
            )
        self._say(done.stdout.strip())
        return True

    def _say(self, sentence: str) -> None:
        self.app.display_info(f"geosurf: {sentence}")
