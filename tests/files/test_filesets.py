"""Whole files, claims, and sets of files that are exchanged as one."""

from __future__ import annotations

import os
import re
import stat
import subprocess
import sys
import threading
from pathlib import Path, PurePosixPath

import pytest

import geosurf as gs
from benchmarks.stress.crash_points import attack
from benchmarks.stress.crash_writers import Writer
from geosurf import files
from geosurf.errors import OutputError
from geosurf.files import Lock, Names, finish, replace_files, write_whole
from geosurf.scenario import output
from geosurf.scenario.output import new_results
from tests.messages import refused

OURS = Names((re.compile(r"index"), re.compile(r"parts/\d\.txt")), ("parts",))
OLD = {"index": "1 2", "parts/1.txt": "old", "parts/2.txt": "old"}
NEW = {"index": "1 new", "parts/1.txt": "new"}
posix = pytest.mark.skipif(os.name != "posix", reason="links, permissions and signals of POSIX")


def put(folder: Path, texts: dict[str, str]) -> Path:
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def seen(folder: Path) -> dict[str, str]:
    """All files, hidden ones too."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_text() for path in paths}


# ---- one file -----------------------------------------------------------------------------


@posix
def test_permissions_are_those_that_the_umask_leaves(tmp_path):
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "a", b"")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


@posix
def test_a_link_is_replaced_and_not_followed(tmp_path):
    (tmp_path / "precious").write_text("precious")
    (tmp_path / "a").symlink_to("precious")
    write_whole(tmp_path / "a", b"new")
    assert seen(tmp_path) == {"precious": "precious", "a": "new"}
    assert not (tmp_path / "a").is_symlink()


@posix
def test_a_planted_temporary_name_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "random_digits", lambda: "0" * 16)
    (tmp_path / "precious").write_text("precious")
    (tmp_path / f"{files.PREFIX}{'0' * 16}{files.SUFFIX}").symlink_to("precious")
    with pytest.raises(FileExistsError):
        write_whole(tmp_path / "a", b"new")
    assert (tmp_path / "precious").read_text() == "precious"


def test_threads_that_write_one_file_never_tear_it(tmp_path):
    texts = {bytes([65 + k]) * 20_000 for k in range(4)}
    target, found, stop = tmp_path / "a", set(), threading.Event()
    write_whole(target, min(texts))

    def read() -> None:
        while not stop.is_set():
            found.add(target.read_bytes())

    writers = [threading.Thread(target=lambda t=t: [write_whole(target, t) for _ in range(5)])
               for t in texts]  # fmt: skip
    reader = threading.Thread(target=read)
    for thread in (reader, *writers):
        thread.start()
    for thread in writers:
        thread.join()
    stop.set()
    reader.join()
    assert found <= texts
    assert len(list(tmp_path.iterdir())) == 1


# ---- sets ---------------------------------------------------------------------------------


def _replace(place: Path) -> None:
    try:
        journal = ".geosurf-commit"
        finish(place, OURS, journal)
        files.make_stage(place / ".geosurf-new")
        stage = put(place / ".geosurf-new", NEW)
        replace_files(place, stage, [PurePosixPath(name) for name in OLD], OURS, journal)
    except OSError as error:
        raise OutputError(str(error)) from error


@pytest.mark.skipif(not hasattr(os, "fork"), reason="children are forked")
def test_law_a_kill_at_any_step_leaves_no_mixture(tmp_path):
    """Old, new, or incomplete without its index; the next write makes it whole."""
    foreign = {"notes.txt": "mine", "parts/mine.txt": "mine"}
    writer = Writer(
        "files", lambda place: put(place, OLD | foreign), _replace, True,
        is_ours=lambda name: PurePosixPath(name) in OURS, marked=lambda found: "index" not in found,
    )  # fmt: skip
    found = list(attack(writer, tmp_path, kinds=("killed",)))
    assert len(found) > 10
    assert {words for _, _, words in found} == {"old", "new", "unfinished"}


@posix
@pytest.mark.parametrize("name", ["../precious", "/precious", "parts/../../precious", "precious"])
def test_a_journal_names_nothing_but_ours(tmp_path, name):
    put(tmp_path, {"precious": "mine", "out/precious": "mine"})
    journal = tmp_path / "out" / ".geosurf-commit"
    journal.mkdir()
    (journal / ".geosurf-files").write_text(f'{{"old": ["{name}"], "new": []}}')
    refused(OSError, "which geosurf does not write", finish, tmp_path / "out", OURS, journal.name)
    assert (tmp_path / "precious").exists()
    assert (tmp_path / "out" / "precious").exists()


def test_what_cannot_be_replaced_is_refused_before_anything_changes(tmp_path):
    put(tmp_path, OLD)
    (tmp_path / "parts" / "1.txt").unlink()
    put(tmp_path, {"parts/1.txt/inside": "mine"})
    before = seen(tmp_path)
    with pytest.raises(OutputError, match="is a folder and should be a file"):
        _replace(tmp_path)
    assert {n: t for n, t in seen(tmp_path).items() if files.PREFIX not in n} == before


# ---- the folder of a run ------------------------------------------------------------------

RESULTS = {"units.vtm": "{}", "units/000_a.vtp": "{}", "certificate.txt": "{}"}


def results(text: str) -> dict[str, str]:
    return {name: data.format(text) for name, data in RESULTS.items()}


def run(out: Path, text: str) -> None:
    with new_results(out) as stage:
        put(stage, results(text))


def test_a_folder_of_ours_is_replaced_and_its_permissions_stay(tmp_path):
    out = tmp_path / "out"
    run(out, "old")
    out.chmod(0o750)
    put(out, {"volumes.csv": "of an earlier run"})
    run(out, "new")
    assert seen(tmp_path) == {f"out/{name}": text for name, text in results("new").items()}
    assert stat.S_IMODE(out.stat().st_mode) == 0o750


@pytest.mark.parametrize("mine", ["notes.txt", "units/mine.txt", "more/notes.txt", ".hidden"])
def test_foreign_files_stay(tmp_path, mine):
    out = tmp_path / "out"
    run(out, "old")
    put(out, {mine: "mine", "units/001_b.vtp": "of an earlier run"})
    inode = (out / mine).stat().st_ino
    run(out, "new")
    assert seen(out) == results("new") | {mine: "mine"}
    assert (out / mine).stat().st_ino == inode


def test_one_run_at_a_time_writes_into_a_folder(tmp_path):
    out = tmp_path / "out"
    with new_results(out) as stage:
        put(stage, results("first"))
        refused(OutputError, "another run is writing there", run, out, "second")
    assert seen(out) == results("first")
    run(out, "second")
    assert seen(out) == results("second")


def test_what_dead_runs_left_is_removed(tmp_path):
    out = tmp_path / "out"
    run(out, "old")
    put(out, {".geosurf-0123456789abcdef/units.vtm": "", ".geosurf-ab12_xyz/units.vtm": ""})
    put(tmp_path, {".geosurf-mine/x": "y"})
    (out / output.LOCK).write_text("")
    run(out, "new")
    assert seen(tmp_path) == {f"out/{name}": text for name, text in results("new").items()} | {
        ".geosurf-mine/x": "y"
    }


@posix
def test_a_claim_ends_with_its_process(tmp_path):
    code = f"""
