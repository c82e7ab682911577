"""Real fields by commands: from raw files to a certified model and its report, timed.

``python -m benchmarks.real_fields --data DATA --folder FOLDER`` runs each field of `FIELDS` in
FOLDER, where DATA appears as ``data``, and writes docs/validation/real_fields.md. Each question
that ``geosurf new`` asks is answered in a further run, if ``--answers`` is given.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

PAGE = Path(__file__).parents[1] / "docs" / "validation" / "real_fields.md"

HEAD = """\
# Real fields by commands

Four fields as their files were exported, from raw files to a certified model and its report, by two
commands each. No scenario was written or edited by hand.

**Command.** `python -m benchmarks.real_fields --data DATA --folder FOLDER --answers` writes this
page. DATA has the folders `drogon`, `drogon_xtgeo` and `reek`.

**Last result** ({day}): two cores, {state}; kernels compiled before.

Drogon and Reek are synthetic teaching fields of Equinor, made with real workflows. They are not
part of this repository. The export is that of [your field in 20 lines](../guides/your_field.md).

- *Questions* are asked by `geosurf new` as comments of the scenario, each with the keys that
  answer it. None stops a run.
- *Inside* is the share of the area that the data of all horizons cover which is inside the model,
  at 200 000 random places. Data cover the Delaunay triangles of their positions without edges of
  more than three spacings.
- No truth is known for Drogon and Reek. A valid certificate says that the model is sealed and
  consistent, not that throws are right. Volumes of the three exports are within 0.1 % of the truth
  (`tests/scenario/test_new.py`).
