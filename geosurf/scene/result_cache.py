"""Results on disk, by what they depend on: a later process finds them again.

A name is a hash of the inputs, of geosurf's own sources and of the packages that compute: another
version never finds a result of this one. Files are written whole or not, carry a checksum,
and are used only where no other user could have written them. Whatever goes wrong with the folder
costs time, never a result; the first problem is a `GeosurfWarning`.

A file holds JSON for the structure of a result and raw numbers for its arrays, no pickle. Only the
classes in `_CLASSES` are known, and unpacking calls their constructors: a file can hold wrong
numbers, but it cannot run code.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import os
import platform
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from geosurf.conventions import counted
from geosurf.errors import GeosurfError, GeosurfWarning, InputError, collected, issue, warn
from geosurf.files import (
    read_own,
    remove,
    remove_abandoned,
    sealed,
    unsealed,
    why_not_ours,
    write_whole,
)
from geosurf.model import (
    Certificate,
    FaultCut,
    Lattice,
    Sheet,
    SheetReport,
    ThrowAudit,
    ThrowReport,
    TriSurface,
)
from geosurf.model.base import with_crs
from geosurf.model.expected import path_of
from geosurf.model.sheets import BaseHeights, DataUse, Extended, LostThrow, TearPlan
from geosurf.model.surfaces import Sector
from geosurf.model.units import Check
from geosurf.scene.memory import known_fingerprint
from geosurf.scene.scene import Scene

SUFFIX = ".gsr"
LARGEST = 1 << 30  # [bytes] of one result
BUDGET = 4 << 30  # [bytes] of all; those that were not read for longest go first
_PACKAGES = ("numpy", "scipy", "numba", "xarray")

Result = TypeVar("Result")


class ResultCache:
    """
    A folder of results that later runs find again.

    Parameters
    ----------
    folder : path-like
        Is created with the first result. Only files of the kind ``*.gsr`` in it are touched.
    budget : int
        Bytes of all files; beyond it the least recently used are removed.

    Raises
    ------
    InputError
        If `folder` is a file.

    Examples
    --------
    >>> import tempfile
    >>> cache = ResultCache(tempfile.mkdtemp())
    >>> for _ in range(2):
    ...     made = cache.get_or_compute("sum", (1, 2), lambda: print("computed") or 3)
    computed
    >>> made, cache.n_found, cache.n_made
    (3, 1, 1)
    """

    def __init__(self, folder: str | os.PathLike[str], budget: int = BUDGET) -> None:
        self.folder = path_of(folder, "the cache folder")
        if self.folder.exists() and not self.folder.is_dir():
            raise InputError(
                f"{self.folder} is a file. Give a folder with cache_dir= or --cache-dir."
            )
        self.budget = budget
        self.n_found = self.n_made = 0
        self._reported = self._unusable = False

    def get_or_compute(
        self,
        kind: str,
        inputs: tuple[Any, ...],
        run: Callable[[], Result],
        keep: Callable[[Result], bool] = lambda _: True,
    ) -> Result:
        """
        Return a result from its file; otherwise compute it and write the file.

        Parameters
        ----------
        kind : str
            What it is, such as ``"sheet"``.
        inputs : tuple
            All that it depends on: surfaces, sheets, grids, arrays; texts and numbers as ``repr``.
        run : callable
            () -> the result. What it warns of comes back with the result.
        keep : callable, optional
            result -> whether it is stored. Default: each is.
        """
        name = name_of_result(kind, inputs)
        data = None if name is None else self.load(name)
        if name is not None and data is not None:
            try:
                result, warnings = unpacked(data)
            except (ValueError, KeyError, TypeError, GeosurfError):
                self._report_damage(name, "it cannot be read")
            else:
                self.n_found += 1
                for warning in warnings:
                    warn(warning)
                made: Result = result
                return made
        issued: list[GeosurfWarning] = []
        try:
            with collected() as issued:
                result = run()
        finally:
            for warning in issued:
                warn(warning)
        self.n_made += 1
        if name is not None and keep(result):
            with suppress(TypeError):  # a result of a kind that has no packed form
                self.save(name, packed((result, tuple(issued))))
        return result

    # ---- files ---------------------------------------------------------------------------

    def load(self, name: str) -> bytes | None:
        """Return the file of a name; None if it is missing, damaged, or not of this user."""
        path, wrong = self.folder / name, "its checksum is wrong"
        if self._is_distrusted():
            return None
        try:
            content = unsealed(name, read_own(path, LARGEST))
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            content, wrong = None, error.strerror or type(error).__name__
        if content is None:
            self._report_damage(name, wrong)
        else:
            with suppress(OSError):
                os.utime(path)  # it was used now: others go first
        return content

    def save(self, name: str, payload: bytes) -> bool:
        """Write a file, completely or not; return whether it is there."""
        if self._unusable or len(payload) > min(LARGEST, self.budget) or self._is_distrusted():
            return False
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_whole(self.folder / name, sealed(name, payload), 0o600)
        except OSError as error:
            # a full disk stays full: one attempt, one message
            self._unusable = True
            reason = error.strerror or type(error).__name__
            self._report(
                f"Results cannot be stored in {self.folder} ({reason}). This run is complete; the "
                "next one computes them again.",
                "Free some space there, or choose another folder with --cache-dir (cache_dir=).",
            )
            return False
        self._trim()
        return True

    def _trim(self) -> None:
        """Remove the least recently used files beyond the budget."""
        files = []
        for path in self.folder.glob(f"*{SUFFIX}"):
            with suppress(OSError):  # another process was faster
                state = path.stat()
                files.append((state.st_mtime, state.st_size, path))
        total = sum(size for _, size, _ in files)
        for _, size, path in sorted(files):
            if total <= self.budget:
                break
            remove(path)
            total -= size
        remove_abandoned(self.folder)

    # ---- problems ------------------------------------------------------------------------

    def _is_distrusted(self) -> bool:
        """Whether others can write into the folder; then it is not used."""
        if self._unusable or not hasattr(os, "getuid"):
            return self._unusable
        try:
            why = why_not_ours(self.folder.stat())
        except OSError:
            return False  # not there yet
        if why:
            self._unusable = True
            self._report(
                f"The cache folder {self.folder} is not used, since it {why}.",
                "Choose a folder that only you can write with --cache-dir (cache_dir=).",
            )
        return self._unusable

    def _report_damage(self, name: str, why: str) -> None:
        self._report(
            f"The stored result {self.folder / name} cannot be used ({why}); it is computed again.",
            f"No action is needed. If it happens again, delete the folder {self.folder}.",
        )

    def _report(self, effect: str, remedy: str) -> None:
        """Issue the first problem: not as a warning of the model, whose results are the same."""
        if not self._reported:
            self._reported = True
            issue(GeosurfWarning("result cache", str(self.folder), effect, remedy))

    def __str__(self) -> str:
        return f"{counted(self.n_found, 'result')} from {self.folder}, {self.n_made} computed"


def cache_in(folder: str | os.PathLike[str] | None) -> ResultCache | None:
    """Return the results in a folder; None without one."""
    return None if folder is None else ResultCache(folder)


def name_of_result(kind: str, inputs: tuple[Any, ...]) -> str | None:
    """Return the file name of a result; None if an input is only known by its identity."""
    digest = hashlib.sha256(f"{kind} {environment()}".encode())
    for one in inputs:
        text = f"text {one!r}" if _is_text(one) else known_fingerprint(one)
        if text is None:
            return None
        digest.update(f"{len(text)} {text}".encode())
    return f"{kind}-{digest.hexdigest()}{SUFFIX}"


def _is_text(setting: Any) -> bool:
    """Whether an input counts by its text: settings, and tuples of them."""
    if isinstance(setting, tuple | list):
        return all(map(_is_text, setting))
    return setting is None or type(setting) in (str, bool, int, float)


@functools.cache
def environment() -> str:
    """Return a hash of geosurf's sources, of the packages that compute, and of the machine."""
    digest = hashlib.sha256(platform.machine().encode())
    for package in _PACKAGES:
        with suppress(PackageNotFoundError):
            digest.update(f"{package} {version(package)} ".encode())
    root = Path(__file__).resolve().parents[1]
    for path in sorted(root.rglob("*.py")):
        content = path.read_bytes()
        digest.update(f"{path.relative_to(root).as_posix()} {len(content)} ".encode() + content)
    return digest.hexdigest()


