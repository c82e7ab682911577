"""Other packages, each in a few lines: what they take, what is timed, what comes out.

None of them is needed: ``pip install -r benchmarks/requirements.txt`` brings those that a registry
has. They run in processes of their own, so that one that crashes takes nothing with it. Vertices
and triangles are made before the clock starts, and so is the package's own mesh where it has one.

==============  ==========================================================================
compas_cgal     CGAL's curve of two meshes, and its split of the first one; exact
loop_cgal       CGAL's corefinement of two open surfaces; exact
libigl          remeshing of any soup, cells; exact, through CGAL
trueform        curves and splits of meshes; exact, non-commercial licence: not in requirements.txt
manifold3d      Booleans of solids
vtk             vtkIntersectionPolyDataFilter; float32 points
trimesh         slice by one plane without ends
==============  ==========================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.scenes import Mesh, Setting
from benchmarks.solids import body_below, body_beside
from benchmarks.starts import start_process
from benchmarks.tasks import TASKS, Task, pieces_answer, segments_answer
from geosurf.conventions import did_you_mean
from geosurf.errors import InputError

HOW_TO_INSTALL = "not installed: pip install -r benchmarks/requirements.txt"


@dataclass(frozen=True)
class Peer:
    """A package that is compared.

    Attributes
    ----------
    name : str
    module : str
        That is imported.
    package : str
        As it is installed.
    tasks : dict of str to Task
        What it can do: "curve", "split", "units", "carve".
    most : float
        Largest number of triangles that it is asked for.
    """

    name: str
    module: str
    package: str
    tasks: dict[str, Task] = field(default_factory=dict)
    most: float = 3e7

    @property
    def available(self) -> bool:
        """Whether it is installed; nothing is imported."""
        return find_spec(self.module) is not None

    @property
    def version(self) -> str:
        """Of the installed package, or an empty string."""
        try:
            return version(self.package) if self.available else ""
        except PackageNotFoundError:
            return "unknown"


def find_peer(name: str) -> Peer:
    """Return a peer by name, or say which there are.

    Examples
    --------
    >>> find_peer("vtk").module
    'vtk'
    """
    for peer in PEERS:
        if peer.name == name:
            return peer
    names = [peer.name for peer in PEERS]
    raise InputError(f"no peer is called {name!r}; there are {names}.{did_you_mean(name, names)}")


# ---- what most of them share -----------------------------------------------------------


def _meshes(setting: Setting, options: dict) -> list[Mesh]:
    if "meshes" not in setting.truth:
        setting.truth["meshes"] = setting.meshes()
    return setting.truth["meshes"]


def _soup(setting: Setting, options: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """All meshes as one: vertices, triangles, and the mesh of each triangle."""
    meshes = _meshes(setting, options)
    starts = np.cumsum([0, *(len(v) for v, _ in meshes)])
    owner = np.repeat(np.arange(len(meshes)), [len(f) for _, f in meshes])
    faces = [f + start for (_, f), start in zip(meshes, starts, strict=False)]
    return np.concatenate([v for v, _ in meshes]), np.concatenate(faces), owner


def _common_edges(vertices: np.ndarray, faces: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """Edges (n, 2, 3) that triangles of different owners share."""
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    faces = same.reshape(-1)[faces]
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    key = edges[:, 0] * np.int64(len(first)) + edges[:, 1]
    pairs = np.unique(np.stack([key, np.repeat(owner, 3)], axis=1), axis=0)[:, 0]
    key, count = np.unique(pairs, return_counts=True)
    shared = key[count > 1]
    ends = np.stack([shared // len(first), shared % len(first)], axis=1)
    return vertices[first[ends]]


def _joined(parts: list[Mesh]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    setting = Setting("", [], truth={"meshes": parts})
    return _soup(setting, {})


def _area_error(setting: Setting, vertices: np.ndarray, faces: np.ndarray) -> float:
    whole, triangles, _ = _soup(setting, {})
    middle = whole.mean(axis=0)
    return pieces_answer([(vertices - middle)[faces]], [(whole - middle)[triangles]])


# ---- compas_cgal -----------------------------------------------------------------------


_COMPAS_START = (
    "import numpy as n, compas_cgal.intersections as c;"
    "f=n.array([[0,1,2]]);"
    "a=n.array([[0,0,0],[9,0,0],[0,9,0.]]);b=n.array([[3,-1,-5],[3,9,-5],[3,4,9.]]);"
    "raise SystemExit(len(c.intersection_mesh_mesh((a,f),(b,f)))!=1)"
)


def _compas_curve(meshes: list[Mesh], options: dict) -> Any:
    """The first surface with each of the others."""
    call = import_module("compas_cgal.intersections").intersection_mesh_mesh
    return [line for other in meshes[1:] for line in call(meshes[0], other)]


def _compas_segments(setting: Setting, lines: Any) -> dict[str, Any]:
    lines = [np.asarray(line, dtype=np.float64).reshape(-1, 3) for line in lines]
    parts = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
    return segments_answer(setting, np.concatenate([np.empty((0, 2, 3)), *parts]))


# ---- loop_cgal -------------------------------------------------------------------------


def _loop_meshes(setting: Setting, options: dict) -> Any:
    make = import_module("loop_cgal")._TriMesh
    return [make(v, f.astype(np.int32)) for v, f in _meshes(setting, options)[:2]]


def _loop_split(meshes: Any, options: dict) -> Any:
    meshes[0].corefine(meshes[1])
    return meshes


def _loop_answer(setting: Setting, meshes: Any) -> dict[str, Any]:
    saved = [mesh.save(0.0, 0.0) for mesh in meshes]
    parts = [(np.array(m.vertices), np.array(m.triangles, dtype=np.int64)) for m in saved]
    vertices, faces, owner = _joined(parts)
    found = segments_answer(setting, _common_edges(vertices, faces, owner))
    return found | {"triangles": len(faces), "area_error": _area_error(setting, vertices, faces)}


# ---- trueform --------------------------------------------------------------------------


def _true_meshes(setting: Setting, options: dict) -> Any:
    make = import_module("trueform").Mesh
    return [make(f.astype(np.int32), v) for v, f in _meshes(setting, options)]


def _true_curve(meshes: Any, options: dict) -> Any:
    """The first surface with each of the others."""
    call = import_module("trueform").intersection_curves
    return [call(meshes[0], other) for other in meshes[1:]]


def _true_segments(setting: Setting, found: Any) -> dict[str, Any]:
    """It has lines only: points where surfaces touch alone are not among its answers."""
    lines = [np.asarray(points)[np.asarray(path)] for paths, points in found for path in paths]
    return _compas_segments(setting, lines)


def _true_split(meshes: Any, options: dict) -> Any:
    (faces, vertices), owner, _ = import_module("trueform").mesh_arrangements(meshes)
    return vertices, faces, owner


# ---- libigl ----------------------------------------------------------------------------


def _igl_split(soup: Any, options: dict) -> Any:
    vertices, faces, owner = soup
    call = import_module("igl.copyleft.cgal").remesh_self_intersections
    cut, pieces, _, parent, _ = call(vertices, faces, stitch_all=True)
    return np.asarray(cut), np.asarray(pieces), owner[np.asarray(parent)]


def _igl_answer(setting: Setting, result: Any) -> dict[str, Any]:
    vertices, faces, owner = result
    found = segments_answer(setting, _common_edges(vertices, faces, owner))
    return found | {"triangles": len(faces), "area_error": _area_error(setting, vertices, faces)}


def _igl_patches(setting: Setting, options: dict) -> Any:
    """A welded mesh of surfaces and walls, cut by geosurf, without what sticks out of the box."""
    patches = TASKS["carve"].fresh(setting, options)
    corners = patches.vertices[patches.triangles]
    low, high = np.reshape(setting.box, (3, 2)).T
    inside = ((corners >= low) & (corners <= high)).all(axis=(1, 2))
    return np.array(patches.vertices), np.array(patches.triangles[inside])


def _igl_cells(mesh: Any, options: dict) -> Any:
    return import_module("igl.copyleft.cgal").extract_cells(*mesh)


def _igl_count(setting: Setting, found: Any) -> dict[str, Any]:
    """Cells but for the one outside."""
    return {"units": int(found[0]) - 1}


def _nothing(setting: Setting, result: Any) -> dict[str, Any]:
    return {}


# ---- manifold3d ------------------------------------------------------------------------


def _solid(vertices: np.ndarray, faces: np.ndarray) -> Any:
    m = import_module("manifold3d")
    solid = m.Manifold(m.Mesh64(vert_properties=vertices, tri_verts=faces.astype(np.uint64)))
    if solid.num_tri() == 0:
        raise InputError("manifold3d: the solid is empty. Close the sheets.")
    return solid


def _solids(setting: Setting, options: dict) -> Any:
    """The box, what is below each horizon, and what is beside the fault, as solids."""
    surfaces = setting.surfaces()
    below = [_solid(*body_below(s.lattice, setting.box)) for s in surfaces if s.role == "horizon"]
    beside = [_solid(*body_beside(s.lattice, setting.box)) for s in surfaces if s.role == "fault"]
    w, e, s, n, b, t = setting.box or (0.0,) * 6
    m = import_module("manifold3d")
    box = m.Manifold.cube((e - w, n - s, t - b)).translate((w, s, b))
    return box, below, beside


def _solid_units(solids: Any, options: dict) -> list[float]:
    """Volumes: zone by zone, the side of the hanging wall first."""
    box, below, beside = solids
    bodies = [box, *below]
    zones = [upper - lower for upper, lower in pairwise(bodies)]
    cut = [part for zone in [*zones, bodies[-1]] for part in zone.split(beside[0])]
    return [part.volume() for part in cut]


def _solid_answer(setting: Setting, volumes: list[float]) -> dict[str, Any]:
    w, e, s, n, b, t = setting.box or (0.0,) * 6
    whole = (e - w) * (n - s) * (t - b)
    found = {"units": len(volumes), "box_error": abs(math.fsum(volumes) / whole - 1.0)}
    known = list(setting.truth.get("volumes", {}).values())
    if known:
        found["volume_error"] = max(abs(v / k - 1.0) for v, k in zip(volumes, known, strict=True))
    return found


# ---- vtk -------------------------------------------------------------------------------


def _vtk_meshes(setting: Setting, options: dict) -> Any:
    pyvista = import_module("pyvista")
    return [pyvista.PolyData.from_regular_faces(v, f) for v, f in _meshes(setting, options)[:2]]


def _vtk_curve(meshes: Any, options: dict) -> Any:
    call = import_module("vtk").vtkIntersectionPolyDataFilter()
    for port, mesh in enumerate(meshes):
        call.SetInputDataObject(port, mesh)
    call.SetSplitFirstOutput(0)
    call.SetSplitSecondOutput(0)
    call.Update()
    return call.GetOutput(0)


def _vtk_segments(setting: Setting, output: Any) -> dict[str, Any]:
    lines = import_module("pyvista").wrap(output)
    ends = lines.lines.reshape(-1, 3)[:, 1:] if lines.n_lines else np.empty((0, 2), dtype=int)
    return segments_answer(setting, np.asarray(lines.points, dtype=np.float64)[ends])


# ---- trimesh ---------------------------------------------------------------------------


def _trimesh_mesh(setting: Setting, options: dict) -> Any:
    (vertices, faces), (corners, fault) = _meshes(setting, options)[:2]
    a, b, c = corners[fault[0]]
    mesh = import_module("trimesh").Trimesh(vertices, faces, process=False, validate=False)
    return mesh, np.cross(b - a, c - a), a


def _trimesh_slice(mesh: Any, options: dict) -> Any:
    return import_module("trimesh").intersections.mesh_plane(*mesh)


def _slices(setting: Setting, segments: Any) -> dict[str, Any]:
    """One segment less than the true curve: the plane has no diagonal."""
    return segments_answer(setting, np.asarray(segments))


# ---- the list --------------------------------------------------------------------------

PEERS = (
    Peer(
        "compas_cgal", "compas_cgal", "compas_cgal",
        {"curve": Task(_meshes, _compas_curve, _compas_segments),
         "start": Task(_meshes, lambda m, o: start_process(_COMPAS_START), _nothing)},
    ),
    Peer(
        "loop_cgal", "loop_cgal", "loop-cgal",
        {"split": Task(_loop_meshes, _loop_split, _loop_answer)},
    ),
    Peer(
        "trueform", "trueform", "trueform",
        {"curve": Task(_true_meshes, _true_curve, _true_segments),
         "split": Task(_true_meshes, _true_split, _igl_answer)},
    ),
    Peer(
        "libigl", "igl", "libigl",
        {"split": Task(_soup, _igl_split, _igl_answer),
         "carve": Task(_igl_patches, _igl_cells, _igl_count)},
        most=3e6,
    ),
    Peer(
        "manifold3d", "manifold3d", "manifold3d",
        {"units": Task(_solids, _solid_units, _solid_answer)},
    ),
    Peer("vtk", "vtk", "vtk", {"curve": Task(_vtk_meshes, _vtk_curve, _vtk_segments)}, most=3e6),
    Peer(
        "trimesh", "trimesh", "trimesh",
        {"slice": Task(_trimesh_mesh, _trimesh_slice, _slices)},
    ),
)  # fmt: skip