"""

ANSWERED = """\
What `geosurf new` asks as a comment, uncommented: one question in each run, that about "these
faults" with the one before it. With `--cache-dir`, what stays comes from the
run before."""

# name, folder, what `geosurf new` gets
FIELDS = (
    ("Drogon, points", "drogon_points", "data/drogon"),
    ("Drogon, grids", "drogon_grids", "data/drogon_xtgeo data/drogon/fault_sticks_pol"),
    ("Reek", "reek", "data/reek"),
    ("export, grids", "export", "--example"),
    ("export, points", "export_points", "--example points"),
    ("export, network", "export_network", "--example network"),
)
LIMIT = 600  # seconds of processor for a run with an answer
COLUMNS = ("field", "first attempt", "units", "certificate", "questions", "inside [%]", "new [s]",
           "run [s]", "processor [s]", "memory [MB]")  # fmt: skip
SAMPLES = 200_000  # places at which coverage is measured
GAP = 3.0  # triangles of data with longer edges, in spacings of the data, are gaps


@dataclass
class Done:
    """One command: what it printed, seconds of the clock and the processor, and memory [MB]."""

    command: str
    code: int
    lines: list[str]
    wall: float
    processor: float
    memory: float


@dataclass
class Row:
    """One field: its commands, the share of the shared area that is inside, answered questions."""

    name: str
    commands: list[Done]
    coverage: float = np.nan
    answers: list[tuple[str, Done]] = field(default_factory=list)

    @property
    def run(self) -> Done:
        """The command that builds the model."""
        return self.commands[-1]


def done(command: str, folder: Path, limit: int | None = None) -> Done:
    """Run ``geosurf ...`` in a folder, in a process of its own with some seconds of processor."""

    def limited() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))

    words = [sys.executable, "-m", "geosurf", *shlex.split(command)[1:]]
    start = time.perf_counter()
    with (folder / "console.txt").open("w+") as console:
        child = subprocess.Popen(
            words, cwd=folder, stdout=console, stderr=subprocess.STDOUT,
            env={**os.environ, "PYTHONUNBUFFERED": "1"}, preexec_fn=limited,
        )  # fmt: skip
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        console.seek(0)
        lines = console.read().splitlines()
    wall, processor = time.perf_counter() - start, used.ru_utime + used.ru_stime
    memory = used.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    return Done(command, child.returncode, lines, wall, processor, memory)


def field_of(name: str, at: str, files: str, folder: Path, answers: bool) -> Row:
    """Run the commands of one field."""
    cache = f" --cache-dir {at}/cache" if answers else ""
    run = f"geosurf run {at}/scenario.toml -o {at}/out{cache}"
    row = Row(name, [done(f"geosurf new {at} {files}", folder)])
    if row.run.code != 0:  # also where an earlier run has left a scenario
        raise SystemExit("\n".join(row.run.lines))
    row.commands.append(done(run, folder))
    if row.run.code == 0:
        row.coverage = coverage_apart(folder / at / "scenario.toml")
    text = (folder / at / "scenario.toml").read_text(encoding="utf-8")
    for k, question in enumerate(re.findall(r"# QUESTION: (.*)", text) if answers else []):
        path = folder / at / f"answer_{k}.toml"
        path.write_text(answered(text, k), encoding="utf-8")
        answer = done(f"geosurf run {at}/{path.name} -o {at}/out_{k}{cache}", folder, LIMIT)
        row.answers.append((question, answer))
    return row


def answered(text: str, which: int) -> str:
    r"""The scenario with the lines below one question as keys.

    A question about "these faults" counts on the one before it, which has them.

    Examples
    --------
    >>> print(answered("# QUESTION: depth?\n# positive = 1\n\n# a note", 0))
    # QUESTION: depth?
    positive = 1
    <BLANKLINE>
    # a note
    """
    questions = re.findall(r"# QUESTION: (.*)", text)
    wanted = {which, which - questions[which].startswith("do these faults")}
    lines, number, inside = [], -1, False
    for line in text.split("\n"):
        asks = line.startswith("# QUESTION: ")
        number += asks
        inside = asks or (inside and line.startswith("# "))
        lines.append(line[2:] if inside and not asks and number in wanted else line)
    return "\n".join(lines)


def coverage_apart(path: Path) -> float:
    """`coverage` in a process of its own: the memory of this one counts for those it starts."""
    words = [sys.executable, "-m", "benchmarks.real_fields", "--covered", str(path)]
    return float(subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout)


def coverage(path: Path) -> float:
    """Share of the area that the data of all horizons cover which is inside the model.

    Data cover the Delaunay triangles of their positions without long edges; the area of the model
    is that of its outline, as `geosurf run` has it.
    """
    from matplotlib.path import Path as Ring

    from geosurf.scenario import read_scenario
    from geosurf.scenario.build import build_scene
    from geosurf.scene.given import given_horizon

    scene = build_scene(read_scenario(path))
    clouds = [_positions(given_horizon(scene, name)[0]) for name in scene.horizon_names]
    low = np.max([c.min(axis=0) for c in clouds], axis=0)
    high = np.min([c.max(axis=0) for c in clouds], axis=0)
    at = np.random.default_rng(0).uniform(low, high, (SAMPLES, 2))
    for cloud in clouds:
        at = at[_covered(cloud, at)]
    west, east, south, north = scene.box[:4]
    box = np.array([[west, south], [east, south], [east, north], [west, north]])
    outline = box if scene.aoi is None else scene.aoi
    return float(Ring(outline).contains_points(at).mean())


def _positions(data: Any) -> np.ndarray:
    """Different positions (n, 2) of the nodes or points of a horizon that have a value [m]."""
    if hasattr(data, "vertices"):
        return np.unique(data.vertices[:, :2], axis=0)
    z = data.elevation if hasattr(data, "data_vars") else data
    x, y = data.easting.values, data.northing.values
    # axes become the coordinates of all nodes
    if x.ndim == 1 and z.ndim == 2:
        x, y = np.meshgrid(x, y)
    points = np.column_stack([np.ravel(part) for part in (x, y, z.values)])
    return np.unique(points[np.isfinite(points).all(axis=1), :2], axis=0)


def _covered(cloud: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Whether data lie around some places (n, 2)."""
    from matplotlib.tri import Triangulation
    from scipy.spatial import Delaunay, cKDTree

    spacing = np.median(cKDTree(cloud).query(cloud, k=2)[0][:, 1])
    middle = cloud.mean(axis=0)
    mesh = Delaunay(cloud - middle)
    corners = mesh.points[mesh.simplices]
    edges = corners - np.roll(corners, 1, axis=1)
    short = np.linalg.norm(edges, axis=2).max(axis=1) < GAP * spacing
    # three nodes along a rim make a triangle without area
    (x, y), (u, v) = edges[:, 0].T, edges[:, 1].T
    solid = np.abs(x * v - y * u) > 1e-6 * spacing**2
    # trapezoids: `Delaunay.find_simplex` takes minutes on nodes of a rotated grid
    find = Triangulation(*mesh.points.T, mesh.simplices[short & solid]).get_trifinder()
    covered: np.ndarray = find(*(at - middle).T) >= 0
    return covered


