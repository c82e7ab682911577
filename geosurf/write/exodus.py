"""Exodus II of tetrahedra: one element block for each unit.

The container is NetCDF with 64-bit offsets, which every reader of Exodus opens; scipy writes it,
with the same bytes each time. Layout: Schoof & Yarberry, EXODUS II: A Finite Element Data Model,
SAND92-2137, with coordinates in one variable for each axis (the layout for large models).
"""

from __future__ import annotations

import io

import numpy as np

from geosurf.errors import OutputError
from geosurf.model import TetMesh
from geosurf.write.mesh import FACES_LOST, labels_of_units
from geosurf.write.written import Loss

LENGTH = 33  # of a text, with its end
LINE = 81
MOST = 2**32 - 1  # bytes of a variable
VERSION = np.float32(5.1)


def exodus_of_tets(mesh: TetMesh, name: str | None) -> tuple[bytes, list[Loss]]:
    """Return tetrahedra in blocks, unit by unit, with the name of each block."""
    from scipy.io import netcdf_file

    largest = max(16 * len(mesh.tetrahedra), 8 * len(mesh.local))
    if largest > MOST:
        raise OutputError(
            f"{len(mesh.tetrahedra)} tetrahedra are too many for Exodus: a variable has at most "
            "4 GiB. Write .msh or .vtu instead."
        )
    # a size of 0 stands for an unlimited one in NetCDF: units without tetrahedra have no block
    rows = [np.flatnonzero(mesh.region == k) for k in range(len(mesh.unit_names))]
    labels = labels_of_units(mesh, LENGTH - 1)
    labels = [label for label, row in zip(labels, rows, strict=True) if len(row)]
    rows = [row for row in rows if len(row)]
    if not rows:
        raise OutputError("the mesh has no tetrahedra, which Exodus needs. Write .vtu instead.")
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w", version=2)
    file.title, file.api_version, file.version = "geosurf", VERSION, VERSION
    file.floating_point_word_size, file.file_size = np.int32(8), np.int32(1)
    for key, size in (
        ("time_step", None), ("len_string", LENGTH), ("len_line", LINE), ("four", 4),
        ("num_dim", 3), ("num_nodes", len(mesh.local)), ("num_elem", len(mesh.tetrahedra)),
        ("num_el_blk", len(labels)),
    ):  # fmt: skip
        file.createDimension(key, size)
    file.createVariable("time_whole", "f8", ("time_step",))

    # blocks have numbers from 1 on, and are in use
    count = np.arange(1, len(labels) + 1, dtype=np.int32)
    numbers = file.createVariable("eb_prop1", "i4", ("num_el_blk",))
    numbers[:], numbers.name = count, "ID"
    file.createVariable("eb_status", "i4", ("num_el_blk",))[:] = np.ones_like(count)
    _texts(file, "eb_names", "num_el_blk", labels)
    _texts(file, "coor_names", "num_dim", ["x", "y", "z"])
    for axis, values in zip("xyz", mesh.vertices.T, strict=True):
        file.createVariable(f"coord{axis}", "f8", ("num_nodes",))[:] = values
    for k, row in enumerate(rows):
        tets = mesh.tetrahedra[row]
        dims = (f"num_el_in_blk{k + 1}", f"num_nod_per_el{k + 1}")
        for key, size in zip(dims, (len(tets), 4), strict=True):
            file.createDimension(key, size)
        block = file.createVariable(f"connect{k + 1}", "i4", dims)
        block[:], block.elem_type = tets + 1, "TETRA"
    file.flush()
    data = buffer.getvalue()
    file.close()
    return data, [
        Loss("name", f"Element blocks are named {labels}."),
        Loss("data", "Tetrahedra are in the order of their units."),
        FACES_LOST,
    ]


def _texts(file, name: str, dim: str, words: list[str]) -> None:  # type: ignore[no-untyped-def]
    """Write texts, padded with zeros."""
    letters = np.array([word.encode("ascii") for word in words], dtype=f"S{LENGTH}")
    table = letters.view("S1").reshape(len(words), LENGTH)
    file.createVariable(name, "c", (dim, "len_string"))[:] = table


__all__ = ["exodus_of_tets"]