import os, signal
from pathlib import Path
from geosurf.files import Lock
assert Lock(Path({str(tmp_path / "lock")!r})).take()
os.kill(os.getpid(), signal.SIGKILL)
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == -9
    assert (tmp_path / "lock").exists()
    assert Lock(tmp_path / "lock").take()


@posix
def test_nothing_is_removed_behind_a_linked_folder(tmp_path, planes):
    put(tmp_path, {"mine/000_mine.vtp": "mine"})
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "units").symlink_to(tmp_path / "mine")
    refused(OutputError, "units is a link; remove it", run, tmp_path / "out", "new")
    (tmp_path / "u").symlink_to(tmp_path / "mine")
    refused(OutputError, "u next to it is a link", gs.write, planes.units, tmp_path / "u.vtm")
    assert seen(tmp_path / "mine") == {"000_mine.vtp": "mine"}


def test_units_of_an_earlier_index_go_and_foreign_ones_stay(tmp_path):
    world = gs.synthetic.tilted_planes(n=5)
    many, few = (gs.Scene(world.horizons, f, world.box).units for f in (world.faults, {}))
    gs.write(many, tmp_path / "u.vtm")
    put(tmp_path, {"u/007_mine.vtp": "mine", "u/notes.txt": "mine"})
    (tmp_path / "u" / "007_mine.vtp").write_text("mine")
    written = gs.write(few, tmp_path / "u.vtm")
    kept = {tmp_path / "u" / "007_mine.vtp", tmp_path / "u" / "notes.txt"}
    assert {path for path in tmp_path.rglob("*") if path.is_file()} == kept | set(written)
