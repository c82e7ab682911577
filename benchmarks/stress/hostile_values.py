"""Hostile values: what nobody asks for, and what only looks like what is asked for."""

# ruff: noqa: E501 - a table

from __future__ import annotations

import datetime
import decimal
import fractions
import pathlib
from collections import deque
from types import MappingProxyType, SimpleNamespace

import numpy as np
import xarray as xr


class Hostile:
    """An object whose methods raise errors of its own."""

    def __init__(self, *names):
        self.names = names

    def _fail(self, name):
        if name in self.names:
            raise RuntimeError(f"hostile {name}")

    def __repr__(self):
        return f"Hostile{self.names}"


class ArrayRaises(Hostile):
    """Claims to be an array."""

    dims, coords, attrs, shape, ndim, dtype = ("northing", "easting"), {}, {}, (2, 2), 2, float

    def __array__(self, *_, **__):
        raise RuntimeError("hostile __array__")


class LengthLies(Hostile):
    """A sequence that has no elements where it says that it has some."""

    def __len__(self):
        return 3

    def __getitem__(self, _):
        raise RuntimeError("hostile __getitem__")


class IterationRaises(Hostile):
    """Breaks off when it is iterated."""

    def __iter__(self):
        yield 0.0
        raise RuntimeError("hostile __iter__")


class NumberRaises(Hostile):
    """Is no number when it is asked for one."""

    def __float__(self):
        raise RuntimeError("hostile __float__")

    __int__ = __index__ = __float__


class PathRaises(Hostile):
    """Is no path when it is asked for one."""

    def __fspath__(self):
        raise RuntimeError("hostile __fspath__")


class PathIsNone(Hostile):
    """Gives None as its path."""

    def __fspath__(self):
        return None


class Name(str):
    """Text of a class of its own."""

    __slots__ = ()


def count_up():
    """A generator: it can be gone through once."""
    yield from (1.0, 2.0, 3.0)


def grid(values, easting=None, northing=None, dims=("northing", "easting"), **attrs):
    """A gridded horizon, spoilt by what it is given."""
    values = np.asarray(values)
    n, m = (*values.shape, 1, 1)[:2]
    coords = {
        dims[0]: np.arange(n) * 1000.0 if northing is None else northing,
        dims[1]: np.arange(m) * 1000.0 if easting is None else easting,
    }
    words = {"units": "m", "positive": "up", **attrs}
    return xr.DataArray(values, coords, dims, attrs=words)


