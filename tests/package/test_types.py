"""Types: public signatures are complete, and docs/validation/types.md states what mypy checks."""

from __future__ import annotations

import inspect
import re
import tomllib
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import geosurf

ROOT = Path(__file__).resolve().parents[2]
NAMES = sorted(set(geosurf.__all__) - {"__version__"})


def functions_of(thing: Any, name: str) -> Iterator[tuple[str, Callable[..., Any]]]:
    """Functions, public methods and properties of a public name, inherited ones too."""
    if inspect.isfunction(thing):
        yield name, thing
    elif isinstance(thing, ModuleType):
        for each in getattr(thing, "__all__", ()):
            yield from functions_of(getattr(thing, each), f"{name}.{each}")
    elif inspect.isclass(thing):
        ours = [base for base in thing.__mro__ if base.__module__.startswith("geosurf")]
        for key, value in ((k, v) for base in ours for k, v in vars(base).items()):
            if key == "__init__" or not key.startswith("_"):
                found = _function_of(value)
                if found is not None:
                    yield f"{name}.{key}", found


def _function_of(value: Any) -> Callable[..., Any] | None:
    """The function behind a method, a class method or a property."""
    if isinstance(value, property):
        value = value.fget
    elif isinstance(value, cached_property):
        value = value.func
    elif isinstance(value, classmethod | staticmethod):
        value = value.__func__
    return value if inspect.isfunction(value) else None


@pytest.mark.parametrize("name", NAMES)
def test_public_signatures_are_fully_typed(name: str) -> None:
    missing = []
    for where, function in functions_of(getattr(geosurf, name), name):
        signature = inspect.signature(function)
        missing += [
            f"{where}: {parameter.name}"
            for parameter in signature.parameters.values()
            if parameter.annotation is parameter.empty and parameter.name not in ("self", "cls")
        ]
        if signature.return_annotation is signature.empty:
            missing.append(f"{where}: the result")
    assert not missing


def test_the_page_lists_every_room_with_the_profile_that_mypy_uses() -> None:
    page = (ROOT / "docs" / "validation" / "types.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"^\| `(\w+)` \| \d+ \| (\w+) \|", page, re.MULTILINE))
    rooms = {path.name for path in (ROOT / "geosurf").iterdir() if (path / "__init__.py").is_file()}
    assert set(listed) >= rooms
    assert listed == {room: profile_of(room) for room in listed}


def profile_of(room: str) -> str:
    """The profile of a room, from the overrides in pyproject.toml that name it."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    assert (settings["strict"], settings["files"]) == (True, ["geosurf"])
    mine: dict[str, Any] = {}
    for override in settings["overrides"]:
        assert not override.get("ignore_errors")
        module = "geosurf" if room == "__init__" else f"geosurf.{room}"
        if {module, f"{module}.*"} & set(override["module"]):
            mine |= override
    if mine.get("disallow_untyped_defs") is False:
        assert room == "kernels"  # numba compiles functions without types; nobody else does
        return "kernels"
    return "strict" if mine.get("warn_return_any") else "arrays"
