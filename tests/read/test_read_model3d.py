"""GOCAD Model3d: surfaces with roles, welded; damage is named."""

from __future__ import annotations

import pytest

from geosurf.errors import FormatError
from geosurf.read.model3d import read_model3d

HEAD = """GOCAD Model3d 1
HEADER {
name:two
}
TSURF F1
TSURF Top
TFACE 1 reverse_fault F1
  0 0 0
TFACE 2 top Top
  0 0 0
REGION 3 Universe
  +1  -2  0
END
"""
TSURF = """GOCAD TSurf 1
HEADER {
name:%s
}
GOCAD_ORIGINAL_COORDINATE_SYSTEM
ZPOSITIVE Depth
END_ORIGINAL_COORDINATE_SYSTEM
TFACE
VRTX 1 0 0 100
VRTX 2 9 0 100
VRTX 3 0 9 200
TRGL 1 2 3
TFACE
VRTX 4 9 0 100
VRTX 5 9 9 200
VRTX 6 0 9 200
TRGL 4 5 6
END
"""


@pytest.fixture
def model(tmp_path):
    """Function of a text: a file that holds it."""

    def write(text: str):
        path = tmp_path / "two.ml"
        path.write_text(text)
        return path

    return write


def test_parts_are_welded_and_roles_are_those_of_the_model(model):
    surfaces = read_model3d(model(HEAD + TSURF % "F1" + TSURF % "Top"))
    assert {name: s.role for name, s in surfaces.items()} == {"F1": "fault", "Top": "horizon"}
    for surface in surfaces.values():
        assert (surface.n_vertex, surface.n_triangle) == (4, 2)
        assert surface.bounds == (0.0, 9.0, 0.0, 9.0, -200.0, -100.0)


def test_horizons_are_turned_so_that_their_normals_point_up(model):
    upside_down = (TSURF % "Top").replace("TRGL 1 2 3", "TRGL 1 3 2")
    upside_down = upside_down.replace("TRGL 4 5 6", "TRGL 4 6 5")
    for text in (TSURF % "Top", upside_down):
        top = read_model3d(model(HEAD + TSURF % "F1" + text))["Top"]
        for a, b, c in top.vertices[top.triangles][:, :, :2].tolist():
            assert (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TSURF % "F1", r"two\.ml, line 1: found 'GOCAD TSurf 1', expected .*Model3d.*read_fault"),
        (HEAD + TSURF % "F1", r"two\.ml.*'Top', but the file has no such TSurf.*\['F1'\].*Export"),
        (HEAD + 2 * (TSURF % "F1") + TSURF % "Top", r"two\.ml.*'F1' occurs twice.*Rename"),
        (HEAD.replace("TFACE 2 top Top", "TFACE 2"), r"line 9: TFACE has 1 words.*Correct"),
        (HEAD.replace("END\n", ""), r"model that begins on line 1 has no END.*export it again"),
    ],
)
def test_damage_is_named(model, text, message):
    with pytest.raises(FormatError, match=message):
        read_model3d(model(text))