NAN, INF = np.nan, np.inf
LEVEL = np.full((4, 5), -2000.0)
SQUARE = [[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]

# functions, since some values can be used up
POOL = [
    # numbers
    *(lambda v=v: v for v in (
        None, True, False, 0, 1, -1, 2, 7, 10**9, 10**400, -(10**400), 0.0, -0.0, 0.5, 1e-320,
        1e-300, 1e300, -1e308, NAN, INF, -INF, 1j, complex(1, NAN), decimal.Decimal("1.5"),
        decimal.Decimal("NaN"), decimal.Decimal("sNaN"), fractions.Fraction(1, 3),
        np.float32(3.5), np.float64(NAN), np.int8(-3), np.uint64(2**63), np.bool_(True),
        np.longdouble(2.5), np.complex64(1), np.datetime64("2001-01-01"), np.timedelta64(5, "D"),
        datetime.date(2001, 1, 1), datetime.timedelta(1), np.float16(2),
    )),
    # text and bytes
    *(lambda v=v: v for v in (
        "", " ", "abc", "Top", "F1", "F1+", "top", "Top/Base", "up", "down", "m", "ft", "1", "NaN",
        "\ud800", "a\0b", "a\nb", "$\\bad{", "%s{0}", "\u50a8\u5c42", "\u202e", "x" * 5000, "é",
        "../..", "~", ".", "no.nc", "no.ts", "no/such/x.png", "x.png", "x.vtp", Name("Top"),
        Name("\ud800"), b"abc", bytearray(b"Top"), memoryview(b"x"), np.str_("Top"),
        np.bytes_(b"Top"), pathlib.Path("no.gri"), pathlib.Path(), pathlib.PurePosixPath("a.ts"),
        pathlib.PureWindowsPath("a\\b.nc"),
    )),
    # containers
    *(lambda v=v: v() for v in (
        list, dict, set, tuple, frozenset, deque, count_up, lambda: iter([]), lambda: range(3),
        lambda: slice(1, 2), lambda: [None], lambda: [[]], lambda: [0, [1, 2]], lambda: [[1, 2], [3]],
        lambda: (1, 2, 3), lambda: (0, 1, 0, 1, 0, 1), lambda: (0, 9, 0, 9, 9, 0), lambda: [NAN] * 6,
        lambda: (1e300,) * 6, lambda: [10**400] * 6, lambda: {None: 1}, lambda: {"": 1},
        lambda: {"\ud800": -2000.0}, lambda: {1.5: "Top"}, lambda: {"F1": None}, lambda: {"Top": "x"},
        lambda: {"F1": ("F2", "footwall")}, lambda: {"F1": 5.0}, lambda: {"F1": [NAN, 1]},
        lambda: {("a",): 1}, lambda: {"OWC": -2100.0}, lambda: {"OWC": 1e300}, lambda: {"Top": 1},
        lambda: MappingProxyType({"F1": 1}), lambda: SimpleNamespace(box=1, surfaces=2, units=3),
        lambda: ["Top", "Top"], lambda: ["F1", None], lambda: [""], lambda: {"F1": {"F1": {}}},
        lambda: [(0, 0), (0, 0)], lambda: [(0, 0), (1e300, 1)], lambda: [(0, 0), (NAN, 1)],
        lambda: [(0, 0), (1, 1), (0, 1), (1, 0)], lambda: ([[0, 0, 0]] * 3, [[0, 1, 2]]),
        lambda: (SQUARE, [[0, 1, 9]]), lambda: (SQUARE, [[0.0, 1.5, 2]]), lambda: (SQUARE, [[0, 1, 2]]),
        lambda: [0.0] * 1000, lambda: ["x"] * 7,
    )),
    # arrays
    *(lambda v=v: v() for v in (
        lambda: np.array(5.0), lambda: np.array(None), lambda: np.array("Top"), lambda: np.array([]),
        lambda: np.empty((0, 3)), lambda: np.empty((3, 0)), lambda: np.zeros(3), lambda: np.zeros(6),
        lambda: np.zeros((2, 2)), lambda: np.zeros((3, 2)), lambda: np.zeros((3, 3)),
        lambda: np.ones((3, 3, 3)), lambda: np.full((3, 3), NAN), lambda: np.full((4, 3), INF),
        lambda: np.full((3, 3), 1e300), lambda: np.full((3, 2), -1e308), lambda: np.eye(3) * 1e-320,
        lambda: np.eye(3, dtype=complex), lambda: np.eye(3, dtype=np.float16), lambda: np.eye(3) > 0,
        lambda: np.array([[None] * 3] * 3), lambda: np.array([["a"] * 2] * 3),
        lambda: np.array([["1"] * 3] * 3), lambda: np.array([10**400] * 3),
        lambda: np.array(["2001-01-01"] * 6, "datetime64[D]"), lambda: np.arange(6)[::-2],
        lambda: np.zeros(3, dtype=[("a", float), ("b", int)]), lambda: np.eye(3).view(np.recarray),
        lambda: np.ma.masked_all((3, 3)), lambda: np.ma.array(np.eye(3), mask=np.eye(3) > 0),
        lambda: np.ma.masked, lambda: np.asfortranarray(np.arange(12.0).reshape(4, 3)),
        lambda: np.broadcast_to(1.0, (5, 3)), lambda: np.arange(9.0).reshape(3, 3).astype(">f8"),
        lambda: np.array([[0, 1, 2]], dtype=np.uint64) + np.uint64(2**63), lambda: np.zeros((1,) * 20),
    )),
    # labelled arrays
    *(lambda v=v: v() for v in (
        lambda: grid(LEVEL), lambda: grid(LEVEL, units="furlong"), lambda: grid(LEVEL, units=5),
        lambda: grid(LEVEL, positive=None), lambda: grid(LEVEL, crs="EPSG:x"), lambda: grid(LEVEL, crs=5),
        lambda: grid(LEVEL, grid_mapping=5), lambda: grid(LEVEL, grid_mapping="nope"),
        lambda: grid(LEVEL, name=object()), lambda: grid(LEVEL * NAN), lambda: grid(LEVEL * 1e300),
        lambda: grid(LEVEL[:1]), lambda: grid(LEVEL[:0]), lambda: grid(LEVEL.astype(str)),
        lambda: grid(LEVEL.astype(object)), lambda: grid(LEVEL, easting=[0, 1, 1, 2, 3]),
        lambda: grid(LEVEL, easting=[0, NAN, 1, 2, 3]), lambda: grid(LEVEL, easting=list("abcde")),
        lambda: grid(LEVEL, easting=[0, 1, 2, 3, 1e300]), lambda: grid(LEVEL, dims=("y", "x")),
        lambda: grid(LEVEL, easting=np.arange(5).astype("datetime64[D]")), lambda: grid(LEVEL).T,
        lambda: grid(LEVEL)[0], lambda: grid(LEVEL).expand_dims("time"), lambda: xr.DataArray(5.0),
        lambda: grid(LEVEL, easting=[0, 1e-320, 2e-320, 3e-320, 4e-320]), lambda: xr.Dataset(),
        lambda: xr.Dataset({"a": 1}), lambda: xr.Dataset({"elevation": grid(LEVEL)}),
        lambda: xr.Dataset({k: ("point", [0.0, NAN]) for k in ("easting", "northing", "elevation")}),
        lambda: xr.Dataset({k: (("down_dip", "along_strike"), np.zeros((2, 2)))
                            for k in ("easting", "northing", "elevation")}),
        lambda: xr.DataArray(np.ma.masked_all((2, 2))), lambda: xr.Variable("x", [1]),
        lambda: xr.DataArray([1.0, 2], {"along_strike": [1, 0]}, "along_strike"),
    )),
    # objects
    *(lambda v=v: v() for v in (
        object, lambda: object, lambda: (lambda *_: None), lambda: NotImplemented, lambda: Ellipsis,
        ArrayRaises, LengthLies, IterationRaises, NumberRaises, PathRaises, PathIsNone,
        lambda: np, lambda: ValueError("x"), lambda: open, lambda: type("T", (), {})(),
    )),
]  # fmt: skip
