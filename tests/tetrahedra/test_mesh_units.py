"""One conforming mesh of all units: laws of meshes, and what is refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import geosurf as gs
from geosurf import tetrahedra
from geosurf.conventions import machine
from geosurf.errors import DependencyError, GeometryError, InputError, InvariantError
from geosurf.model import TetMesh, Units
from geosurf.tetrahedra import (
    FACES,
    N_ORDER,
    Boundary,
    boundary_of,
    fill,
    flat_parts,
    refined,
    regions_of,
    with_parts,
)
from tests.messages import refused

HAS_TETGEN = pytest.mark.skipif(
    "not __import__('importlib.util').util.find_spec('tetgen')",
    reason='TetGen (AGPL) is not installed: pip install "geosurf[tet]"',
)


def block(z: float) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of a unit cube at height z, and six tetrahedra around its diagonal."""
    x = np.array([[i, j, k + z] for k in (0, 1) for j in (0, 1) for i in (0, 1)], dtype=float)
    turns = [(1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1)]
    return x, np.array([[0, a, b, 7] for a, b in turns])


def two_cubes() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two cubes on top of each other: points, tetrahedra, the faces between, and their sides."""
    (x, low), (up, _) = block(0.0), block(1.0)
    x = np.concatenate([x, up[4:]])
    tets = np.concatenate([low, low + 4])
    faces = tets[:, FACES].reshape(-1, 3)
    unit = np.repeat([0] * 6 + [1] * 6, 4)

    # one oriented copy of each face that belongs to one cube only, or to both
    keys = [tuple(sorted(face)) for face in faces.tolist()]
    rows: dict[tuple[int, ...], list[int]] = {}
    for row, key in enumerate(keys):
        rows.setdefault(key, []).append(row)
    kept = [r for r in rows.values() if len(r) == 1 or unit[r[0]] != unit[r[1]]]
    sides = [(unit[r[1]] if len(r) == 2 else -1, unit[r[0]]) for r in kept]
    return x, tets, faces[[r[0] for r in kept]], np.array(sides)


def outward(boundary: Boundary, k: int) -> np.ndarray:
    """Faces of a unit; those with the unit in front are turned over."""
    front, behind = (boundary.faces[boundary.sides[:, side] == k] for side in (0, 1))
    return np.concatenate([behind, front[:, ::-1]])


def is_closed(faces: np.ndarray) -> bool:
    """Whether each directed edge has its opposite."""
    edges = np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)]).tolist()
    return sorted(edges) == sorted([b, a] for a, b in edges)


def assert_closed_around(boundary: Boundary, units: Units) -> None:
    """Faces of each unit are closed, and hold its volume."""
    for k, unit in enumerate(units.values()):
        faces = outward(boundary, k)
        a, b, c = (boundary.x[faces[:, i]] for i in range(3))
        volume = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6.0
        assert volume == pytest.approx(unit.volume, rel=1e-12)
        assert is_closed(faces)


@pytest.fixture(scope="module")
def units(planes: gs.Scene) -> Units:
    return planes.units


def test_the_boundary_is_closed_around_every_unit(units: Units) -> None:
    boundary = boundary_of(units)
    assert boundary.surface_names == next(iter(units.values())).surface_names
    assert_closed_around(boundary, units)


def test_units_of_tetrahedra_follow_from_faces_however_they_are_turned() -> None:
    x, tets, faces, sides = two_cubes()
    expected = [0] * 6 + [1] * 6
    assert regions_of(tets, faces, sides, len(x)).tolist() == expected
    turned = np.arange(len(faces)) % 2 == 0
    faces[turned], sides[turned] = faces[turned][:, ::-1], sides[turned][:, ::-1]
    assert regions_of(tets, faces, sides, len(x)).tolist() == expected


def test_damaged_meshes_are_found() -> None:
    x, tets, faces, sides = two_cubes()
    swapped = sides.copy()
    swapped[3] = swapped[3, ::-1]
    between = (sides >= 0).all(axis=1)
    twice = np.concatenate([faces, faces[:1]]), np.concatenate([sides, sides[:1]])
    damages = [
        ("not (shared|in the mesh)", (tets[1:], faces, sides)),
        ("in two units", (tets, faces, swapped)),
        ("in two units", (tets, faces[~between], sides[~between])),
        ("occurs twice", (tets, *twice)),
    ]
    for words, damaged in damages:
        refused(InvariantError, words, regions_of, *damaged, len(x))


def test_parts_of_split_faces_are_turned_as_the_face_and_cover_it(units: Units) -> None:
    boundary = boundary_of(units)
    n, face = len(boundary.x), boundary.faces[0]
    x = np.concatenate([boundary.x, boundary.x[face].mean(axis=0)[None]])
    parts = np.array([[face[1], face[0], n], [face[1], face[2], n], [face[2], face[0], n]])
    parts = np.concatenate([parts, boundary.faces[1:, ::-1]])
    parents = np.concatenate([[0, 0, 0], np.arange(1, len(boundary.faces))])
    found = with_parts(boundary, x, parts, parents)
    assert np.array_equal(found.faces[3:], boundary.faces[1:])
    normals = [np.cross(*(x[t[1:]] - x[t[0]])) for t in (face, *found.faces[:3])]
    assert all(normals[0] @ normal > 0 for normal in normals[1:])
    refused(InvariantError, "not in the mesh", with_parts, boundary, x, parts[1:], parents[1:])


def test_refined_faces_are_shorter_and_stay_closed(units: Units) -> None:
    fine = refined(boundary_of(units), 180.0)
    edges = fine.x[fine.faces] - fine.x[np.roll(fine.faces, 1, axis=1)]
    assert np.sqrt(np.square(edges).sum(axis=2)).max() <= 1.5 * 180.0  # flat parts; others: 180
    assert len(np.unique(fine.x, axis=0)) == len(fine.x)
    assert_closed_around(fine, units)


def test_bad_input_is_named(units: Units, monkeypatch: pytest.MonkeyPatch) -> None:
    refused(InputError, r"mesh_units takes Units.*pass scene\.units", gs.mesh_units, 3)
    refused(InputError, "no units to mesh", lambda: gs.mesh_units(Units([], (0, 1, 0, 1, 0, 1))))
    refused(InputError, "size is '10'; give a length in metres", gs.mesh_units, units, size="10")
    refused(InputError, "size is -1 m; give a length above 0", gs.mesh_units, units, size=-1)
    with pytest.raises(InputError, match=r"size=0\.1 asks for .* tetrahedra.*Give size=10 or more"):
        gs.mesh_units(units, size=0.1)
    monkeypatch.setattr(machine, "find_spec", lambda name: None)
    refused(DependencyError, r"geosurf\[tet\].*AGPL", gs.mesh_units, units)


def fan(n: int = 400) -> Boundary:
    """A wall: a flat fan of needles from one corner to a curve of many short edges."""
    along = np.linspace(0.0, 1000.0, n)
    curve = np.stack([along, 0.0 * along, 500.0 + 20.0 * np.sin(along / 90.0)], axis=1)
    x = np.concatenate([[[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0]], curve])
    rows = np.arange(2, n + 1)
    faces = np.stack([0 * rows, rows + 1, rows], axis=1)
    faces = np.concatenate([faces, [[0, 1, n + 1]]])
    same = np.zeros(len(faces), dtype=int)
    return Boundary(x, np.zeros(3), faces, np.stack([same - 1, same], 1), same, ("wall",))


def test_walls_get_few_faces_of_good_shape() -> None:
    wall = fan()
    fine = refined(wall, 100.0)
    corners = fine.x[fine.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    before = wall.x[wall.faces]
    area = np.cross(before[:, 1] - before[:, 0], before[:, 2] - before[:, 0])[:, 1].sum()

    # the area stays, no face is turned over, and needles do not multiply
    assert (np.sign(normals[:, 1]) == np.sign(area)).all()
    assert normals[:, 1].sum() == pytest.approx(area, rel=1e-12)
    assert len(fine.faces) < 2 * len(wall.faces)
    assert np.sqrt(np.square(corners - np.roll(corners, 1, axis=1)).sum(axis=2)).max() < 150.0
    flips = refined(wall)
    assert np.array_equal(flips.x, wall.x)
    assert len(flips.faces) == len(wall.faces)


def test_the_wings_of_a_folded_wall_are_flat_parts_of_their_own() -> None:
    x = np.array([[0, 0, 0], [0, 9, 0], [9, 0, 0], [9, 9, 0], [0, 0, 9], [0, 9, 9]], dtype=float)
    faces = np.array([[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4]])
    parts = flat_parts(x, faces, np.zeros(4, dtype=int), 1.0).of_face
    assert parts.min() > 0
    assert parts[0] == parts[1] != parts[2] == parts[3]


def test_an_edge_on_which_a_thin_unit_ends_is_not_flipped() -> None:
    """The wall has the same units on both sides of the edge, and two more faces end there."""
    x = np.array(
        [[0, 0, 0], [9, 0, 0], [4, 0, 1], [5, 0, -1], [12, 0, 0], [4.5, 5, 0.0], [4.5, 5, 0.1]]
    )
    wall, tip = [[0, 1, 2], [1, 0, 3], [1, 4, 2], [1, 3, 4]], [[0, 1, 5], [1, 0, 6]]

    def keeps_edge(faces: list[list[int]]) -> bool:
        kind = (np.arange(len(faces)) >= len(wall)).astype(int)
        boundary = Boundary(
            x, np.zeros(3), np.array(faces), np.stack([kind - 1, kind], 1), kind, ("wall", "tip")
        )
        return any({0, 1} <= set(face) for face in refined(boundary).faces[:4].tolist())

    assert not keeps_edge(wall)
    assert keeps_edge(wall + tip)


REFUSES = """
class TetGen:
    def __init__(self, *args):
        open("_skipped.face", "w").write("1 1\\n0 0 1 2 1\\n")
    def tetrahedralize(self, **options):
        {}
