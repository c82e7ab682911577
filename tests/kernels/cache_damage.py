"""Damaged kernel caches: ``python -m tests.kernels.cache_damage [rounds] [seed] [names]``.

A process fills a cache; for each kind of damage a copy of it is damaged, and two processes run
with it. A run succeeds if it ends with 0 and the right numbers, if planted code did not run, and
if it warns once where there is something to warn of, and not at all where there is not. The second
run shows whether the damage has healed. Ends with 1 if a run fails.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.kernels.cache_damages import DAMAGES, Scene

CHILD = """
import json, os, sys, warnings
exec(os.environ.get("DAMAGE_FIRST", ""))
import numpy as np
from geosurf.kernels.meshes.mesh import weld
from geosurf.kernels.exact.predicates import scale_of
exec(os.environ.get("DAMAGE_THEN", ""))
rows = np.array([[0, 0, 0], [4, 5, 6], [0, 0, 0], [4, 5, 6.0]])[:, ::-1]  # not contiguous: cast
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    number, count = weld(rows)
    exec(os.environ.get("DAMAGE_BETWEEN", ""))
    power, bits = scale_of(np.array([0.5, 3.0]))
said = [str(w.message) for w in caught]
kinds = [getattr(w.message, "kind", type(w.message).__name__) for w in caught]
hits = int(bool(weld._run._compiled.stats.cache_hits))
answer = [number.tolist(), count, power, bits]
print(json.dumps({"answer": answer, "said": said, "kinds": kinds, "hit": hits}))
"""
ANSWER = [[0, 1, 0, 1], 2, 1, 3]


def environment(cache: Path, extra: dict[str, str]) -> dict[str, str]:
    """Variables of a run with a cache, whatever those of this process are."""
    gone = ("NUMBA_DISABLE_JIT", "GEOSURF_FROZEN", "XDG_CACHE_HOME", "PYTHONWARNINGS")
    kept = {name: value for name, value in os.environ.items() if name not in gone}
    return kept | {"GEOSURF_JIT": "1", "GEOSURF_CACHE_DIR": str(cache)} | extra


def start(cache: Path, extra: dict[str, str]) -> subprocess.Popen[str]:
    """Start a run."""
    return subprocess.Popen([sys.executable, "-c", CHILD], env=environment(cache, extra),
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # fmt: skip


def look(process: subprocess.Popen[str], marker: Path) -> tuple[str, dict]:
    """What is wrong with a run, and what it said."""
    try:
        out, err = process.communicate(timeout=300)
    except subprocess.TimeoutExpired:
        process.kill()
        return "it hangs", {}
    if process.returncode:
        return f"exit status {process.returncode}: {err.strip()[-300:]}", {}
    said = json.loads(out.strip().splitlines()[-1])
    if said["answer"] != ANSWER:
        return f"wrong numbers: {said['answer']}", said
    if marker.exists():
        return "planted code has run", said
    if set(said["kinds"]) - {"kernel cache"} or len(said["said"]) > 1:
        return f"warnings: {said['said']}", said
    return "", said


def try_damage(damage, full: Path, scratch: Path, number: int) -> tuple[list[str], str]:
    """Outcomes of the runs with one damage ("" is good), and what was said or skipped."""
    folder = scratch / f"{damage.__name__}-{number}"
    folder.mkdir()
    cache = folder / "cache"
    shutil.copytree(full, cache)
    scene = Scene(cache, folder / "marker", random.Random(number))
    skipped = damage(scene)
    if skipped:
        return [], f"skipped: {skipped}"
    runs = [start(scene.cache, scene.env) for _ in range(scene.at_once)]
    looks = [look(run, scene.marker) for run in runs]
    wrong = [found for found, _ in looks]
    if scene.killed and any(run.returncode != -9 for run in runs):
        wrong = ["it was not killed"]
    elif scene.killed:
        wrong = []
    said = "; ".join(looks[0][1].get("said", ()))
    if wrong == [""] and bool(said) != scene.warns:
        wrong = [f"expected {'a' if scene.warns else 'no'} warning, got: {said or 'none'}"]
    if scene.marker.exists():
        wrong.append("planted code has run")
    again, after = look(start(scene.cache, {} if scene.heals else scene.env), scene.marker)
    if not again and scene.heals and (after["said"] or scene.keeps > after["hit"]):
        again = f"not healed: {after['said'] or 'compiled again'}"
    shutil.rmtree(folder, ignore_errors=True)
    return [*wrong, again], said


def main(arguments: list[str]) -> int:
    """Try all damages, or those that are named; several rounds damage other bytes."""
    rounds = int(arguments[0]) if arguments else 1
    seed = int(arguments[1]) if len(arguments) > 1 else 1
    chosen = [d for d in DAMAGES if not arguments[2:] or d.__name__ in arguments[2:]]
    begin, n_run, n_bad, n_kind, skipped = time.monotonic(), 0, 0, 0, 0
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        full = scratch / "full"
        wrong, _ = look(start(full, {}), scratch / "marker")
        if wrong:
            sys.stdout.write(f"no cache could be filled: {wrong}\n")
            return 1
        for number in range(seed, seed + rounds):
            for damage in chosen:
                outcomes, said = try_damage(damage, full, scratch, number)
                bad = [outcome for outcome in outcomes if outcome]
                n_run, n_bad = n_run + len(outcomes), n_bad + len(bad)
                n_kind += bool(outcomes) and number == seed
                skipped += not outcomes
                words = " ".join((damage.__doc__ or "").split()).rstrip(".")
                say(f"{'FAILED' if bad else 'ok    '} {words}: {'; '.join(bad) or said or '-'}")
    seconds = time.monotonic() - begin
    say(f"{n_kind} kinds of damage, {n_run} runs, {n_run - n_bad} successful, {n_bad} failed, "
        f"{skipped} skipped, seed {seed}, {seconds:.0f} s")  # fmt: skip
    return int(n_bad > 0)


def say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
