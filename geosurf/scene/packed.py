"""Results as bytes, and back: JSON for their structure, raw numbers for their arrays. No pickle.

Only the classes in `_CLASSES` are known, and unpacking calls their constructors: a file can hold
wrong numbers, but it cannot run code. Whoever reads one checks where it came from
(`geosurf.files.sealed`).
"""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np

from geosurf.errors import GeosurfWarning
from geosurf.model import (
    Certificate,
    FaultCut,
    Lattice,
    Sheet,
    SheetReport,
    ThrowReport,
    TriSurface,
)
from geosurf.model.certificate import Check
from geosurf.model.needed_faults import Extended, NeededFaults
from geosurf.model.sectors import Sector
from geosurf.model.sheet_report import LostThrow
from geosurf.model.tear_plan import BaseHeights, DataUse, TearPlan

_CLASSES: dict[str, type] = {
    one.__name__: one
    for one in (
        BaseHeights,
        Certificate,
        Check,
        DataUse,
        Extended,
        FaultCut,
        Lattice,
        LostThrow,
        NeededFaults,
        Sector,
        Sheet,
        SheetReport,
        TearPlan,
        ThrowReport,
    )
}
_HEAD = 16  # digits of the length of the JSON text
_ALIGN = 8


def packed(value: Any) -> bytes:
    """
    Return a result as bytes.

    Parameters
    ----------
    value : Sheet, TriSurface, array, number, text, None, or lists, tuples and dicts of these

    Returns
    -------
    bytes

    Raises
    ------
    TypeError
        For anything else.

    Examples
    --------
    >>> unpacked(packed({"a": (1, 2.5, np.arange(3))}))
    {'a': (1, 2.5, array([0, 1, 2]))}
    >>> packed(object())
    Traceback (most recent call last):
    TypeError: object cannot be packed
    """
    arrays: list[bytes] = []
    tree = json.dumps(_tree(value, arrays)).encode()
    tree += b" " * (-len(tree) % _ALIGN)
    return b"".join([f"{len(tree):0{_HEAD}d}".encode(), tree, *arrays])


def unpacked(data: bytes) -> Any:
    """
    Return what `packed` was given; arrays are read-only.

    Raises
    ------
    ValueError, KeyError, TypeError, GeosurfError
        For other bytes.
    """
    end = _HEAD + int(data[:_HEAD])
    return _value(json.loads(data[_HEAD:end]), data, [end])


def _tree(value: Any, arrays: list[bytes]) -> Any:
    """The structure of a value; the bytes of its arrays are appended to a list."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, np.generic):  # before float: np.float64 is one
        return ["number", _tree(np.asarray(value), arrays)]
    if type(value) is np.ndarray and value.dtype.kind in "biuf":
        return ["array", *_raw(value, arrays)]
    if type(value) in (tuple, list):
        return [type(value).__name__, *(_tree(part, arrays) for part in value)]
    if type(value) is dict:
        return ["dict", *([_tree(k, arrays), _tree(v, arrays)] for k, v in value.items())]
    if type(value) is GeosurfWarning:
        return ["warning", *(_tree(part, arrays) for part in value.args)]
    if type(value) is TriSurface:
        # arrays that a lattice implies are made again; those that somebody has read are at hand
        made = "vertices" in value.__dict__ and "triangles" in value.__dict__
        mesh = (value.vertices, value.triangles) if made else (None, None)
        parts = (value.name, value.role, *mesh, value.lattice, value.vertex_data, value.crs)
        return ["surface", *(_tree(part, arrays) for part in parts)]
    name = type(value).__name__
    if _CLASSES.get(name) is not type(value):
        raise TypeError(f"{name} cannot be packed")
    fields = {one.name: getattr(value, one.name) for one in dataclasses.fields(_CLASSES[name])}
    crs = getattr(value, "crs", None)
    return ["object", name, _tree(fields, arrays), _tree(crs, arrays)]


def _raw(array: np.ndarray, arrays: list[bytes]) -> tuple[str, list[int], str]:
    """Kind, shape and order of an array, whose bytes go to a list."""
    # the order in memory decides in which order numpy adds: it belongs to the result
    order = "C" if array.flags.c_contiguous or not array.flags.f_contiguous else "F"
    raw = array.tobytes(order)  # type: ignore[arg-type]
    arrays.append(raw + b"\0" * (-len(raw) % _ALIGN))
    return array.dtype.str, list(array.shape), order


def _value(tree: Any, data: bytes, at: list[int]) -> Any:
    """A value from its structure; `at` is where its first array begins, and is moved on."""
    if not isinstance(tree, list):
        return tree
    kind, *parts = tree
    if kind == "array":
        return _array(parts, data, at)
    if kind == "dict":
        return {_value(k, data, at): _value(v, data, at) for k, v in parts}
    if kind == "object":
        return _object(parts, data, at)
    found = [_value(part, data, at) for part in parts]
    if kind == "number":
        return found[0][()]
    if kind == "tuple":
        return tuple(found)
    if kind == "list":
        return found
    if kind == "warning":
        return GeosurfWarning(*found)
    if kind == "surface":
        name, role, vertices, triangles, lattice, vertex_data, crs = found
        surface = TriSurface(
            name, role, vertices, triangles, lattice=lattice, vertex_data=vertex_data
        )
        return _with_crs(surface, crs)
    raise ValueError(f"{kind!r} is not known")


def _array(parts: list[Any], data: bytes, at: list[int]) -> np.ndarray:
    """An array from the bytes after the last one."""
    kind, shape, order = parts
    dtype = np.dtype(kind)
    if dtype.kind not in "biuf":
        raise ValueError(f"arrays of {kind!r} are not known")
    n = int(np.prod(shape, dtype=np.int64))
    raw = np.frombuffer(data, dtype, n, at[0]).copy()
    at[0] += raw.nbytes + -raw.nbytes % _ALIGN
    found = raw.reshape(shape, order=order)
    found.flags.writeable = False
    return found


def _object(parts: list[Any], data: bytes, at: list[int]) -> Any:
    """One of the known classes, made by its constructor."""
    name, fields, crs = parts
    found = _CLASSES[name](**_value(fields, data, at))
    return _with_crs(found, _value(crs, data, at))


def _with_crs(made: Any, crs: str | None) -> Any:
    if crs is not None:
        object.__setattr__(made, "crs", crs)  # dataclasses among them are frozen
    return made
