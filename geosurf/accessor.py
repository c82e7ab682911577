"""``da.geosurf``: functions of geosurf that take a DataArray or Dataset, as methods of it.

They only forward: ``top.geosurf.write("top.gri")`` is ``geosurf.write(top, "top.gri")``. xarray
takes such an accessor when it is loaded. `when_xarray_is_there` waits for that, so that neither
order of imports matters and ``import geosurf`` does not load xarray.
"""

from __future__ import annotations

import functools
import importlib.util
import sys
from collections.abc import Callable, Sequence
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

# functions whose first argument is an object of xarray
FOR_ARRAYS = (
    "extend_horizon",
    "propose_trim",
    "reproject",
    "tear_horizon",
    "throw_horizon",
    "to_xtgeo",
    "triangulate_horizon",
    "write",
)
FOR_DATASETS = (
    "propose_trim",
    "reproject",
    "tear_horizon",
    "to_geodataframe",
    "to_xtgeo",
    "triangulate_fault",
    "write",
)


class Accessor:
    """Functions of geosurf with an object of xarray as their first argument."""

    names: tuple[str, ...] = ()

    def __init__(self, obj: Any) -> None:
        self._obj = obj

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in self.names:
            kind = type(self._obj).__name__ if "_obj" in self.__dict__ else "object"
            raise AttributeError(
                f"{kind}.geosurf has no function {name!r}; it has {', '.join(self.names)}"
            )
        # the package is loaded, or xarray would have no accessor; it is asked, not imported
        function: Callable[..., Any] = getattr(sys.modules["geosurf"], name)
        obj = self._obj

        @functools.wraps(function)
        def forward(*words: Any, **more: Any) -> Any:
            return function(obj, *words, **more)

        return forward

    def __dir__(self) -> list[str]:
        return sorted(self.names)

    def __repr__(self) -> str:
        return f"<geosurf for a {type(self._obj).__name__}: {', '.join(self.names)}>"


class ArrayAccessor(Accessor):
    """``DataArray.geosurf``."""

    names = FOR_ARRAYS


class DatasetAccessor(Accessor):
    """``Dataset.geosurf``."""

    names = FOR_DATASETS


def register(xarray: ModuleType) -> None:
    """Give DataArrays and Datasets their accessor, once."""
    if not hasattr(xarray.DataArray, "geosurf"):
        xarray.register_dataarray_accessor("geosurf")(ArrayAccessor)
        xarray.register_dataset_accessor("geosurf")(DatasetAccessor)


def when_xarray_is_there() -> None:
    """Register the accessors now if xarray is loaded, else as soon as it is."""
    found = sys.modules.get("xarray")
    if found is not None and hasattr(found, "register_dataset_accessor"):
        register(found)
    elif not any(isinstance(one, _Waiting) for one in sys.meta_path):
        sys.meta_path.insert(0, _Waiting())  # duck typing: importlib.abc takes 10 ms


class _Waiting:
    """A finder that sees xarray being imported, and leaves."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where xarray is, with a loader that registers afterwards; None for others."""
        if fullname != "xarray":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        if spec is not None and spec.loader is not None:
            spec.loader = _Registering(spec.loader)  # type: ignore[assignment]
        return spec


class _Registering:
    """The loader of xarray, and the registration when it is done."""

    def __init__(self, loader: Any) -> None:
        self._loader = loader

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Make the module as its own loader does."""
        made: ModuleType | None = self._loader.create_module(spec)
        return made

    def exec_module(self, module: ModuleType) -> None:
        """Load xarray, put its own loader back, register."""
        assert module.__spec__ is not None
        module.__spec__.loader = module.__loader__ = self._loader
        self._loader.exec_module(module)
        register(module)
