"""Planted mistakes, and which test kills each: ``python -m tests.mutants [-k WORD] [--whole]``.

Every row plants one mistake into a copy of the project, in code that decides answers on real
fields, and runs the tests named there until one fails. A mistake that survives is a gap in the
tests: write a law that kills it, do not drop the row. A text must occur once in its room, wherever
files move to; ``--list`` says which rows no longer fit.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SAME = "tests/same_model"


class Mutant(NamedTuple):
    """One mistake: a room of geosurf, a text that occurs once in it, what it becomes, tests."""

    room: str
    text: str
    wrong: str
    tests: str


MUTANTS = (
    # ---- measures
    Mutant("measure", "np.divide(far[0], wide, out=", "np.divide(far[1], wide, out=", "tests/measure"),
    Mutant("measure", "throw, heave = zf - zh,", "throw, heave = zh - zf,", "tests/measure"),
    Mutant("measure", "np.copysign(np.hypot(dh - df, sh - sf), dh - df)", "np.hypot(dh - df, sh - sf)", "tests/measure"),
    Mutant("measure", '"gap" if area > 0 else "overlap"', '"gap" if area < 0 else "overlap"', "tests/measure"),
    Mutant("measure", '"misfit": model - picked', '"misfit": picked - model', "tests/measure"),
    Mutant("measure", "keep[1:] = np.diff(length) > 0", "keep[1:] = np.cumprod(np.diff(length) > 0) > 0", f"{SAME} tests/measure"),
    Mutant("measure", '"strike": (azimuth - 90.0) % 360.0', '"strike": (azimuth + 90.0) % 360.0', "tests/measure"),
    Mutant("measure", "up = vectors[:, 2] < 0", "up = vectors[:, 2] > 0", "tests/measure"),
    Mutant("measure", "for k, unit in enumerate(chosen) if unit.block == block]", "for k, unit in enumerate(chosen) if block in unit.block]", f"{SAME} tests/measure"),
    Mutant("measure", "for u, p in zip(chosen, passages_of, strict=True) if u.block == block]", "for u, p in zip(chosen, passages_of, strict=True)]", f"{SAME} tests/measure"),
    Mutant("measure", "for k in (2, 1))", "for k in (1, 1))", "tests/measure"),
    Mutant("measure", "lambda sw: 1.0 - sw", "lambda sw: sw", "tests/measure"),
    Mutant("kernels/meshes", "while high - low > 1:", "while high - low > 2:", SAME),
    # ---- carving
    Mutant("carve", "return zone in zones and sides <= set(on)", "return sides <= set(on)", f"tests/carve {SAME}"),
    Mutant("carve", "_fits(contact.zones or reservoir, wanted[row], zone, on)", "_fits(contact.zones or zones, wanted[row], zone, on)", "tests/scene"),
    Mutant("carve", "return tuple(zones[1:-1] or zones)", "return tuple(zones[:-1] or zones)", "tests/scene"),
    Mutant("carve", "if first != second and alike:", "if first != second:", "tests/scene/test_regions.py"),
    Mutant("carve", "remnants = tuple(blocks[k] for k in rows if before[k] != region)", "remnants = ()", "tests/scene/test_regions.py"),
    Mutant("measure", "if inside[k] > 0.5 * whole[k]]", "if inside[k] > 0.0]", "tests/scene/test_regions.py"),
    Mutant("model", "key=lambda at: (-shared[at],", "key=lambda at: (shared[at],", "tests/scene/test_regions.py"),
    Mutant("carve", "min(shared, key=lambda v: (-shared[v], rank[v]))", "min(shared, key=lambda v: (shared[v], rank[v]))", "geosurf/carve tests/carve"),
    Mutant("carve", "first = sum(level > highest for level in levels)", "first = sum(level < lowest for level in levels)", "tests/carve tests/scene"),
    Mutant("carve", "sign = np.where(shells.sides[rows, 1] == split.row, 1.0, -1.0)", "sign = np.where(shells.sides[rows, 1] == split.row, 1.0, 1.0)", "tests/carve tests/scene"),
    Mutant("carve", "sums[rows[~outward], LOOKS_DOWN]", "sums[rows[~outward], LOOKS_UP]", "tests/carve tests/scene"),
    Mutant("carve", "<= VOLUME_TOLERANCE and not off and not moved", "<= VOLUME_TOLERANCE and not moved", "tests/carve"),
    Mutant("carve", "for name in sizes if sizes[name].volume <= 0.0]", "for name in sizes if sizes[name].volume < -1e99]", "tests/carve"),
    Mutant("carve", "if stated[k] != recomputed[k]:", "if False:", "tests/carve"),
    Mutant("carve", "if abs(math.fsum(parts) - unit.volume) > slack:", "if False:", "tests/carve"),
    Mutant("measure", "(upper.zone, upper.block) == (lower.zone, lower.block)", "upper.zone == lower.zone", "tests/measure"),
    # ---- arrangement, curves, rebuilt surfaces
    Mutant("rebuild", "thin = np.union1d(thin, np.flatnonzero(at_moved))", "pass", "tests/rebuild/test_crossings.py"),
    Mutant("rebuild", "if len(thin) == 0 and len(near) == 0:", "if len(thin) == 0:", "tests/rebuild"),
    Mutant("arrangement", "for j in range(i, n) if i < j or with_itself[i]]", "for j in range(i, n) if i < j]", "tests/arrangement tests/intersect tests/scene"),
    Mutant("kernels/search", "change = -uy * push[0]", "change = uy * push[0]", "tests/measure/test_thickness.py"),
    Mutant("kernels/search", "turns[k] = _MIXED if side == 0 or side == -turns[k] else side", "turns[k] = _MIXED if side == 0 else side", "tests/kernels/test_separation.py"),
    Mutant("kernels/search", "if t[half // 3, half % 3] == t[i, k]:", "if False:", "tests/kernels/test_separation.py"),
    Mutant("kernels/search", "if surface[half // 3] == surface[i]:", "if True:", "tests/kernels/test_separation.py"),
    Mutant("arrangement", "return not len(crossing_pairs(flat,", "return True or (crossing_pairs(flat,", "tests/kernels/test_separation.py"),
    Mutant("carve", "np.where(nodes.reshape(z.shape), np.nan, z)", "np.full(z.shape, np.nan)", "tests/carve"),
    Mutant("carve", "if k != lattices[i].surface and not far[i, n + k]", "if False", "tests/carve"),
    Mutant("carve", "tasks.append((i, copies.tree))", "pass", "tests/carve tests/model"),
    Mutant("carve", "(first, second) for q, (j, second) in enumerate(every[:p]) if i != j and not far[p, q]", "(first, second) for q, (j, second) in enumerate(every[:p]) if i > 0 < j and i != j and not far[p, q]", "tests/carve"),
    Mutant("carve", "tasks = [(group_of(x, t, facts.copies_of(i)), group) for i, group in in_runs]", "tasks = []", "tests/carve tests/model"),
    Mutant("intersect", "(n_corners(contacts.rows) >= 3)", "(n_corners(contacts.rows) > 3)", "tests/intersect"),
    # ---- faults
    Mutant("faults", 'return 1 if keep == "+" else -1', 'return -1 if keep == "+" else 1', "tests/faults"),
    Mutant("faults", "front = c_before_b == (way_m[a] > 0)", "front = c_before_b != (way_m[a] > 0)", "tests/faults"),
    Mutant("faults", "ready = [f for f in left if not any(r.main in left for r in rules[f])]", "ready = list(left)", "tests/faults tests/scene"),
    Mutant("faults", "is_own = apart or (gone", "is_own = (gone", "tests/faults/test_extend.py"),
    # ---- ensembles
    Mutant("ensemble", 'n = int((self.group["status"][:] == 1).sum())', 'n = int((self.group["status"][:] != 0).sum())', "tests/ensemble/test_results.py"),
    Mutant("ensemble", "variance = (total[1] - n * mean * mean) / max(n - 1, 1)", "variance = (total[1] - n * mean * mean) / max(n, 1)", "tests/ensemble"),
    Mutant("ensemble", "rows = np.flatnonzero(self.data.status.values == 1)", "rows = np.flatnonzero(self.data.status.values >= 0)", "tests/ensemble"),
    Mutant("ensemble", "values = result[AREA].values[result.status.values == 1]", "values = result[AREA].values", "tests/ensemble/test_results.py"),
    Mutant("ensemble", "points[..., 2] = middle[2] - sine * offset + cosine * height", "points[..., 2] = middle[2] + sine * offset + cosine * height", "tests/ensemble"),
    Mutant("ensemble", "return float(old) + level", "return float(old) - level", "tests/ensemble"),
    Mutant("model", "made = throw * factor", "made = throw", "tests/ensemble"),
    Mutant("ensemble", "return 0.25 * total", "return 0.5 * total", "tests/ensemble"),
    # ---- torn horizons
    Mutant("sheets", "signal = max((double - single) / 63.0, 0.0)", "signal = max((double - single) / 1.1, 0.0)", f"tests/sheets {SAME}"),
    Mutant("sheets", "return z_minus - z_plus, t_plus - t_minus", "return z_plus - z_minus, t_plus - t_minus", "tests/sheets"),
    Mutant("sheets", "throws.append(heights[1] - heights[0])", "throws.append(heights[0] - heights[1])", "tests/sheets/test_propose_trim.py"),
    Mutant("sheets", "blocked = np.bincount(key, near_other[in_strip]", "blocked = np.bincount(key, 0.0 * near_other[in_strip]", "tests/sheets/test_propose_trim.py"),
    Mutant("sheets", "or own <= common - NARROWER)", ")", "tests/sheets/test_propose_trim.py"),
    Mutant("sheets", "lost = abs(whole - along) * frame.cell", "lost = abs(whole - along)", "tests/sheets"),
    Mutant("sheets", "where=off < half) ** 2", "where=off < half)", "tests/sheets"),
    Mutant("sheets", "apart = sides[chunk, None] * sides[around] < 0", "apart = sides[chunk, None] * sides[around] < -9", "tests/sheets"),
    Mutant("sheets", "(np.abs(off) > np.abs(beyond)) & ", "", "tests/sheets"),
    Mutant("sheets", "close = [] if ahead.goes_on(grid", "close = [np.nan] if ahead.goes_on(grid", "tests/sheets"),
    Mutant("sheets", "steps[1 - first] = np.median(across", "steps[1 - first] = 2.0 * np.median(across", "tests/sheets"),
    Mutant("scene", 'named |= {(key,) for key in changes}', 'named |= {*changes}', "tests/scene"),
    Mutant("sheets", "number = (far / BIN).astype(np.int64)", "number = (0.0 * far).astype(np.int64)", "tests/sheets"),
    # ---- inputs as surfaces
    Mutant("triangulate", "return elevation_sign(positive, what) * metres_per_unit(length_unit, what)", "return elevation_sign(positive, what)", "tests/read tests/triangulate"),
    Mutant("triangulate", "bottom - margin, top + margin)", "bottom + margin, top + margin)", "tests/triangulate tests/scene"),
    Mutant("conventions", "float(factors[-1])", "float(factors[0])", "tests/scene"),
    Mutant("triangulate", "line = line[np.r_[True, (np.diff(line, axis=0) != 0).any(axis=1)]]", "line = line[np.r_[True, (np.diff(line, axis=0) != 0).all(axis=1)]]", "tests/triangulate tests/read"),
    Mutant("conventions", "are_same(crs, known) is False:", "are_same(crs, known) is None:", "tests/conventions tests/scene"),
    # ---- readers and writers
    Mutant("read", 'others["md"] = ("point", abs(scale) * depths', 'others["md"] = ("point", depths', "tests/read"),
    Mutant("read", "scale * _finite_or_nan(path, data)", "np.sign(scale) * _finite_or_nan(path, data)", "tests/read"),
    Mutant("read", 'half_x = 0.5 * dx if "xllcorner" in keys_read else 0.0', "half_x = 0.0", "tests/read"),
    Mutant("read", 'values[key] *= agreed_scale(unit, request.length_unit, "m", what)', "pass", "tests/read/test_lengths.py"),
    Mutant("read", "depths = md[piece] + share * length[piece]", "depths = md[piece] + share", "tests/read"),
    Mutant("read", 'warn_of_end(self.path, n_line + waiting.count("\\n"), last)', "pass", "tests/read/test_odd_files.py"),
    Mutant("read", 'above = max(float(values["datum"][at[0]] - points[at[0], 2]), 0.0)', "above = 0.0", "tests/read/test_odd_files.py"),
    Mutant("measure", "(np.nan if len(points) and points[0, 2] < 0.0 else 0.0)", "0.0", "tests/measure/test_sample.py"),
    Mutant("measure", "return int(off.argmax())", "return len(points) // 2 if len(points) < 4 else 0", "tests/measure/test_section.py"),
    Mutant("scene", "return None if strangers else content", "return content", "tests/model/test_copies.py"),
    Mutant("sheets", "picks.nodes_of(rows)]) * side[rows]", "picks.nodes_of(rows)])", "tests/sheets/test_propose_trim.py"),
    Mutant("sheets", "pairs = pairs[~_near_holes(band, pairs[:, 0], holes)]", "pairs = pairs[:0]", "tests/sheets/test_junctions.py"),
    Mutant("write", "columns = grid.values[::-1].T", "columns = grid.values.T", "tests/write"),
    Mutant("write", "first=n_written + 1)", "first=1)", "tests/write tests/read/test_lines.py"),
    # ---- grids for simulators, tetrahedra
    Mutant("grid", 'return from_top if self.parallel == "top" else thickness - from_top[::-1]', "return from_top", "tests/grid"),
    Mutant("grid", "return (odd % 2 == 1).reshape(z.shape)", "return (odd > 0).reshape(z.shape)", "tests/grid"),
    Mutant("tetrahedra", "> 1.0 - BEND", "> -2.0 - BEND", "tests/tetrahedra"),
    # ---- scenes and scenarios
    Mutant("scene", "rules, fluids, self.inputs.slivers, self.reservoir)", "rules, fluids, self.reservoir)", SAME),
    Mutant("scene", "rules, fluids, self.inputs.slivers, self.reservoir)", "rules, fluids, self.inputs.slivers)", SAME),
    Mutant("scene", "ring = None if self.aoi is None else self.aoi.tobytes()", "ring = None", f"{SAME} tests/scene"),
    Mutant("scene", "options = self.inputs.voxel_size, self.inputs.self_intersections", "options = (self.inputs.voxel_size,)", f"{SAME} tests/scene"),
    Mutant("scene", "or inputs.compartments or inputs.slivers.merge:", "or inputs.compartments:", "tests/carve"),
    Mutant("scene", 'n_axis = 2 if surface.role == "horizon" else 3', "n_axis = 2", "tests/scene"),
    Mutant("scenario", "return rings[entry.polygon - 1]", "return rings[0]", "tests/scenario"),
    Mutant("scenario", "return parts[number - 1].renamed(", "return parts[0].renamed(", "tests/scenario"),
)  # fmt: skip


def found(mutant: Mutant) -> Path | None:
    """The file of geosurf, relative to the project, that holds the text once; None if none does."""
    held = [
        path.relative_to(ROOT)
        for path in sorted((ROOT / "geosurf" / mutant.room).rglob("*.py"))
        for _ in range(path.read_text(encoding="utf-8").count(mutant.text))
    ]
    return held[0] if len(held) == 1 else None


def copied(folder: Path) -> None:
    """What tests need, as git has it."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    for name in listed.stdout.splitlines():
        if name.startswith(("geosurf/", "tests/", "data/", "docs/", "benchmarks/", "pyproject")):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    shared = Path(os.environ.get("GEOSURF_SHARED", ROOT.parent / "shared"))
    os.environ["GEOSURF_SHARED"] = str(shared)


