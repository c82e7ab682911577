"""What people hand over by mistake, by the kind of thing that is asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

import geosurf as gs


class Row(NamedTuple):
    """What is called, arguments that are right, and wrong things for single arguments.

    Arguments and wrong things may be functions of `g`, the model of test_wrong_things.py.
    """

    call: Callable[..., Any] | None
    right: Any
    wrong: dict[str, Any]


def row(right: Any, call: Callable[..., Any] | None = None, /, **wrong: Any) -> Row:
    """A row; without `call` its name in the table says what is called, of `g` or of geosurf."""
    return Row(call, right, wrong)


NAN, INF = np.nan, np.inf
DATE = np.datetime64("2001-01-01")


# nothing of this is one finite number
NUMBERS = [
    "abc", "25", b"x", [1.0], {}, object(), (1, 2, 3), NAN, INF, True, 1j, DATE, np.array([]),
    np.array([1.0, 2.0]),
]  # fmt: skip


# nothing of this is a length above 0
LENGTHS = [*NUMBERS, -1.0]


# nothing of this is west, east, south, north, bottom, top
BOXES = [
    "abc", "abcdef", 5, {}, object(), (0, 1), ("a",) * 6, [DATE] * 6, [None] * 6, (True,) * 6,
    (0, 1, 0, 1, 0, NAN), (0, 1, 0, 1, 0, INF), (1, 0, 0, 1, 0, 1), (0,) * 6,
    (0, 1j, 0, 1, 0, 1), np.zeros((2, 6)), [[0, 1], [0, 1], [0, 1]],
]  # fmt: skip


def things(g):
    """Nothing of this is a surface, a list of them, patches, units or a scene."""
    surface = g.scene.surface("F1")
    return [
        "Top", None, 5, object(), [None], ["Top"], np.zeros((3, 3)), [np.zeros((3, 3))],
        (surface, None), g.scene.box, xr.DataArray(np.zeros((2, 2))), xr.Dataset({"a": 1}),
    ]  # fmt: skip


# nothing of this is a file that can be read
PATHS = [None, 5, "", b"x", object(), [], "x", "x.unknown", "no/such.vtp", "a\0b", "."]


# nothing of this is the name of a surface
NAMES = ["Nope", "", None, 5, NAN, ["F1"], ("F1",), {}, object()]


# nothing of this is yes or no
FLAGS = ["abc", 5, NAN, None, [], np.array([1, 2])]


# nothing of this is a word that is known
WORDS = ["abc", 5, True, ["local"], {"a": 1}, object()]


# nothing of this is an array of points (n, 3)
ARRAYS = [
    None, "abc", 5, {}, object(), [], np.zeros(3), np.zeros((0, 3)), np.zeros((3, 2)),
    np.zeros((3, 3, 3)), np.full((3, 3), NAN), np.full((3, 3), INF), [[0, 0, 0], [1, 1]],
    np.array([["a"] * 3] * 3), np.array([[None] * 3] * 3), np.zeros((3, 3), complex),
    np.zeros((3, 3), "datetime64[D]"),
]  # fmt: skip


# nothing of this is a mapping of names to surfaces
MAPPINGS = [
    "abc", 5, object(), [("a", 1)], {"": 1}, {None: 1}, {"X": None}, {"X": object()},
    {"X": "no.nc"}, {"X": np.zeros((3, 3))},
]  # fmt: skip


def horizons(top):
    """Nothing of this is a gridded horizon: `top` spoilt in one place each."""
    dates = np.arange(top.easting.size).astype("datetime64[D]")
    return [
        "abc", "no.nc", None, 5, {}, [], object(), np.zeros((3, 3)), xr.DataArray(5.0),
        xr.DataArray(np.zeros((3, 3))), top.to_dataset(name="z"), {"Top": top}, top[0],
        top[:1], top[:0], top * NAN, top * INF, top > 0, top.expand_dims("time"),
        top.astype(str), top.astype(object), top.astype(complex), top.astype("datetime64[ns]"),
        top.rename(northing="q").drop_vars("q"), top.drop_vars("northing"),
        top.assign_attrs(units="furlong"), top.assign_attrs(units=5), top.assign_attrs(units=None),
        top.assign_attrs(positive="sideways"), top.assign_coords(easting=top.easting.values * NAN),
        top.assign_coords(easting=np.zeros(top.easting.size)), top.assign_coords(easting=dates),
    ]  # fmt: skip


def faults(ds):
    """Nothing of this is a fault: the Dataset `ds` spoilt in one place each."""
    stick = np.array([[0.0, 0, 0], [0, 0, -1]])
    return [
        "abc", "no.vtp", None, 5, {}, [], object(), np.zeros((3, 3)), xr.Dataset(),
        {"F1": ds}, ds.elevation, ds.drop_vars("elevation"), ds.rename(down_dip="y"),
        ds.isel(down_dip=0), ds.isel(down_dip=slice(0, 1)), ds * NAN, ds.astype(str),
        ds.astype(complex), ds.astype("datetime64[ns]"), [[1, 2, 3]], [stick], [stick, 5],
        [stick, None], [stick[:, :2], stick[:, :2]],
    ]  # fmt: skip


def throws():
    """Nothing of this is the throw of a fault."""

    def along(values, at):
        return xr.DataArray(values, dims="along_strike", coords={"along_strike": at})

    flat = xr.DataArray(np.zeros((2, 2)), dims=("northing", "easting"))
    return [
        *(value for value in NUMBERS if not callable(value)), "a line of words",
        ["a line", "of words"], [["a", "b"], ["c", "d"]], [0, 1, 2], [[0, NAN], [5, 2]], [],
        along(["a", "b"], [0.0, 1.0]), along([1.0, 2.0], ["a", "b"]), along([1.0, NAN], [0.0, 1.0]),
        along([1.0, 2.0], [1.0, 0.0]), xr.DataArray([1.0, 2.0]), flat, flat.expand_dims("time"),
        flat.assign_coords(northing=[0.0, 1.0], easting=[0.0, 0.0]),
        flat.assign_coords(northing=[0.0, 1.0], easting=["a", "b"]),
        gs.synthetic.tilted_planes(n=3).horizons["Top"] * NAN,
    ]  # fmt: skip
