"""Cases as files: what reproduces a failure."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.stress.case import Case
from geosurf.errors import InputError
from geosurf.model import Lattice, TriSurface


def save_case(case: Case, folder: str | os.PathLike[str]) -> Path:
    """Write a case as .npz that `replay` takes.

    Parameters
    ----------
    case : Case
    folder : path-like
        Created if it is missing.

    Returns
    -------
    Path
    """
    path = Path(folder) / f"{case.family.replace(' ', '_')}_{case.seed}_{case.number}.npz"
    facts = {
        "family": case.family,
        "number": case.number,
        "seed": case.seed,
        "self_intersections": case.self_intersections,
        "known": case.known,
        "surfaces": [[s.name, s.role, _lattice_facts(s.lattice)] for s in case.surfaces],
    }

    # facts as JSON in the same file: no pickle, so that a file from elsewhere cannot run code
    arrays: dict[str, Any] = {"facts": np.array(json.dumps(facts))}
    for i, surface in enumerate(case.surfaces):
        arrays[f"vertices_{i}"], arrays[f"triangles_{i}"] = surface.vertices, surface.triangles
        if surface.lattice is not None:
            for key in ("easting", "northing", "elevation"):
                arrays[f"{key}_{i}"] = getattr(surface.lattice, key)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **arrays)
    return path


def _lattice_facts(lattice: Lattice | None) -> dict | None:
    return None if lattice is None else {"rising": lattice.rising, "reverse": lattice.reverse}


def load_case(path: str | os.PathLike[str]) -> Case:
    """Read a case that `save_case` has written.

    Parameters
    ----------
    path : path-like
        A ``.npz`` file.

    Returns
    -------
    Case

    Raises
    ------
    InputError
        If it is not such a file.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            facts = json.loads(str(data["facts"]))
            surfaces = []
            for i, (name, role, lattice) in enumerate(facts.pop("surfaces")):
                # a grid comes back as a grid: it takes other kernels than its triangles would
                if lattice is None:
                    parts = {k: data[f"{k}_{i}"] for k in ("vertices", "triangles")}
                    surfaces.append(TriSurface(name, role, **parts))
                    continue
                nodes = {k: data[f"{k}_{i}"] for k in ("easting", "northing", "elevation")}
                surfaces.append(TriSurface(name, role, lattice=Lattice(**nodes, **lattice)))
            return Case(surfaces=tuple(surfaces), **facts)
    except (OSError, KeyError, ValueError, TypeError, EOFError) as error:
        # numpy's own sentence advises to unpickle the file
        reason = getattr(error, "strerror", None) or "its content is another"
        raise InputError(
            f"{path}: not a stress case ({reason}). Give a .npz that the stress test has written."
        ) from error