# ---------------------------------------------------------------------- the page
def page_of(rows: list[Row], state: str) -> str:
    """The page of docs/validation."""
    today = date.today()
    head = HEAD.format(day=f"{today.day} {today:%B %Y}", state=state)
    lines = [head.rstrip(), "", "## Commands", "", "```sh"]
    lines += [one.command for row in rows for one in row.commands]
    lines += ["```", "", "## Results", "", _line(*COLUMNS), _line(*["---"] * len(COLUMNS))]
    for row in rows:
        text = "\n".join(row.run.lines)
        units = re.search(r"^(\d+) units in", text, re.M)
        valid = re.search(r"^check +certificate +(\w+)", text, re.M)
        asked = sum("(optional):" in line for line in row.commands[0].lines)
        lines.append(_line(
            row.name, "yes" if row.run.code == 0 else f"no, exit code {row.run.code}",
            units[1] if units else "", valid[1] if valid else "", asked,
            f"{100 * row.coverage:.1f}", *(f"{one.wall:.0f}" for one in row.commands),
            f"{row.run.processor:.0f}", f"{row.run.memory:.0f}",
        ))  # fmt: skip
    if any(row.answers for row in rows):
        lines += ["", "## Each question answered", "", ANSWERED, ""]
        lines += [_line("field", "question", "built", "units", "processor [s]")]
        lines += [_line(*["---"] * 5)]
    for row in rows:
        for question, one in row.answers:
            units = re.search(r"^(\d+) units in", "\n".join(one.lines), re.M)
            built = "yes" if one.code == 0 else f"no: {max(one.lines[-2:], key=len)}"
            built = built if one.code >= 0 else f"stopped after {LIMIT} s"
            lines.append(_line(row.name, question, built, units[1] if units else "",
                               f"{one.processor:.0f}"))  # fmt: skip
    return "\n".join(lines) + "\n"


def _line(*words: object) -> str:
    return f"| {' | '.join(map(str, words))} |"


def main() -> None:
    """Run the fields, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, help="the folder with drogon, reek ...")
    parser.add_argument("--folder", type=Path, help="an empty one, for results")
    parser.add_argument("--covered", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--field", nargs="*", help="only these, by their folder")
    parser.add_argument("--answers", action="store_true", help="answer each question, one by one")
    parser.add_argument("--state", default="nothing else running", help="of the machine")
    asked = parser.parse_args()
    if asked.covered:
        print(coverage(asked.covered))
        return
    if asked.data is None or asked.folder is None:
        parser.error("give --data and --folder")
    asked.folder.mkdir(parents=True, exist_ok=True)
    link = asked.folder / "data"
    if not link.exists():
        link.symlink_to(asked.data.resolve(), target_is_directory=True)
    rows = []
    for name, at, files in FIELDS:
        if not asked.field or at in asked.field:
            rows.append(field_of(name, at, files, asked.folder, asked.answers))
            one = rows[-1].run
            print(f"{name}: exit code {one.code}, {one.wall:.0f} s, {one.memory:.0f} MB, "
                  f"{100 * rows[-1].coverage:.2f} % inside", flush=True)  # fmt: skip
            for question, answer in rows[-1].answers:
                print(f"  {answer.code}: {question}", flush=True)
    if not asked.field:
        PAGE.write_text(page_of(rows, asked.state), encoding="utf-8")


if __name__ == "__main__":
    main()
