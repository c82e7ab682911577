"""A scene never changes, and its warnings are issued once; copies and pickles still work."""

from __future__ import annotations

import copy
import gc
import pickle
import warnings

import numpy as np
import pandas as pd
import pytest

import geosurf as gs
from geosurf.cli.console import printed_warnings
from geosurf.errors import InputError, warn
from geosurf.scene.inputs import INPUTS
from geosurf.scene.memory import Memory


@pytest.mark.parametrize("name", INPUTS)
def test_inputs_cannot_be_set(graben, name):
    with pytest.raises(InputError, match=rf"scene\.{name} cannot be set.*scene\.replace\({name}="):
        setattr(graben, name, None)
    with pytest.raises(InputError, match="cannot be changed"):
        delattr(graben, name)


def test_what_is_shown_cannot_be_changed_in_place(graben):
    with pytest.raises(TypeError):
        graben.extend["F1"] = ("up",)
    with pytest.raises(TypeError):
        graben.truncations["F1"] = ("F2", "+")
    graben.column["Top"] = "erosional"
    assert graben.column["Top"] == "conformable"


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_copies_are_scenes_of_their_own(graben, again):
    ruled = graben.replace(extend={"F1": "up"})
    other = again(ruled)
    assert dict(other.extend) == {"F1": ("up",)}
    assert other.surface("F1").n_triangle == ruled.surface("F1").n_triangle
    del ruled
    gc.collect()
    assert len(other.units) == 12
    with pytest.raises(InputError, match="cannot be set"):
        other.box = None


@pytest.mark.parametrize("of", ["horizon", "arrays of a fault", "file", "area", "tops"])
def test_inputs_that_changed_after_the_first_was_read_are_refused_by_name(tmp_path, of):
    world = gs.synthetic.graben(n=9)
    top, base = (world.horizons[name].copy() for name in ("Top", "Base"))
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    arrays = (np.array(fault.vertices), np.array(fault.triangles))
    path = tmp_path / "base.nc"
    base.to_netcdf(path)
    area = np.array([[500.0, 300], [3500, 300], [3500, 1700], [500, 1700]])
    table = {"well": ["A"], "horizon": ["Top"], "easting": [900.0], "northing": [900.0]}
    tops = pd.DataFrame(table | {"elevation": [-2100.0]})
    given = {"Top": top, "Base": path if of == "file" else base}
    scene = gs.Scene(given, {"F1": arrays}, aoi=area, tops=tops)
    assert scene.surface("Top").n_triangle == 128
    if of == "horizon":
        base += 50.0
    elif of == "file":
        (base + 50.0).assign_attrs(base.attrs).to_netcdf(path)
    elif of == "area":
        area += 50.0
    elif of == "tops":
        tops.loc[0, "well"] = "B"
    else:
        arrays[0][:, 0] += 50.0
    words = {"horizon": "'Base'", "file": "the file .*base.nc", "area": "'aoi'", "tops": "'tops'"}
    words = words.get(of, "'F1'")
    with pytest.raises(InputError, match=rf"{words} has changed since .* Make a new scene"):
        _ = scene.units, scene.tops


@pytest.mark.parametrize("name", ["area", "aoi", "tops"])
def test_a_horizon_may_be_called_as_another_input(name):
    world = gs.synthetic.graben(n=9)
    top, base = (world.horizons[one] for one in ("Top", "Base"))
    area = np.array([[500.0, 300], [3500, 300], [3500, 1700], [500, 1700]])

    def scene_of(top):
        return gs.Scene({name: top, "Base": base}, {}, world.box, aoi=area)

    deeper = (top - 20.0).assign_attrs(top.attrs)
    scene = scene_of(top)
    before = scene.volumes
    after = scene.replace(horizons={name: deeper}).volumes
    assert after.identical(scene_of(deeper).volumes)
    assert not after.identical(before)
    area += 50.0
    assert scene.replace(aoi=area).volumes.identical(scene_of(top).volumes)


@pytest.mark.parametrize("of", ["file", "arrays of a fault"])
def test_a_replaced_scene_has_the_data_that_the_first_one_read(tmp_path, of):
    world = gs.synthetic.graben(n=9)
    path = tmp_path / "top.nc"
    world.horizons["Top"].to_netcdf(path)
    fault = gs.triangulate_fault(world.faults["F1"], name="F1")
    arrays = (np.array(fault.vertices), np.array(fault.triangles))
    scene = gs.Scene({"Top": path, "Base": world.horizons["Base"]}, {"F1": arrays}, world.box)
    before = float(scene.volumes.sel(unit="Top/Base F1+").sum())
    if of == "file":
        lifted = world.horizons["Top"] + 20.0
        lifted.assign_attrs(world.horizons["Top"].attrs).to_netcdf(path)
    else:
        arrays[0][:, 0] += 100.0
    after = scene.replace(contacts={"OWC": -2250.0}).volumes
    mine = after.where(after["zone"] == "Top/Base", 0.0)
    assert float(mine.where(after["block"] == "F1+", 0.0).sum()) == pytest.approx(before)
    named = {"horizons": {"Top": path}} if of == "file" else {"faults": {"F1": arrays}}
    assert float(scene.replace(**named).volumes.sel(unit="Top/Base F1+")) != before


def test_what_a_setting_means_is_kept_as_it_was_given():
    """Faults and horizons that are added, or come back, have the settings of a fresh scene."""
    world = gs.synthetic.graben(n=9)
    for given in (
        {"extend": True}, {"extend": "F2"}, {"lengthen": 40.0}, {"compartments": ["F1", "F2"]},
        {"extend": {"F2": "up"}, "column": {"Base": "base"}},
    ):  # fmt: skip
        fresh = gs.Scene(world.horizons, world.faults, world.box, **given)
        fault, horizon = world.faults["F2"], world.horizons["Base"]
        less = fresh.replace(faults={"F2": None}, horizons={"Base": None})
        back = less.replace(faults={"F2": fault}, horizons={"Base": horizon})
        for name in ("extend", "column"):
            assert getattr(back, name) == getattr(fresh, name)
        assert back._inputs.lengthen == fresh._inputs.lengthen
        assert back._inputs.compartments == fresh._inputs.compartments
        assert "F2" not in less.extend
        assert less.replace(extend=None).replace(faults={"F2": fault}).extend == {}


# ---- What a scene warns of: kept with results, issued once, listed whatever was asked for fir
NOTE = gs.GeosurfWarning("spike", "Top", "One node stands out by 900 m.", "Remove it.", (1, 2, 3))
OTHER = gs.GeosurfWarning("area", "box", "The box covers 18 % of the field.", "Give aoi=.")


def told(memory, *notes, key="key"):
    """A step that warns."""
    return memory.get_or_compute("stage", "Top", key, lambda: list(map(warn, notes)), str)


def test_a_step_keeps_its_warnings_and_issues_each_once():
    memory = Memory()
    with warnings.catch_warnings(record=True, action="always") as issued:
        told(memory, NOTE, NOTE, OTHER)
        told(memory, NOTE, OTHER)
        told(memory, OTHER, key="another")
    assert [one.message for one in issued] == [NOTE, OTHER] == memory.warnings
    assert issued[0].filename == __file__  # the line of who asked, not one inside geosurf


def test_the_command_line_prints_each_once(capsys):
    with printed_warnings():
        for note in (NOTE, OTHER, NOTE):
            warnings.warn(note, stacklevel=1)
    assert capsys.readouterr().err.splitlines() == [
        f"geosurf: warning: {note}" for note in (NOTE, OTHER)
    ]
