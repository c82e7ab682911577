"""`cache_dir`: a second run gives the same files and redoes only what changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from geosurf.scenario import read_scenario, run
from geosurf.scene import pictures as drawing
from geosurf.sheets import tear
from tests.planes import INPUTS, write_grids

OUTPUT = """
[output]
views = []
exploded = false
thickness = false
allan = false
sections_m = []
size_px = [300, 200]
formats = ["csv", "vtm"]
[tear]
trim_cells = 1.5
[[contacts]]
name = "OWC"
elevation_m = -2050.0
"""
TITLE = 'title = "Planes"\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("inputs")
    write_grids(path)
    return path


def files(out: Path) -> dict[str, bytes]:
    """All results but the page, which has the log of the run and its pictures."""
    return {
        path.relative_to(out).as_posix(): path.read_bytes()
        for path in sorted(out.rglob("*"))
        if path.is_file() and path.suffix != ".html"
    }


def test_a_second_run_redoes_only_what_changed(folder, tmp_path, monkeypatch):
    counts = {"tear": 0, "draw": 0}

    def counting(name, function):
        def counted(*args, **words):
            counts[name] += 1
            return function(*args, **words)

        return counted

    monkeypatch.setattr(tear, "tear_from", counting("tear", tear.tear_from))
    monkeypatch.setattr(drawing, "render_map", counting("draw", drawing.render_map))

    def results(body: str, cache: Path | None) -> tuple[dict[str, bytes], int, int]:
        """Files of one run, how many horizons it tore and how many pictures it drew."""
        counts.update(tear=0, draw=0)
        (folder / "scenario.toml").write_text(body)
        out = tmp_path / "out"
        assert run(read_scenario(folder / "scenario.toml"), out, cache_dir=cache).certificate.ok
        return files(out), counts["tear"], counts["draw"]

    base, cache = TITLE + INPUTS + OUTPUT, tmp_path / "cache"
    plain = results(base, None)
    assert plain[1:] == (2, 2)
    assert results(base, cache) == plain
    assert results(base, cache) == (plain[0], 0, 0)

    # another contact: horizons stay, pictures show it
    moved = base.replace("-2050.0", "-2040.0")
    assert results(moved, cache) == (results(moved, None)[0], 0, 2)

    # a title is in no picture
    retitled = results(base.replace("Planes", "Ramps"), cache)
    assert retitled[1:] == (0, 0)
    assert retitled[0]["pictures/map_00_Top.png"] == plain[0]["pictures/map_00_Top.png"]