# ---- results as bytes ----------------------------------------------------------------

_CLASSES: dict[str, type] = {
    one.__name__: one
    for one in (
        BaseHeights,
        Certificate,
        Check,
        DataUse,
        Extended,
        FaultCut,
        Lattice,
        LostThrow,
        Sector,
        Sheet,
        SheetReport,
        TearPlan,
        ThrowAudit,
        ThrowReport,
    )
}
_HEAD = 16  # digits of the length of the JSON text
_ALIGN = 8


def packed(value: Any) -> bytes:
    """
    Return a result as bytes.

    Parameters
    ----------
    value : Sheet, TriSurface, array, number, text, None, or lists, tuples and dicts of these

    Returns
    -------
    bytes

    Raises
    ------
    TypeError
        For anything else.

    Examples
    --------
    >>> unpacked(packed({"a": (1, 2.5, np.arange(3))}))
    {'a': (1, 2.5, array([0, 1, 2]))}
    >>> packed(object())
    Traceback (most recent call last):
    TypeError: object cannot be packed
    """
    arrays: list[bytes] = []
    tree = json.dumps(_tree(value, arrays)).encode()
    tree += b" " * (-len(tree) % _ALIGN)
    return b"".join([f"{len(tree):0{_HEAD}d}".encode(), tree, *arrays])


