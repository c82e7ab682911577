"""Types: public signatures are complete."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from functools import cached_property
from types import ModuleType
from typing import Any

import pytest

import geosurf

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
