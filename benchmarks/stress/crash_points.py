"""Kills and errors at every step of all writers.

``python -m benchmarks.stress.crash_points [every]`` runs them.

Each writer replaces old results by new ones in a child process, which counts the calls of the
system that change files. For each of them one child is killed just before it (half of the data are
written where it is a write), and three get an error there: no room, no permission, interrupted.
Then the folder is looked at: it holds the old results or the new ones and never a mixture, files
of others are as they were, and the next write gives the new results and leaves nothing hidden.

`every` tries each n-th step only. Ends with 1 if there is a mixture.
"""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from benchmarks.stress.crash_writers import WRITERS, Writer, warm
from geosurf import files
from geosurf.errors import GeosurfError

CALLS = (
    "open",
    "write",
    "fsync",
    "replace",
    "rename",
    "link",
    "unlink",
    "remove",
    "rmdir",
    "mkdir",
)
ERRORS = {"no room": errno.ENOSPC, "no permission": errno.EACCES, "interrupted": errno.EINTR}
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT


class Steps:
    """Counts the calls that change files below a folder, and does something at one of them."""

    def __init__(self, folder: Path, at: int, what: str) -> None:
        self.n = 0
        self._folder, self._at, self._what = str(folder), at, what
        self._handles: set[int] = set()

    def watch(self) -> None:
        """Put itself between Python and the system; in a child process, so for good."""
        for name in CALLS:
            setattr(os, name, self._watched(name, getattr(os, name)))

    def _watched(self, name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def watched(*words: Any, **named: Any) -> Any:
            if not self._concerns(name, words, named):
                return call(*words, **named)
            self._step((lambda: call(words[0], words[1][: len(words[1]) // 2]))
                       if name == "write" else None)  # fmt: skip
            found = call(*words, **named)
            if name == "open":
                self._handles.add(found)
            return found

        return watched

    def _concerns(self, name: str, words: tuple[Any, ...], named: dict[str, Any]) -> bool:
        if name in ("write", "fsync"):
            return words[0] in self._handles
        if name == "open" and not (len(words) > 1 and words[1] & _WRITING):
            return False
        return "dir_fd" in named or str(Path(words[0]).absolute()).startswith(self._folder)

    def _step(self, half: Callable[[], Any] | None) -> None:
        self.n += 1
        if self.n != self._at:
            return
        if half is not None:
            half()
        if self._what == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        number = ERRORS[self._what]
        raise OSError(number, os.strerror(number))


def digests(folder: Path, hidden: bool = False) -> dict[str, str]:
    """What a user finds in a folder: relative names and contents."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and (hidden or files.PREFIX not in str(path.relative_to(folder)))
    }


def in_child(action: Callable[[], None]) -> int:
    """Do something in a child process; 0 done, 1 refused by geosurf, 2 another error, 9 killed."""
    child = os.fork()
    if not child:
        code = 2
        with suppress(BaseException):
            try:
                action()
                code = 0
            except GeosurfError:
                code = 1
        os._exit(code)
    _, status = os.waitpid(child, 0)
    return 9 if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def steps_of(writer: Writer, place: Path) -> int:
    """Number of steps of a writer."""
    read, write = os.pipe()

    def count() -> None:
        steps = Steps(place, 0, "")
        steps.watch()
        writer.write_new(place)
        os.write(write, str(steps.n).encode())

    prepare(writer, place)
    code = in_child(count)
    os.close(write)
    with os.fdopen(read) as told:
        text = told.read()
    if code or not text:
        raise RuntimeError(f"{writer.name} fails without a crash")
    return int(text)


def prepare(writer: Writer, place: Path) -> None:
    """The old results in a folder, and nothing else of ours."""
    for path in place.parent.iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    if (place.parent.parent / "old").exists():
        shutil.copytree(place.parent.parent / "old", place)
        return
    place.mkdir()
    if in_child(lambda: writer.write_old(place)):
        raise RuntimeError(f"{writer.name} cannot write the old results")
    shutil.copytree(place, place.parent.parent / "old")


def verdict(found: dict[str, str], old: dict[str, str], new: dict[str, str], writer: Writer) -> str:
    """old, new, unfinished (marked, and files of one side only), or what is wrong."""
    if found in (old, new):
        return "old" if found == old else "new"
    of_old = {name for name, data in found.items() if old.get(name) == data}
    of_new = {name for name, data in found.items() if new.get(name) == data}
    rest = found.keys() - of_old - of_new - {files.MARK}
    common = {name for name, data in old.items() if new.get(name) == data}
    foreign = {name for name in common if not writer.is_ours(name)}
    if rest:
        return f"WRONG: torn or foreign files {sorted(rest)}"
    if not foreign <= found.keys():
        return f"WRONG: lost {sorted(foreign - found.keys())}"
    if of_old - of_new and of_new - of_old:
        return f"WRONG: {len(of_old - of_new)} old and {len(of_new - of_old)} new files"
    if not writer.marked(found):
        return "WRONG: incomplete, and nothing says so"
    return "unfinished"


def attack(
    writer: Writer, base: Path, every: int = 1, kinds: tuple[str, ...] = ("killed", *ERRORS)
) -> Iterator[tuple[str, int, str]]:
    """Give (what happened, at which step, how it was then) for all steps of a writer."""
    base, place = base / "work", base / "work" / "here"
    base.mkdir()
    prepare(writer, place)
    old = digests(place)
    if in_child(lambda: writer.write_new(place)):
        raise RuntimeError(f"{writer.name} cannot write the new results")
    new = digests(place)
    n_step = steps_of(writer, place)
    for what in kinds:
        for at in range(1, n_step + 1, every):
            prepare(writer, place)
            steps = Steps(base, at, what)
            code = in_child(lambda steps=steps: (steps.watch(), writer.write_new(place)))
            found = verdict(digests(place), old, new, writer)
            if code == 2:
                found = "WRONG: an error that is not geosurf's"
            elif code == 0 and found != "new" and not writer.silent:
                found = f"WRONG: no error, but {found}"
            elif found == "unfinished" and not writer.may_be_unfinished:
                found = "WRONG: unfinished"
            elif what == "killed" and code != 9 and found != "new":
                found = "WRONG: it was not killed"
            again = in_child(lambda: writer.write_new(place))
            if not found.startswith("WRONG"):
                hidden = [p for p in digests(base, hidden=True) if files.PREFIX in p]
                left = [name for name in hidden if not name.endswith(files.SUFFIX)]
                if again or digests(place) != new:
                    found = "WRONG: the next write does not give the new results"
                elif left:
                    found = f"WRONG: left behind {left}"
            yield what, at, found


def main(arguments: list[str]) -> int:
    """Attack all writers, or those that are named."""
    every = int(arguments[0]) if arguments else 1
    start, all_found, n_point = time.monotonic(), Counter(), 0
    warm()
    for writer in WRITERS:
        if arguments[1:] and writer.name not in arguments[1:]:
            continue
        with tempfile.TemporaryDirectory() as name:
            rows = list(attack(writer, Path(name).resolve(), every))
        found = Counter("WRONG" if row[2].startswith("WRONG") else row[2] for row in rows)
        all_found += found
        n_point += sum(row[0] == "killed" for row in rows)
        say(f"{writer.name:28} {len(rows):5} cases: "
            + ", ".join(f"{count} {word}" for word, count in sorted(found.items())))  # fmt: skip
        for what, at, words in rows:
            if words.startswith("WRONG"):
                say(f"    {what} at step {at}: {words}")
    counts = ", ".join(f"{all_found[word]} {word}" for word in ("old", "new", "unfinished"))
    seconds = time.monotonic() - start
    say(f"{n_point} crash points, {all_found.total()} cases: {counts}, "
        f"{all_found['WRONG']} mixtures or other wrong, {seconds:.0f} s")  # fmt: skip
    return int(all_found["WRONG"] > 0)


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
