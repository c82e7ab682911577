"""What all nouns share: read-only arrays, and the way to pyvista."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from geosurf.conventions.card import Card
from geosurf.conventions.machine import need

if TYPE_CHECKING:  # pragma: no cover - types only
    import pyvista

Made = TypeVar("Made")


def frozen(array: Any, dtype: Any, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Return a read-only, C-contiguous array of one dtype (a view where possible)."""
    # Kernels take C-contiguous arrays; a slice of columns is copied here, once.
    out = np.ascontiguousarray(array, dtype=dtype)
    if shape is not None:
        # in one piece and of one type: kernels take arrays as they are, without a copy
        out = out.reshape(shape)

    # the view is locked, not the array: who made it may still own it
    view: np.ndarray = out.view()
    view.flags.writeable = False
    return view


class Noun:
    """What is handed out: arrays stay read-only in copies, and on the way to other processes.

    Attributes
    ----------
    crs : str or None
        Coordinate reference system of the inputs that it is made of, if one declared it.
    """

    crs: str | None = None

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what a copy or a pickle holds; numpy forgets there that arrays are read-only."""
        # Copies and other processes get arrays that are as read-only as the originals.
        _lock(list(state.values()))
        self.__dict__.update(state)

    def _card(self) -> Card:
        """Return what notebooks show: a title and a table; computes next to nothing."""
        return Card(repr(self))

    def _repr_html_(self) -> str:
        """Return the card as HTML."""
        return self._card().html()


class Shown(Noun):
    """A noun with a place in space: ``show()`` draws it in a notebook or a browser."""

    def show(self, max_triangle: int = 120_000) -> Any:
        """
        Return an interactive view: notebooks draw it, ``save("view.html")`` writes it.

        Parameters
        ----------
        max_triangle : int
            About how many triangles it has; blocks of grid cells are merged to get there.

        Returns
        -------
        InteractiveView

        Raises
        ------
        InputError
            If there is nothing to show, or `max_triangle` is not a number above 0.
        """
        # drawing is above the nouns: the package hands it down
        return sys.modules["geosurf"].show(self, max_triangle=max_triangle)


def in_crs_of(made: Made, sources: Iterable[Any]) -> Made:
    """Return what was made of some surfaces, in the reference system that one of them declares."""
    # Systems that differ were refused before; the first one that is declared stands for all.
    found = (getattr(source, "crs", None) for source in sources)
    return with_crs(made, next((one for one in found if one is not None), None))


def with_crs(made: Made, crs: str | None) -> Made:
    """Return what was made, in a reference system if one is known."""
    if crs is not None:
        object.__setattr__(made, "crs", crs)  # dataclasses among them are frozen
    return made


def _lock(value: Any) -> None:
    """Make arrays read-only, in lists and mappings, too."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, dict | list | tuple):
        for part in value.values() if isinstance(value, dict) else value:
            _lock(part)


def need_pyvista() -> None:
    """Raise a DependencyError if there are no meshes of pyvista."""
    need("Meshes of pyvista need", "pyvista", "vtkmodules")


def polydata(
    points: np.ndarray,
    triangles: np.ndarray | None = None,
    lines: tuple[np.ndarray, ...] | None = None,
    point_data: Mapping[str, np.ndarray] | None = None,
    cell_data: Mapping[str, np.ndarray] | None = None,
    crs: str | None = None,
) -> pyvista.PolyData:
    """A pyvista mesh; pyvista is imported here and nowhere else outside render."""
    need_pyvista()
    import pyvista

    # Copies: users of pyvista change points in place.
    if triangles is not None:
        mesh: pyvista.PolyData = pyvista.PolyData.from_regular_faces(
            np.array(points), np.array(triangles)
        )
    else:
        # vtk's list of cells: number of points, then their rows
        cells = [np.concatenate([[len(line)], line]) for line in lines or ()]
        mesh = pyvista.PolyData(np.array(points))
        mesh.lines = np.concatenate(cells) if cells else np.empty(0, dtype=np.int64)

        # pyvista makes a vertex cell of each point otherwise
        mesh.verts = np.empty(0, dtype=np.int64)
    for key, value in (point_data or {}).items():
        mesh.point_data[key] = value
    for key, value in (cell_data or {}).items():
        mesh.cell_data[key] = value
    if crs is not None:
        mesh.field_data["crs"] = [crs]
    return mesh


def tet_grid(
    points: np.ndarray, tetrahedra: np.ndarray, cell_data: Mapping[str, np.ndarray]
) -> pyvista.UnstructuredGrid:
    """Tetrahedra of pyvista."""
    need_pyvista()
    import pyvista

    # Copies: users of pyvista change points in place.
    cells = {pyvista.CellType.TETRA: np.array(tetrahedra)}
    grid: pyvista.UnstructuredGrid = pyvista.UnstructuredGrid(cells, np.array(points))
    for key, value in cell_data.items():
        grid.cell_data[key] = value
    return grid


def multiblock(blocks: Mapping[str, Any]) -> pyvista.MultiBlock:
    """Named blocks of pyvista."""
    need_pyvista()
    import pyvista

    made = pyvista.MultiBlock()
    for name, block in blocks.items():
        made.append(block, name)
    return made


def any_of(marks: np.ndarray) -> np.ndarray:
    """Whether any of a few columns (n, 2 or 3) is marked; numpy's `any` takes ten times as long."""
    # Column by column: operations on whole columns are vectorised, reductions along rows are not.
    any_marked: np.ndarray = marks[:, 0].copy()
    for k in range(1, marks.shape[1]):
        any_marked |= marks[:, k]
    return any_marked


def all_of(marks: np.ndarray) -> np.ndarray:
    """Whether all of a few columns (n, 2 or 3) are marked."""
    all_marked: np.ndarray = marks[:, 0].copy()
    for k in range(1, marks.shape[1]):
        all_marked &= marks[:, k]
    return all_marked
