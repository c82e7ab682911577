"""What a scene remembers: results by what went into them, and the steps that gave them."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geosurf.model import Sheet, TriSurface


@dataclass(frozen=True)
class Step:
    """One line of `Scene.explain`."""

    stage: str
    subject: str
    outcome: str
    detail: str
    seconds: float = 0.0

    def words(self, width: int, seconds: bool) -> str:
        """Return the line, with subjects padded to one width."""
        clock = f", {self.seconds:.3f} s" if seconds and self.outcome == "ran" else ""
        subject = self.subject.ljust(width)
        return f"{self.stage:<11} {subject}  {self.outcome:<11} {self.detail}{clock}"


class Memory:
    """
    Results by key, shared by scenes that differ little, and the steps of one scene.

    Examples
    --------
    >>> memory = Memory()
    >>> for _ in range(2):
    ...     two = memory.remembered("add", "1 + 1", "key", lambda: 2, str)
    >>> [step.outcome for step in memory.steps]
    ['ran', 'from memory']
    """

    def __init__(self, results: dict[Any, Any] | None = None) -> None:
        self.results = {} if results is None else results
        self.steps: list[Step] = []

    def key_of(self, surface: TriSurface) -> str:
        """Return the fingerprint of a surface; it is taken once."""
        return self.results.setdefault(("key", id(surface)), (surface, fingerprint(surface)))[1]

    def remembered(
        self,
        stage: str,
        subject: str,
        key: Any,
        run: Callable[[], Any],
        describe: Callable[[Any], str],
        *,
        again: bool = True,
    ) -> Any:
        """Return the result of a step: from memory if it is there. Without `again`, told once."""
        if key in self.results:
            result = self.results[key]
            if again or not any(s.stage == stage and s.subject == subject for s in self.steps):
                self.note(stage, subject, "from memory", describe(result))
            return result
        start = time.perf_counter()
        result = run()
        self.results[key] = result
        self.note(stage, subject, "ran", describe(result), time.perf_counter() - start)
        return result

    def note(
        self, stage: str, subject: str, outcome: str, detail: str, seconds: float = 0.0
    ) -> None:
        """Write down one step."""
        self.steps.append(Step(stage, subject, outcome, detail, seconds))


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
    if isinstance(value, Sheet):
        return fingerprint(value.surface)
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
