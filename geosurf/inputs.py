"""Inputs of a scene: read from files, with the words that they do not say, and known by a hash."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.model import TriSurface


def fingerprint(value: Any) -> str:
    """
    Return a hash of what an input of a scene holds.

    Parameters
    ----------
    value : path, TriSurface, FaultSticks, xarray object, or anything else
        Files count by path and content; anything else by its identity.

    Returns
    -------
    str

    Examples
    --------
    >>> one, two = (TriSurface("F1", "fault", np.eye(3), [[0, 1, 2]]) for _ in range(2))
    >>> fingerprint(one) == fingerprint(two) != fingerprint(one.renamed("F2"))
    True
    """
    digest = hashlib.sha256()
    if isinstance(value, str | Path):
        path = Path(value)
        digest.update(str(path.resolve()).encode())
        digest.update(path.read_bytes() if path.is_file() else b"missing")
    elif isinstance(value, TriSurface):
        digest.update(f"{value.name} {value.role}".encode())
        digest.update(np.ascontiguousarray(value.vertices))
        digest.update(np.ascontiguousarray(value.triangles))
    elif hasattr(value, "sticks"):
        for stick in value.sticks:
            digest.update(np.ascontiguousarray(stick))
    elif hasattr(value, "to_dict") and hasattr(value, "coords"):
        digest.update(repr(sorted((str(k), str(v)) for k, v in value.attrs.items())).encode())
        arrays = {**getattr(value, "data_vars", {"": value}), **value.coords}
        for key, array in arrays.items():
            digest.update(f"{key} {array.dims}".encode())
            digest.update(np.ascontiguousarray(array.values))
    else:
        digest.update(f"{id(value)}".encode())
    return digest.hexdigest()


def read_input(path: Any, role: str, options: dict[str, Any]) -> Any:
    """Read a horizon or a fault from a file; the readers are imported only then."""
    from geosurf.read import read_fault, read_horizon

    return (read_horizon if role == "horizon" else read_fault)(path, **options)


def only_if_unsaid(value: Any, options: dict[str, Any]) -> dict[str, Any]:
    """Scene-wide words count only for inputs that do not say theirs themselves."""
    attrs = dict(getattr(value, "attrs", {}))
    return {key: word for key, word in options.items() if word is not None and key not in attrs}
