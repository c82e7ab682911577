"""Scenarios in a folder with the grids that they name."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from tests.planes import write_grids
from tests.scenario.tilted_planes import BODY


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the grids of a small world."""
    folder = tmp_path_factory.mktemp("inputs")
    write_grids(folder)
    return folder


@pytest.fixture(scope="module")
def scenario(inputs: Path):
    """A function that writes a scenario, with words exchanged, beside the grids."""

    def make(*changes: tuple[str, str], body: str = BODY) -> Path:
        for old, new in changes:
            assert old in body
            body = body.replace(old, new)
        path = inputs / f"{hashlib.sha256(body.encode()).hexdigest()[:12]}.toml"
        path.write_text(body, encoding="utf-8")
        return path

    return make
