"""Python in a process of its own, with what it says."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


def run_python(*words: Any, without: tuple[str, ...] = (), said: str = "", **more: str) -> Any:
    """Run Python with some words; the environment has more variables, and some not at all."""
    environment = {k: v for k, v in os.environ.items() if k not in without} | more
    return subprocess.run(
        [sys.executable, *map(str, words)], input=said, cwd=ROOT, env=environment,
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip


def told_by(*words: Any, **more: Any) -> str:
    """What Python prints; an error, with what it says, if it fails."""
    done = run_python(*words, **more)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout
