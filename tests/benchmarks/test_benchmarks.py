"""The benchmarks measure, judge and draw; what they say of right and wrong is checked here."""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict
from html.parser import HTMLParser
from types import SimpleNamespace

import numpy as np
import pytest

import benchmarks
from benchmarks import child, measure, peers, reached, targets, truth
from benchmarks.__main__ import main
from benchmarks.distance import distance_to_segments
from benchmarks.installed import Installed
from benchmarks.jobs import Result
from benchmarks.scenes import make_setting
from geosurf import Scene, intersect_surfaces, synthetic
from geosurf.cli.console import OUR_FAULT
from geosurf.synthetic.domes import _WAVY_BOX as WAVES_BOX
from geosurf.synthetic.domes import _east_of
from geosurf.synthetic.domes import _wavy_height as _height

pytestmark = pytest.mark.long

PNG = b"\x89PNG\r\n\x1a\n"


def here(jobs, *, core=None, limit=0.0):
    """As `run_jobs`, without processes."""
    return [Result(job, **child.measure(asdict(job))) for job in jobs]


@pytest.fixture
def without_processes(monkeypatch):
    monkeypatch.setattr(measure, "run_jobs", here)
    # clean heaps are for true times; here each costs a tenth of a second, dozens of times
    monkeypatch.setattr(child, "gc", SimpleNamespace(collect=int))
    monkeypatch.setattr(peers, "find_spec", lambda name: None)


# ---- the whole way -----------------------------------------------------------------------


class Links(HTMLParser):
    """Collects what a page loads."""

    def __init__(self) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.tables = 0

    def handle_starttag(self, tag, attrs):
        self.tables += tag == "div" and "wide" in dict(attrs).get("class", "").split()
        loads = (value for key, value in attrs if key in ("src", "href"))
        self.sources += [value for value in loads if not value.startswith("#")]


def test_quick_writes_all_files(without_processes, tmp_path, capsys):
    out = tmp_path / "new" / "folder"
    assert main(["--quick", "-o", str(out)]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "These times measure nothing" in said.out
    assert "WRONG" not in said.out
    found = json.loads((out / "bench.json").read_text())
    assert list(found["tables"]) == ["error", "growth", "questions"]
    assert found["wrong"] == []
    rows = [row for table in found["tables"].values() for row in table["rows"]]
    ours = [row for row in rows if row["who"] == "geosurf"]
    assert all(row["error"] == "" and row["wrong"] == [] and row["seconds"] > 0 for row in ours)
    others = {row["who"]: row["error"] for row in rows if row["who"] != "geosurf"}
    assert set(others) == {"compas_cgal", "vtk", "loop_cgal", "trueform", "manifold3d"}
    assert set(others.values()) == {"not installed: pip install -r benchmarks/requirements.txt"}
    assert "geosurf: curve" in found["tables"]["growth"]["exponents"]
    for name in ("error", "growth", "questions"):
        assert (out / f"bench_{name}.png").read_bytes().startswith(PNG)
    loaded = Links()
    loaded.feed((out / "bench.html").read_text())
    assert loaded.tables == 3
    assert len(loaded.sources) == 3
    assert all(source.startswith("data:image/png;base64,") for source in loaded.sources)


# ---- processes ---------------------------------------------------------------------------


# ---- right and wrong ---------------------------------------------------------------------


def test_distance_is_that_of_all_pairs(rng):
    for n, m in ((1, 1), (100, 3), (80, 300)):
        points = rng.normal(size=(n, 3)) * (50, 1, 1)
        walk = np.cumsum(rng.normal(size=(m + 1, 3)) * (2, 1, 1), axis=0)
        segments = np.stack([walk[:-1], walk[1:]], axis=1)
        segments[0, 1] = segments[0, 0]  # a segment without length
        slow = []
        for p in points:
            near = []
            for a, b in segments:
                d = b - a
                t = 0.0 if not d.any() else min(1.0, max(0.0, float((p - a) @ d / (d @ d))))
                near.append(math.dist(p, a + t * d))
            slow.append(min(near))
        np.testing.assert_allclose(distance_to_segments(points, segments), slow, rtol=1e-12)


@pytest.mark.parametrize("name", ["S1", "S2", "S1 shuffled", "waves", "20 faults", "block"])
def test_truth_and_engine_agree(name):
    setting = make_setting(name, 6000)
    known = measure.known_truth(name, 6000)
    found = child.measure(asdict(known))["answer"]
    curves = intersect_surfaces(setting.surfaces())
    assert len(curves.segments) == found["segments"] > 40
    assert curves.length == pytest.approx(found["length"], rel=1e-11)


def test_truth_knows_touching_planes():
    x = np.arange(5.0)
    through_nodes = np.array([[[2.0, -9.0, -1.0], [2.0, 9.0, -1.0], [2.0, 0.0, 9.0]]])
    height = np.random.default_rng(3).uniform(-0.2, 0.2, (5, 5))
    length, _ = truth.curve_of_grid(x, x, height, through_nodes + np.array([0.25, 0, 0]))
    profile = height[:, 2] + 0.25 * (height[:, 3] - height[:, 2])
    # cells are split from south-west to north-east: at 2.25 the diagonal is met a quarter up
    quarter = height[:-1, 2] + 0.25 * (height[1:, 3] - height[:-1, 2])
    steps = [*np.hypot(0.25, quarter - profile[:-1]), *np.hypot(0.75, profile[1:] - quarter)]
    assert length == pytest.approx(math.fsum(steps), rel=1e-12)


def test_a_wrong_answer_of_ours_ends_with_4(without_processes, monkeypatch, capsys, tmp_path):
    def wrong(jobs, **settings):
        results = here(jobs)
        for result in results:
            if result.job.task == "curve":
                result.answer["length"] += 1.0
        return results

    monkeypatch.setattr(measure, "run_jobs", wrong)
    arguments = ["--quick", "--quiet", "--only", "growth", "--size", "2e3"]
    assert main([*arguments, "-o", str(tmp_path)]) == OUR_FAULT
    assert re.search(r"benchmarks: S1 2e3: curve: length \d+\.\d+ m, true", capsys.readouterr().err)
    assert "WRONG" in (tmp_path / "bench.html").read_text()


# ---- peers ---------------------------------------------------------------------------------


# ---- targets -------------------------------------------------------------------------------


def test_targets_are_measured(without_processes, monkeypatch, capsys):
    """The rows with scenes of their own, at a hundredth of their size."""
    monkeypatch.setattr(reached, "installed", lambda: Installed("", "from sources"))
    names = ["parallel chords", "crossing chords", "cells", "memory", "start", "start from files"]
    found = benchmarks.run_bench(["targets"], targets=names, size=FULL / 400, quick=True)
    assert found["wrong"] == []
    rows = {row["name"]: row for row in found["tables"]["targets"]["rows"]}
    assert set(rows) == set(names)
    for row in rows.values():
        assert row["measured"][0]["seconds"] > 0
        assert row["measured"][0]["wrong"] == []
    assert rows["parallel chords"]["measured"][0]["answer"]["segments"] == 100
    assert rows["cells"]["measured"][0]["answer"]["units"] == 6
    assert "Target" in benchmarks.bench_text(found)
    assert rows["start"]["what"].endswith("curve of two triangles (from sources)")
    assert rows["start from files"]["measured"][0]["answer"]["bytes"] > 100
    assert rows["start from files"]["why"] == ""
    assert rows["memory"]["ratio"] >= 1.0


FULL = targets.FULL_SIZE


# ---- words, plots, worlds ------------------------------------------------------------------


def test_hills_are_cut_right_through():
    world = synthetic.hills(41, faults=3, horizons=2)
    scene = Scene(world.horizons, world.faults, world.box)
    assert scene.curves.n_curve == world.truth["n_curve"] == 6
    assert len(scene.units) == 3 * 4
    assert not scene.curves.closed.any()
    assert (
        synthetic.hills(9, noise=0)
        .horizons["H1"]
        .equals(synthetic.hills(9, noise=0).horizons["H1"])
    )
    gap = synthetic.hills(9, horizons=3, noise=10).horizons
    assert float((gap["H1"] - gap["H2"]).min()) > 190


def test_waves_truth_found_a_second_time():
    """The curve lies on both formulas; volumes by counting, the length by a polygon."""
    offset = (456_000.0, 6_780_000.0, -10.0)
    world = synthetic.waves(9, offset=offset)
    pair = ("Top", "F1")
    w, e, s, n, b, t = WAVES_BOX
    y = np.linspace(s, n, 20_001)
    curve = world.truth["curve_at"][pair](y + offset[1]) - offset
    np.testing.assert_allclose(curve[:, 2], _height(curve[:, 0], curve[:, 1]), atol=1e-8)
    np.testing.assert_allclose(curve[:, 0], _east_of(curve[:, 2], curve[:, 1]), atol=1e-8)
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1).sum()
    assert steps == pytest.approx(world.truth["curve_length"][pair], rel=1e-8)

    def centres(low, high, count):
        return low + (high - low) * (np.arange(count) + 0.5) / count

    x, y, z = np.meshgrid(centres(w, e, 160), centres(s, n, 120), centres(b, t, 180), indexing="ij")
    above, hanging = z > _height(x, y), x > _east_of(z, y)
    cell = (e - w) * (n - s) * (t - b) / x.size
    for (zone, (side,)), volume in world.truth["volumes"].items():
        inside = (above == (zone == "above Top")) & (hanging == (side == "F1+"))
        assert cell * inside.sum() == pytest.approx(volume, rel=2e-4)
