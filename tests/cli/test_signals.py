"""Signals end the process of a command at any moment, and leave nothing that is half-done."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import geosurf as gs
from geosurf.kernels.compile.gate import Signature
from geosurf.kernels.compile.jit import Entry
from geosurf.stopping import interrupted_later

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
DATA = Path(gs.__file__).parents[1] / "data" / "synthetic_horizons" / "faulted_reservoir.toml"
START = """
import ctypes, os, pathlib, signal, sys, time
from geosurf.stopping import end_at_signals, keeping, temporary_folder, undone
number, stage = getattr(signal, sys.argv[1]), pathlib.Path(sys.argv[2])
end_at_signals()
keeping(lambda: "All is as it was.")
def stop():
    os.kill(os.getpid(), number)
    time.sleep(9)
class Lost:
    def __del__(self):
        stop()
with undone(stage.rmdir), temporary_folder() as folder:
    pathlib.Path(folder, "part").write_text("half")
    print(folder)
    stage.mkdir()
"""
MOMENTS = {
    "anywhere": "    stop()",
    "destructor": "    one = Lost(); del one",
    "callback": "    ctypes.CFUNCTYPE(None)(stop)()",
    "error": "    try: 1 / 0\n    except ZeroDivisionError: stop()",
}


@pytest.mark.parametrize(
    ("word", "code", "moment"),
    [("SIGTERM", 143, "anywhere"), ("SIGHUP", 129, "anywhere")]
    + [("SIGINT", 130, moment) for moment in MOMENTS],
)
def test_a_signal_ends_the_process_and_what_is_half_done(tmp_path, word, code, moment):
    stage = tmp_path / "stage"
    command = [sys.executable, "-c", START + MOMENTS[moment], word, str(stage)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (code, "geosurf: stopped. All is as it was.\n")
    assert not stage.exists()
    assert done.stdout.strip()
    assert not Path(done.stdout.strip()).exists()


def test_a_signal_that_is_ignored_stays_so(tmp_path):
    ignored = START.replace("end_at_signals()\n", "signal.signal(number, 1)\nend_at_signals()\n")
    code = ignored.replace("time.sleep(9)", "print('on')") + MOMENTS["anywhere"]
    command = [sys.executable, "-c", code, "SIGHUP", str(tmp_path / "stage")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout.split()[-1], done.stderr) == (0, "on", "")


@pytest.mark.parametrize("seconds", [0.6, 1.6])
def test_a_run_that_is_stopped_leaves_an_empty_folder(tmp_path, seconds):
    command = [sys.executable, "-m", "geosurf", "run", str(DATA), "-o", str(tmp_path / "out")]
    environ = {**os.environ, "TMPDIR": str(tmp_path)}
    child = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environ
    )
    time.sleep(seconds)
    child.send_signal(signal.SIGTERM)
    _, said = child.communicate(timeout=60)
    assert child.returncode == 143
    assert said.splitlines()[-1].startswith("geosurf: stopped.")
    assert not any((tmp_path / "out").glob("*"))
    assert not list(tmp_path.glob("geosurf-*"))


class Interrupted:
    """A runner whose machine code is interrupted, as numba reports it."""

    def caller(self, name, function, signature):
        def run(*_):
            try:
                raise KeyboardInterrupt
            except KeyboardInterrupt as stop:
                inner = SystemError("unpickle returned a result with an exception set")
                inner.__cause__ = stop
                raise SystemError("a kernel returned a result with an exception set") from inner

        return run


def test_an_interrupt_inside_of_a_kernel_is_an_interrupt():
    kernel = Entry(abs, Signature.parse("l -> l"), Interrupted())
    with pytest.raises(KeyboardInterrupt):
        kernel(3)


def test_an_interrupt_of_a_library_that_draws_comes_when_it_has_ended():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    done = []

    def draw():
        with interrupted_later():
            os.kill(os.getpid(), signal.SIGINT)
            done.append(True)

    try:
        with pytest.raises(KeyboardInterrupt):
            draw()
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert done
