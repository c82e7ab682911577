"""What all tests share: the data folder beside the checkout, seeds, hypothesis profiles."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

# A run starts about two hundred processes. Without cached bytecode each of them compiles geosurf's
# sources again, and each worker the tests' (50 s of processor together).
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# No test cuts the power: to wait for the disk at each file would take a tenth of a run.
os.fsync = lambda handle: None

# The first example may compile a kernel, so no example has a deadline of its own.
settings.register_profile("quick", max_examples=20, deadline=None, derandomize=True)
settings.register_profile("thorough", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("GEOSURF_HYPOTHESIS", "quick"))

gc.disable()  # while modules are loaded there is no garbage


def pytest_collection_finish() -> None:
    """What is loaded now stays: garbage is looked for among what the tests make, and seldom."""
    gc.freeze()
    gc.set_threshold(20_000)
    gc.enable()


def scene_of(world: Any) -> Any:
    """The scene of a synthetic world."""
    import geosurf as gs

    return gs.Scene(world.horizons, world.faults, world.box)


@pytest.fixture(scope="session")
def planes() -> Any:
    """Two tilted planes and a fault."""
    from geosurf import synthetic

    return scene_of(synthetic.tilted_planes(n=9))


@pytest.fixture(scope="session")
def graben() -> Any:
    """Three horizons and two faults."""
    from geosurf import synthetic

    return scene_of(synthetic.graben(n=9))


@pytest.fixture(scope="session")
def export(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Any]:
    """The exported field in one of its variants, each written when a test first needs it."""
    from geosurf.synthetic import field_export

    folder = tmp_path_factory.mktemp("exports")
    return cache(lambda variant: field_export(folder / variant, variant))


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder of inputs that nobody here wrote; tests that need it are skipped without it."""
    folder = Path(os.environ.get("GEOSURF_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip("needs the shared data folder beside the checkout")
    return folder


@pytest.fixture(scope="session")
def drogon_sticks(shared: Path) -> dict[str, Any]:
    """Sticks of the faults of the Drogon field, by name."""
    import geosurf as gs

    return {
        path.stem: gs.read_fault(path, positive="down", length_unit="m")
        for path in sorted((shared / "data" / "drogon" / "fault_sticks_pol").glob("F*.pol"))
    }


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(1997)