def killers(mutants: list[Mutant], whole: bool) -> Iterator[tuple[Mutant, str]]:
    """For each mistake the test that fails first; nothing if it survives."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        copied(folder)
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        words = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            "--no-header",
        ]

        def first_failure(tests: list[str], apart: list[str]) -> str:
            run = subprocess.run(
                [*words, *(f"--deselect={one}" for one in apart), *tests],
                cwd=folder, env=environment, capture_output=True, text=True, check=False,
            )  # fmt: skip
            failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", run.stdout, re.MULTILINE)
            return failed[1] if failed else "" if run.returncode == 0 else "no test ran"

        broken: list[str] = []  # tests that fail without any mistake kill nothing
        for mutant in mutants:
            file = found(mutant)
            if file is None:
                yield mutant, "NO LONGER THERE"
                continue
            right = (ROOT / file).read_text(encoding="utf-8")
            tests = ["tests", "geosurf"] if whole else mutant.tests.split()
            tests = [one for one in tests if (folder / one).exists()]
            while tests:  # without any, pytest would run all
                wrong = right.replace(mutant.text, mutant.wrong)
                (folder / file).write_text(wrong, encoding="utf-8")
                killer = first_failure(tests, broken)
                (folder / file).write_text(right, encoding="utf-8")
                if "::" not in killer or not first_failure([killer], []):
                    break
                broken.append(killer)
            yield mutant, killer if tests else "no test ran"


def main() -> int:
    """Plant all, or some; print what kills each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-k", default="", help="only those whose room or text has this word")
    parser.add_argument("--whole", action="store_true", help="run all tests, not those named")
    parser.add_argument("--list", action="store_true", help="only say whether each still fits")
    asked = parser.parse_args()
    chosen = [one for one in MUTANTS if asked.k in one.room or asked.k in one.text]
    if asked.list:
        lost = [one for one in chosen if found(one) is None]
        for one in lost:
            print(f"does not fit: geosurf/{one.room}: {one.text}")
        print(f"{len(chosen) - len(lost)} of {len(chosen)} fit")
        return 1 if lost else 0
    survived = 0
    for one, killer in killers(chosen, asked.whole):
        survived += killer in ("", "NO LONGER THERE", "no test ran")
        print(f"{one.room:18} {one.wrong[:60]:60} {killer or 'SURVIVED'}", flush=True)
    print(f"{len(chosen) - survived} of {len(chosen)} killed")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
