"""Drawing without a screen: silence where it works, a sentence where it cannot."""

import os
import sys

import pytest

from geosurf.cli import info_commands
from geosurf.errors import DependencyError
from geosurf.render import backend
from geosurf.render.backend import CHOICE, EGL, OSMESA, Backend, Finding
from tests.processes import run_python

DRAW = """
from geosurf.model import TriSurface
from geosurf.render import render_place
ramp = TriSurface("F1", "fault", [[0, 0, 0], [900, 0, 0], [0, 900, 500]], [[0, 1, 2]])
render_place([ramp], (300, 300, 166), {path!r}, size=(400, 250))
"""


def run(code, **environment):
    """Run Python apart, without a display unless one is given."""
    return run_python("-c", code, without=("DISPLAY", CHOICE), **environment)


@pytest.fixture
def forgetful():
    """Let every test look for itself."""
    backend.find_backend.cache_clear()
    yield
    backend.find_backend.cache_clear()


def test_drawing_says_nothing_and_leaves_the_same_bytes(tmp_path, monkeypatch):
    """Without a display, and with one that is not there."""
    monkeypatch.delenv("DISPLAY", raising=False)
    exec(DRAW.format(path=str(tmp_path / "none.png")), {})
    done = run(DRAW.format(path=str(tmp_path / "lies.png")), DISPLAY=":99")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "none.png").read_bytes() == (tmp_path / "lies.png").read_bytes()


@pytest.mark.parametrize(
    "broken", ["LIBGL_DRIVERS_PATH", "__EGL_VENDOR_LIBRARY_DIRS"], ids=["no driver", "no vendor"]
)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is a matter of Linux")
def test_a_machine_without_a_driver_gets_a_sentence_and_no_segfault(tmp_path, broken):
    if backend.probe(OSMESA).renderer:
        pytest.skip("OSMesa draws here without a driver")
    done = run(DRAW.format(path=str(tmp_path / "no.png")), **{broken: "/nonexistent"})
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert "DependencyError: pictures cannot be drawn without a screen" in last
    assert "libEGL.so" in last
    assert "apt install libegl1 libgl1-mesa-dri" in last
    assert not (tmp_path / "no.png").exists()


def test_a_choice_of_the_user_is_the_only_one_tried(monkeypatch, forgetful):
    tried = []

    def probe(candidate):
        tried.append(candidate)
        return Finding(candidate, "", "nothing there")

    monkeypatch.setattr(backend, "probe", probe)
    with pytest.raises(DependencyError, match=rf"OSMESA: nothing there.*unset {CHOICE}"):
        backend.find_backend(OSMESA.window)
    assert tried == [OSMESA]


def test_a_library_that_is_no_graphics_library_is_refused_not_fatal(forgetful):
    found = backend.probe(Backend("egl", EGL.window, ("libm.so.6",)))
    assert found.renderer == ""
    assert "libm.so.6 is installed, but a driver that draws" in found.reason


@pytest.mark.parametrize("before", [None, "vtkEGLRenderWindow"])
def test_the_choice_ends_with_the_block(monkeypatch, forgetful, before):
    monkeypatch.setattr(backend, "probe", lambda candidate: Finding(candidate, "llvmpipe", "draws"))
    monkeypatch.setattr(sys, "platform", "linux")
    if before is None:
        monkeypatch.delenv(CHOICE, raising=False)
    else:
        monkeypatch.setenv(CHOICE, before)
    with backend.off_screen():
        assert os.environ[CHOICE] == EGL.window
    assert os.environ.get(CHOICE) == before


def test_doctor_says_why_there_are_no_pictures(monkeypatch, forgetful):
    monkeypatch.setattr(backend, "probe", lambda candidate: Finding(candidate, "", "nothing there"))
    monkeypatch.setattr(sys, "platform", "linux")
    (found,) = (part for part in info_commands.installation() if part.name == "pictures")
    assert found.state == "MISSING"
    assert "apt install libegl1" in found.detail
