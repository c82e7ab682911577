"""What people hand over by mistake: numbers that are none, arrays that change later."""

from __future__ import annotations

import warnings
from functools import cache
from operator import attrgetter
from types import SimpleNamespace

import numpy as np
import pytest

import geosurf as gs
from benchmarks.stress.random_arguments import outcome, run
from geosurf.errors import GeometryError, InputError, InvariantError
from tests.invalid_input.building import BUILDING
from tests.invalid_input.showing import SHOWING


def test_a_surface_does_not_change_with_the_arrays_it_was_made_of():
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    triangles = np.array([[0, 1, 2]])
    one = gs.TriSurface("A", "surface", vertices, triangles)
    before = one.vertices.tobytes(), one.triangles.tobytes()
    vertices[:], triangles[:] = 9.0, 0
    assert (one.vertices.tobytes(), one.triangles.tobytes()) == before


def test_arrays_that_nobody_can_write_to_are_not_copied():
    triangles = np.array([[0, 1, 2]])
    triangles.flags.writeable = False
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    assert np.shares_memory(gs.TriSurface("A", "surface", vertices, triangles).triangles, triangles)


# ---- Random arguments at every public function end by a result or by an error of geosurf.
def test_random_arguments_bring_out_no_foreign_exception():
    """As many as seconds allow; `random_arguments` makes thousands."""
    ended, defects = run(100, seed=7)
    assert defects == {}
    assert ended.total() == 100
    assert ended["taken"] > 2
    assert ended["refused"] > 25


def test_a_foreign_exception_and_a_foreign_warning_are_defects():
    """The run can fail: what is no error of geosurf is found."""

    def fails(value):
        return 1 / value

    def warns(value):
        warnings.warn("deprecated", DeprecationWarning, stacklevel=1)

    with warnings.catch_warnings(action="error"):
        assert outcome("fails", fails, [], {"value": 0}) == ("defect", ": ZeroDivisionError")
        assert outcome("warns", warns, [], {"value": 0}) == ("defect", ": DeprecationWarning")
    assert outcome("fails", fails, [], {"values": 0})[0] == "no such argument"
    assert outcome("fails", fails, [], {"value": 2})[0] == "taken"


# ---- Wrong things are typed into every public function: each is told in a sentence, none is taken.
ROWS = {**BUILDING, **SHOWING}
NAMED = ("voxel_size", "reach", "exaggeration", "tolerance", "noise", "spacing")
CASES = [(name, argument) for name, row in ROWS.items() for argument in row.wrong]


@cache
def given():
    """A model, and a horizon with a fault that tears it; made once for all cases."""
    world, torn = gs.synthetic.tilted_planes(n=5), gs.synthetic.torn("normal", n=21)
    scene = gs.Scene(world.horizons, world.faults, world.box)
    network = scene.propose_fault_network()
    grid = torn.horizons["Top"]
    return SimpleNamespace(
        world=world, scene=scene, top=world.horizons["Top"], fault=world.faults["F1"],
        grid=grid, faults=torn.faults, patches=scene.patches, units=scene.units, box=world.box,
        surfaces=list(scene.surfaces), network=network, f1=scene.surface("F1"),
        thickness=scene.thickness("Top/Base", 1000.0), allan=scene.allan("F1"),
        table=scene.juxtaposition("F1", "all"), curves=scene.curves,
    )  # fmt: skip


def called(name, g):
    """What a row names: a method of the model, or a function of geosurf."""
    return attrgetter(name)(g if hasattr(g, name.split(".")[0]) else gs)


@pytest.mark.parametrize(("name", "argument"), CASES)
def test_wrong_things_are_told_in_a_sentence(name, argument, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    row, g = ROWS[name], given()
    call = row.call or called(name, g)
    right, things = (one(g) if callable(one) else one for one in (row.right, row.wrong[argument]))
    for value in things:
        shown = f"{name}({argument}={value!r})"
        with pytest.raises((InputError, GeometryError)) as caught:
            pytest.fail(f"{shown} gave {call(**right | {argument: value})!r}")
        words = str(caught.value)
        assert not isinstance(caught.value, InvariantError), shown
        assert words.endswith((".", "?", ")", '"')), f"{shown}: {words}"
        assert words.count(" ") > 3, f"{shown}: {words}"
        assert argument in words or argument not in NAMED, f"{shown}: {words}"
    assert not list(tmp_path.iterdir()), "a refused call leaves no files"


def test_every_public_function_is_among_them():
    """A new one needs a line here."""
    handed_out = {  # by stages; nobody makes them
        "Certificate", "Curves", "FaultCut", "FaultNetwork", "NetworkTrial", "Lattice", "Patches",
        "Sheet", "SheetReport", "ThrowAudit", "ThrowReport", "TrimProposal", "Unit", "Units",
        "EllipticThrow", "GeosurfWarning", "TetMesh", "CornerPointGrid", "FileInfo",
    }  # fmt: skip
    public = {name for name in gs.__all__ if callable(getattr(gs, name))}
    assert public - {*ROWS} <= handed_out
