"""Sealed models as RESQML: units out are units in; patches share the nodes of lines."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import geosurf as gs
from geosurf.cli import main
from geosurf.errors import FormatError, OutputError
from geosurf.write.model3d import parts_of
from geosurf.write.resqml_framework import lines_of, shells_of
from tests.read.test_resqml import edited
from tests.write.sealed import assert_equal

pytest.importorskip("h5py")


def written(units, folder, name="m"):
    return gs.write(units, folder / f"{name}.epc", name="m")[0]


def test_packages_of_other_programs_name_zones_only(graben, tmp_path):
    labels = "<resqml2:ExtraMetadata>.*?</resqml2:Value></resqml2:ExtraMetadata>"
    path = edited(written(graben, tmp_path), (labels, ""))
    back = gs.read_units(path)
    assert [u.zone for u in back.values()] == [u.zone for u in graben.values()]
    assert [u.volume for u in back.values()] == pytest.approx([u.volume for u in graben.values()])
    assert len(set(back)) == len(graben)


@pytest.mark.parametrize("model", ["graben", "slit"])
def test_each_edge_where_parts_meet_is_on_one_line_with_all_its_sides(model, request):
    units = request.getfixturevalue(model)
    parts = parts_of(units)
    expected = Counter()
    for k in range(len(parts.surface)):
        mine = parts.triangles[parts.first_triangle[k] : parts.first_triangle[k + 1]]
        edges = {(t[i], t[(i + 1) % 3]) for t in mine.tolist() for i in range(3)}
        for a, b in edges:
            if (b, a) not in edges:
                ends = sorted([tuple(parts.vertices[a]), tuple(parts.vertices[b])])
                expected[tuple(ends)] += 1

    found = Counter()
    for line in lines_of(parts):
        places = parts.vertices[line.vertices]
        assert (places == places[0]).all()
        assert len({tuple(row) for row in line.vertices.tolist()}) == len(line.parts) >= 2
        for side in places:
            for a, b in zip(side[:-1].tolist(), side[1:].tolist(), strict=True):
                found[tuple(sorted([tuple(a), tuple(b)]))] += 1
    assert found == Counter({edge: n for edge, n in expected.items() if n > 1})


def test_a_shell_inside_of_a_unit_is_an_inner_one(slit):
    """Parts of a fault that touches no border of its unit are a shell of their own."""
    parts = parts_of(slit)
    lines = lines_of(parts)
    shells = shells_of(parts, lines, len(slit))
    for unit, mine in enumerate(shells[:-1]):
        listed = Counter(face for shell in mine for face in shell)
        sides = [(k, s == 0) for k, s in np.argwhere(parts.sides == unit).tolist()]
        assert listed == Counter(sides)
    assert len(shells[-1]) == 1
    alone = shells_of(parts, [], len(slit))
    assert all(len(shell) <= 2 for mine in alone for shell in mine)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<resqml2:SideIsPlus>true", "<resqml2:SideIsPlus>false", "lie on the same side|closed"),
        ("<resqml2:PatchIndexOfRepresentation>0<", "<resqml2:PatchIndexOfRepresentation>99<",
         "names patch 99 of surface"),
        ("obj_SealedVolumeFrameworkRepresentation", "obj_Other", "0 sealed volume frameworks"),
        ("<resqml2:Name>geosurf.model", "<resqml2:Name>geosurf.unit", "describes"),
        ("<resqml2:Value>", "<resqml2:Value>{", "metadata .* is damaged"),
        ('"above OWC"', "5", "damaged labels"),
        ("<resqml2:BasedOn .*?</resqml2:BasedOn>", "", "has no BasedOn"),
        ("<resqml2:Represents .*?</resqml2:Represents>", "", "has no Represents"),
        ("<resqml2:ExternalShell>.*?</resqml2:MacroFaces>", "<resqml2:ExternalShell>",
         "is not closed near"),
    ],
)  # fmt: skip
def test_damage_is_named(graben, tmp_path, old, new, words):
    path = edited(written(graben, tmp_path), (old, new))
    with pytest.raises(FormatError, match=words):
        gs.read_units(path)


def test_convert_takes_the_units_where_the_target_does(graben, tmp_path, capsys):
    path = written(graben, tmp_path)
    assert main(["convert", str(path), str(tmp_path / "m.ml")]) == 0
    assert "read with read_units" in capsys.readouterr().out
    assert_equal(gs.read_units(tmp_path / "m.ml"), graben)


def test_no_units_are_refused(graben, tmp_path):
    with pytest.raises(OutputError, match="no units"):
        gs.write(gs.Units([], graben.box), tmp_path / "m.epc")
    assert not list(tmp_path.iterdir())