"""


@pytest.mark.parametrize(
    ("then", "words"),
    [
        (
            'raise RuntimeError("The input has self-intersections.")',
            r"self-intersections\. It leaves out 1 face of Top, the first at \(E .*\)\. Check",
        ),
        (
            'raise RuntimeError(str(options["collinear_ang_tol"]))',  # of the last order
            "180",  # edges of needles are not one edge, however narrow
        ),
        ("import os; os._exit(7)", r"its process ended \(7\).*check\(\)"),
        ("import time; time.sleep(60)", "did not end within .* other orders .* Give a size"),
    ],
)
def test_what_tetgen_refuses_is_named_and_leaves_no_files(
    then: str, words: str, units: Units, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, fake = tmp_path / "here", tmp_path / "fake"
    for folder in (here, fake):
        folder.mkdir()
    (fake / "tetgen.py").write_text(REFUSES.format(then))
    monkeypatch.chdir(here)
    monkeypatch.syspath_prepend(str(fake))
    seconds = 0.3 if "sleep" in then else 60.0
    for name in ("PATIENCE", "SHORT"):
        monkeypatch.setattr(tetrahedra, name, (seconds, 0.0))
    refused(GeometryError, f"TetGen cannot fill .*{words}", lambda: gs.mesh_units(units))
    assert not [*here.iterdir()]


@pytest.mark.parametrize("n_refused", range(N_ORDER))
def test_another_order_of_vertices_is_tried_and_turned_back(
    n_refused: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = np.array([[3.0, 1, 0], [0, 2, 0], [0, 0, 5], [1, 1, 1], [4, 4, 4]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 4]])
    sides = np.zeros((4, 2), dtype=np.int64)
    boundary = Boundary(x, np.zeros(3), faces, sides, np.zeros(4, dtype=np.int64), ("all",))
    seen: list[bytes] = []

    def run(given: Boundary, options: object, patience: float) -> dict[str, np.ndarray]:
        seen.append(given.x.tobytes())
        np.testing.assert_array_equal(given.x[given.faces], x[faces])
        if len(seen) <= n_refused:
            raise GeometryError("it did not end")
        node = np.concatenate([given.x, [[0.5, 0.5, 0.5]]])
        cells = np.column_stack([given.faces, np.full(4, 5)])
        marks = np.array([1, 2, 0, 4])
        return {"node": node, "elem": cells, "trifaces": given.faces, "markers": marks}

    monkeypatch.setattr(tetrahedra, "_run", run)
    found, cells, parts, parents = fill(boundary, None)
    np.testing.assert_array_equal(found, np.concatenate([x, [[0.5, 0.5, 0.5]]]))
    np.testing.assert_array_equal(cells, np.column_stack([faces, np.full(4, 5)]))
    np.testing.assert_array_equal(parts, faces[[0, 1, 3]])
    assert parents.tolist() == [0, 1, 3]
    assert len(set(seen)) == len(seen) == n_refused + 1


def of_cubes() -> TetMesh:
    """Two cubes as a mesh."""
    x, tets, faces, sides = two_cubes()
    surface = (sides < 0).any(axis=1).astype(int)
    names = ("Top", "wall")
    region = np.repeat([0, 1], 6)
    return TetMesh(
        x, np.array([4e5, 5e6, -2e3]), tets, region, ("below Top", "above Top"),
        faces, surface, sides, names,
    )  # fmt: skip


@pytest.mark.parametrize("suffix", [".vtu", ".msh", ".inp"])
def test_files_hold_the_mesh_and_its_units(tmp_path: Path, suffix: str) -> None:
    import meshio

    mesh = of_cubes()
    assert mesh.volumes.values.tolist() == [1.0, 1.0]
    assert repr(mesh) == "<TetMesh: 12 tetrahedra in 2 units, 12 vertices, 2 m³>"
    paths = [gs.write(mesh, tmp_path / f"{k}{suffix}")[0] for k in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()

    again = meshio.read(paths[0])
    assert np.array_equal(again.points, mesh.vertices)
    assert np.array_equal(again.cells_dict["tetra"], mesh.tetrahedra)
    if suffix == ".vtu":
        assert again.cell_data["unit"][0].tolist() == mesh.region.tolist()
    elif suffix == ".inp":
        sets = {name: rows[0].tolist() for name, rows in again.cell_sets.items()}
        assert sets == {"U1_below_Top": [*range(6)], "U2_above_Top": [*range(6, 12)]}
    else:
        tags = again.cell_data_dict["gmsh:physical"]
        assert tags["tetra"].tolist() == (mesh.region + 1).tolist()
        assert np.array_equal(again.cells_dict["triangle"], mesh.faces)
        assert tags["triangle"].tolist() == (mesh.surface_of_face + 1).tolist()
        assert {name: tuple(of) for name, of in again.field_data.items()} == {
            "below Top": (1, 3), "above Top": (2, 3), "Top": (1, 2), "wall": (2, 2),
        }  # fmt: skip


@pytest.mark.parametrize("suffix", [".exo", ".e"])
def test_exodus_has_a_block_for_each_unit(tmp_path: Path, suffix: str) -> None:
    pv = pytest.importorskip("pyvista")
    mesh = of_cubes()
    paths = [gs.write(mesh, tmp_path / f"{k}{suffix}")[0] for k in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()

    blocks = pv.ExodusIIReader(paths[0]).read()["Element Blocks"]
    assert list(blocks.keys()) == ["U1_below_Top", "U2_above_Top"]
    for k, block in enumerate(blocks):
        tets = mesh.tetrahedra[mesh.region == k]
        corners = block.points[block.cells.reshape(-1, 5)[:, 1:]]
        assert np.array_equal(corners, mesh.vertices[tets])


@HAS_TETGEN
@pytest.mark.parametrize("size", [None, 250.0])
def test_units_are_filled_exactly(planes: gs.Scene, size: float | None) -> None:
    units = planes.units
    mesh = gs.mesh_units(units, size)
    assert mesh.unit_names == tuple(units)
    np.testing.assert_allclose(mesh.volumes.values, units.volumes.values, rtol=1e-12)
    again = gs.mesh_units(units, size)
    assert np.array_equal(again.local, mesh.local)
    assert np.array_equal(again.tetrahedra, mesh.tetrahedra)
    assert mesh.to_pyvista().volume == pytest.approx(units.volume)

    # the middle of each tetrahedron is in its unit, by exact location
    middles = mesh.vertices[mesh.tetrahedra].mean(axis=1)
    large = mesh.cell_volumes > 1.0
    found = planes.sample(middles[large]).unit.values
    assert found.tolist() == [mesh.unit_names[k] for k in mesh.region[large]]


@HAS_TETGEN
def test_a_smaller_size_gives_smaller_tetrahedra(units: Units) -> None:
    coarse, fine = gs.mesh_units(units, 400.0), gs.mesh_units(units, 200.0)
    assert len(fine.tetrahedra) > 2 * len(coarse.tetrahedra)

    # some next to faces stay larger
    asked = 200.0**3 / (6.0 * 2.0**0.5)
    assert (fine.cell_volumes <= asked).mean() > 0.98
    assert fine.cell_volumes.max() < 2.0 * asked