def unpacked(data: bytes) -> Any:
    """
    Return what `packed` was given; arrays are read-only.

    Raises
    ------
    ValueError, KeyError, TypeError, GeosurfError
        For other bytes.
    """
    end = _HEAD + int(data[:_HEAD])
    return _value(json.loads(data[_HEAD:end]), data, [end])


def _tree(value: Any, arrays: list[bytes]) -> Any:
    """The structure of a value; the bytes of its arrays are appended to a list."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, np.generic):  # before float: np.float64 is one
        return ["number", _tree(np.asarray(value), arrays)]
    if type(value) is np.ndarray and value.dtype.kind in "biuf":
        return ["array", *_raw(value, arrays)]
    if type(value) in (tuple, list):
        return [type(value).__name__, *(_tree(part, arrays) for part in value)]
    if type(value) is dict:
        return ["dict", *([_tree(k, arrays), _tree(v, arrays)] for k, v in value.items())]
    if type(value) is GeosurfWarning:
        return ["warning", *(_tree(part, arrays) for part in value.args)]
    if type(value) is TriSurface:
        # arrays that a lattice implies are made again; those that somebody has read are at hand
        made = "vertices" in value.__dict__ and "triangles" in value.__dict__
        mesh = (value.vertices, value.triangles) if made else (None, None)
        parts = (value.name, value.role, *mesh, value.lattice, value.vertex_data, value.crs)
        return ["surface", *(_tree(part, arrays) for part in parts)]
    name = type(value).__name__
    if _CLASSES.get(name) is not type(value):
        raise TypeError(f"{name} cannot be packed")
    fields = {one.name: getattr(value, one.name) for one in dataclasses.fields(_CLASSES[name])}
    crs = getattr(value, "crs", None)
    return ["object", name, _tree(fields, arrays), _tree(crs, arrays)]


def _raw(array: np.ndarray, arrays: list[bytes]) -> tuple[str, list[int], str]:
    """Kind, shape and order of an array, whose bytes go to a list."""
    # the order in memory decides in which order numpy adds: it belongs to the result
    order = "C" if array.flags.c_contiguous or not array.flags.f_contiguous else "F"
    raw = array.tobytes(order)  # type: ignore[arg-type]
    arrays.append(raw + b"\0" * (-len(raw) % _ALIGN))
    return array.dtype.str, list(array.shape), order


def _value(tree: Any, data: bytes, at: list[int]) -> Any:
    """A value from its structure; `at` is where its first array begins, and is moved on."""
    if not isinstance(tree, list):
        return tree
    kind, *parts = tree
    if kind == "array":
        return _array(parts, data, at)
    if kind == "dict":
        return {_value(k, data, at): _value(v, data, at) for k, v in parts}
    if kind == "object":
        return _object(parts, data, at)
    values = [_value(part, data, at) for part in parts]
    if kind == "number":
        return values[0][()]
    if kind == "tuple":
        return tuple(values)
    if kind == "list":
        return values
    if kind == "warning":
        return GeosurfWarning(*values)
    if kind == "surface":
        name, role, vertices, triangles, lattice, vertex_data, crs = values
        surface = TriSurface(
            name, role, vertices, triangles, lattice=lattice, vertex_data=vertex_data
        )
        return with_crs(surface, crs)
    raise ValueError(f"{kind!r} is not known")


def _array(parts: list[Any], data: bytes, at: list[int]) -> np.ndarray:
    """An array from the bytes after the last one."""
    kind, shape, order = parts
    dtype = np.dtype(kind)
    if dtype.kind not in "biuf":
        raise ValueError(f"arrays of {kind!r} are not known")
    n = int(np.prod(shape, dtype=np.int64))
    raw = np.frombuffer(data, dtype, n, at[0]).copy()
    at[0] += raw.nbytes + -raw.nbytes % _ALIGN
    found = raw.reshape(shape, order=order)
    found.flags.writeable = False
    return found


def _object(parts: list[Any], data: bytes, at: list[int]) -> Any:
    """One of the known classes, made by its constructor."""
    name, fields, crs = parts
    found = _CLASSES[name](**_value(fields, data, at))
    return with_crs(found, _value(crs, data, at))


def check_with_cache(scene: Scene, cache: ResultCache | None) -> Certificate:
    """
    Return the certificate of a scene, as `Scene.check` does; one in the cache is not made again.

    Parameters
    ----------
    scene : Scene
    cache : ResultCache or None

    Returns
    -------
    Certificate
        The same in both cases: a model has the same bytes whenever it is built from the same
        inputs, with the same version, on the same kind of machine. One that fails is not stored.
    """
    model = None if cache is None else name_of_model(scene)
    if cache is None or model is None:
        return scene.check()
    return scene._take_certificate(
        cache.get_or_compute("certificate", (model,), scene.check, keep=lambda made: made.ok)
    )


def name_of_model(scene: Scene) -> str | None:
    """
    Return a hash of all that a model depends on, after reading, tearing, extending and truncating.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str or None
        None if an input is only known by its identity.
    """
    graph = scene._graph
    inputs, (levels, contacts) = graph.inputs, graph.fluids
    tops = graph.tops
    # what closed a sheet is marked on its map
    marked = [(name, *map(repr, sheet.warnings)) for name, sheet in graph.sheets.items()]
    rules = graph.ruled_faults.rules
    settings = (
        graph.box, tuple(graph.column.items()), inputs.tolerance, inputs.voxel_size,
        inputs.self_intersections, inputs.slivers, graph.reservoir, inputs.horizon_rules, rules,
        tuple(graph.passed),
        [(one.name, one.block, one.zones) for one in contacts], marked,
    )  # fmt: skip
    parts: tuple[Any, ...] = (
        repr(settings), *graph.wholes, *levels,
        graph.origin_for(graph.wholes), np.empty(0) if graph.aoi is None else graph.aoi,
        *(() if tops is None else (tops.wells, tops.horizons, tops.points)),
    )  # fmt: skip
    return name_of_result("model", parts)
