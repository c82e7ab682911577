"""Every public name can be reached and says what it takes, gives and looks like in use."""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
from pathlib import Path

import pytest

import geosurf
from geosurf import errors
from tests.processes import told_by

NAMES = [name for name in geosurf.__all__ if name != "__version__"]
ROOMS = [name for name in NAMES if name in ("synthetic", "ensemble", "errors", "conventions")]
THINGS = [name for name in NAMES if name not in ROOMS]


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'geosurf' has no attribute 'intersekt'"):
        geosurf.intersekt  # noqa: B018


LAZY = [
    ".".join(["geosurf", *door.parent.relative_to(Path(geosurf.__file__).parent).parts])
    for door in sorted(Path(geosurf.__file__).parent.rglob("__init__.py"))
    if "= lazily(" in door.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("room", LAZY)
def test_rooms_that_load_when_used_offer_what_they_list(room: str) -> None:
    module = importlib.import_module(room)
    assert {"geosurf", "geosurf.model"} <= set(LAZY)
    assert dir(module) == sorted(module.__all__)
    for name in module.__all__:
        assert getattr(module, name) is not None
    # a module of the same name would take the place of the function
    modules = {path.stem for path in Path(module.__file__).parent.glob("*.py")}
    assert not modules & set(module.__all__) - {"errors"}
    assert Path(geosurf.__file__).with_name("py.typed").is_file()


# Each room is loaded first in a process of its own, forked so that numpy and numba load once: 1 s
# instead of 10 s.
LOADED_FIRST = """
import importlib, os, sys
import numba, xarray
homes = {homes!r}
for room in sorted(set(homes.values())):
    child = os.fork()
    if not child:
        import geosurf
        importlib.import_module(room)
        names = [name for name in homes if homes[name] == room]
        os._exit(not all(callable(getattr(geosurf, name)) for name in names))
    if os.waitpid(child, 0)[1]:
        sys.exit(room)
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork processes")
def test_names_work_before_and_after_their_room_is_loaded() -> None:
    """A folder must not shadow the function of the same name, whoever comes first."""
    code = LOADED_FIRST.format(homes={name: getattr(geosurf, name).__module__ for name in THINGS})
    told_by("-c", code)


# ---- docs/errors.md and the classes tell the same story --------------------------------


def error_classes() -> list[type[errors.GeosurfError]]:
    return [getattr(errors, name) for name in errors.__all__ if name != "GeosurfWarning"]


@pytest.mark.parametrize("error", error_classes(), ids=lambda error: error.__name__)
def test_every_error_has_its_entry_in_the_docs(error: type[errors.GeosurfError]) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "errors.md").read_text()
    entry = re.search(rf"^#+ `{error.__name__}`.*?(?=^#|\Z)", page, re.MULTILINE | re.DOTALL)
    assert entry, f"docs/errors.md has no heading for {error.__name__}"
    assert f"exit code {error.exit_code}" in entry[0]


def test_error_classes_say_whose_move_it_is() -> None:
    assert issubclass(errors.InputError, ValueError)
    assert issubclass(errors.InvariantError, AssertionError)
    codes = {error.__name__: error.exit_code for error in error_classes()}
    assert codes["FormatError"] == codes["ScenarioError"] == 2
    assert codes["OpenUnitError"] == codes["RoundingError"] == 3
    assert codes["InvariantError"] == 4
    assert all(issubclass(error, errors.GeosurfError) for error in error_classes())


def test_no_error_class_lives_outside_geosurf_errors() -> None:
    """One that did would escape the list, the page of docs and the exit codes."""
    for module in pkgutil.walk_packages(geosurf.__path__, "geosurf."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    strays = [
        cls.__module__
        for cls in _subclasses(errors.GeosurfError)
        if cls.__module__ != "geosurf.errors"
    ]
    assert not strays


def _subclasses(cls: type) -> list[type]:
    return [sub for direct in cls.__subclasses__() for sub in (direct, *_subclasses(direct))]
