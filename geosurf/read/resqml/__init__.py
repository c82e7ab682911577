"""RESQML 2.0.1 (``.epc`` with ``.h5``): its container, a zip of XML objects and HDF5 files.

`representations` says which objects there are, what each holds, and its places in metres;
`surfaces` has what callers read: horizons, faults, points, polygons, paths of wells.

Nothing is unpacked before its size is known, documents may not declare entities, and arrays are
only taken from files of the same folder: a package from elsewhere may name any path.
"""

from __future__ import annotations

import contextlib
import io
import posixpath
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote
from xml.etree.ElementTree import Element

import numpy as np

from geosurf.conventions.machine import need
from geosurf.errors import FormatError, InputError
from geosurf.lazy import h5py
from geosurf.read._common import noted
from geosurf.read._guard import (
    ALLOWANCE,
    damaged,
    opened,
    read_bytes,
    reading_with,
    refuse_bombs,
    refuse_large,
    same_file,
)
from geosurf.read.vtp import xml_of

# ---- arrays ----------------------------------------
# Numbers of a RESQML object: in the HDF5 file, one value many times, or evenly spaced ones.


MOST = ALLOWANCE // 8  # values that are announced without being in the file


def values_of(package: Package, node: Element) -> np.ndarray:
    """
    Return the values of an array element, as they are stored.

    Parameters
    ----------
    package : Package
    node : Element
        Such as ``DoubleHdf5Array``, ``IntegerConstantArray``, ``DoubleLatticeArray``.

    Raises
    ------
    FormatError
        If the kind of array is another one, or values are missing.
    """
    what = kind(node)
    if what.endswith("Hdf5Array"):
        return package.dataset(package.need(node, "Values"))
    if what.endswith("ConstantArray"):
        return np.full(_announced(package, node), _value(package, node))
    if what.endswith("RangeArray"):  # whole numbers from the first one on
        return int(package.number(node, "Value")) + np.arange(_announced(package, node))
    if what.endswith("LatticeArray") and len(every(node, "Offset")) == 1:
        start, steps = (
            package.number(node, "StartValue"),
            steps_of(package, every(node, "Offset")[0]),
        )
        return start + np.concatenate([[0.0], np.cumsum(steps)])
    raise FormatError(
        f"{package.path}: geosurf does not read arrays of the kind {what}. Export the surface with "
        "all its values."
    )


def steps_of(package: Package, node: Element) -> np.ndarray:
    """Return the steps of an evenly or unevenly spaced axis, one fewer than its places."""
    return values_of(package, node).astype(np.float64).ravel()


def places_along(package: Package, node: Element, n: int) -> np.ndarray:
    """
    Return distances (n,) from the first place of an axis.

    Equal steps are multiplied, not summed: so the last place is as exact as the first.
    """
    steps = steps_of(package, node)
    if len(steps) < n - 1:
        raise package.damaged(f"an axis of {n} nodes has {len(steps)} steps")
    steps = steps[: max(n - 1, 0)]
    if len(steps) == 0 or (steps == steps[0]).all():
        return np.arange(n) * (steps[0] if len(steps) else 0.0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _value(package: Package, node: Element) -> float | bool:
    word = package.text(node, "Value").lower()
    return word == "true" if word in ("true", "false") else package.number(node, "Value")


def _announced(package: Package, node: Element) -> int:
    """A number of values that take no room in the file."""
    count = package.count(node, "Count")
    if count > MOST:
        raise package.damaged(f"an array announces {count} values that are not in the file")
    return count


COPIES = 10  # of the text of an object, as a tree
EXTERNAL = "/externalResource"


def tag(node: Element) -> str:
    """Name of an element without its namespace."""
    return str(node.tag).rpartition("}")[2]


def kind(node: Element) -> str:
    """The kind that an element states, such as ``"Grid2dRepresentation"``; else its name."""
    stated = next((value for key, value in node.items() if key.endswith("}type")), "")
    return stated.rpartition(":")[2].removeprefix("obj_") or tag(node)


def find(node: Element, *path: str) -> Element | None:
    """Return the first element at the end of a path of names, or None."""
    for name in path:
        child_found = next((child for child in node if tag(child) == name), None)
        if child_found is None:
            return None
        node = child_found
    return node


def word_of(node: Element | None, *path: str) -> str:
    """Return the text of the element at the end of a path of names, or nothing."""
    found = None if node is None else find(node, *path)
    return ("" if found is None else found.text or "").strip()


def every(node: Element, name: str) -> list[Element]:
    """Return all children of a name."""
    return [child for child in node if tag(child) == name]


@dataclass
class Package:
    """An open package.

    Attributes
    ----------
    path : pathlib.Path
        Of the ``.epc``.
    objects : dict of str to Element
        By identifier, in the order of the file.
    files : dict of str to str
        Names of HDF5 files by the identifier of the object that stands for them.
    size : int
        Bytes of the ``.epc``.
    """

    path: Path
    objects: dict[str, Element]
    files: dict[str, str]
    size: int
    opened: contextlib.ExitStack
    arrays: dict[str, tuple[Path, h5py.File]] = field(default_factory=dict)

    def damaged(self, reason: str) -> FormatError:
        """An error about the structure of the file."""
        return FormatError(
            f"{self.path}: {reason}. The package is damaged, or not RESQML 2.0.1; export it again."
        )

    def need(self, node: Element, *path: str) -> Element:
        """Return the element at the end of a path of names, or raise an error that names it."""
        element = find(node, *path)
        if element is None:
            raise self.damaged(f"a {kind(node)} has no {'/'.join(path)}")
        return element

    def text(self, node: Element, *path: str) -> str:
        """Return the text of an element."""
        return (self.need(node, *path).text or "").strip()

    def number(self, node: Element, *path: str) -> float:
        """Return a finite number."""
        word = self.text(node, *path)
        try:
            value = float(word)
        except ValueError:
            value = np.nan
        if not np.isfinite(value) or "_" in word:
            raise self.damaged(f"{'/'.join(path)} of a {kind(node)} is {word[:40]!r}, no number")
        return value

    def count(self, node: Element, *path: str) -> int:
        """Return a number of things."""
        word = self.text(node, *path)
        if not (word.isascii() and word.isdecimal() and len(word) < 16):
            raise self.damaged(f"{'/'.join(path)} of a {kind(node)} is {word[:40]!r}, no count")
        return int(word)

    def referred(self, node: Element, *path: str) -> Element:
        """Return the object that an element refers to."""
        uuid = self.text(node, *path, "UUID")
        if uuid not in self.objects:
            name = path[-1] if path else tag(node)
            raise self.damaged(f"{name} of a {kind(node)} refers to {uuid!r}, which is missing")
        return self.objects[uuid]

    def dataset(self, node: Element) -> np.ndarray:
        """Return the array that an element such as ``Values`` names."""
        name, proxy = self.text(node, "PathInHdfFile"), self.text(node, "HdfProxy", "UUID")
        path, file = self._file(proxy)
        with reading_with(path, f"h5py (array {name!r})"):
            found = file[name]
            values = np.asarray(found[()]) if found.dtype.kind in "fiub" else None
        if values is None:
            raise damaged(f"{path}: array {name!r} does not hold numbers")
        return values

    def refuse_large(self, needed: int, what: str) -> None:
        """Refuse what takes more memory than the files may ask for."""
        if needed > ALLOWANCE:
            beside = {self._next_to(name) for name in self.files.values()}
            size = self.size + sum(path.stat().st_size for path in beside)
            refuse_large(self.path, needed, size, what)

    def _file(self, proxy: str) -> tuple[Path, h5py.File]:
        """The HDF5 file that an object stands for, checked and open."""
        if proxy not in self.arrays:
            self.arrays[proxy] = self._opened(self._next_to(self.files.get(proxy)))
        return self.arrays[proxy]

    def _next_to(self, name: str | None) -> Path:
        """The file of arrays, in the folder of the package, whatever folder it came from."""
        same_name = self.path.with_suffix(".h5")
        named = same_name if name is None else self.path.parent / name
        # packages are renamed, and then the name inside is the old one
        for path in (named, same_name):
            if path.exists():
                return path
        raise InputError(
            f"{self.path}: its arrays are in {named.name}, which is not next to it. Copy both "
            "files into one folder."
        )

    def _opened(self, path: Path) -> tuple[Path, h5py.File]:
        need(f"{self.path}: RESQML needs", "h5py")
        handle, size = self.opened.enter_context(opened(path))
        with reading_with(path, "h5py"):
            file = self.opened.enter_context(h5py.File(same_file(path, handle), "r"))
            refuse_bombs(path, file, size)
        return path, file


@contextlib.contextmanager
def open_package(path: Path) -> Iterator[Package]:
    """
    Open a package: its objects are parsed, its arrays are read on request.

    Parameters
    ----------
    path : pathlib.Path

    Yields
    ------
    Package

    Raises
    ------
    FormatError
        If it is not a package of RESQML 2.0.1, is damaged, or asks for too much memory.
    """
    data = read_bytes(path)
    objects: dict[str, Element] = {}
    names: dict[str, str] = {}
    total = 0
    with reading_with(path, "zipfile"), zipfile.ZipFile(io.BytesIO(data)) as package:
        listed = {info.filename: info for info in package.infolist()}

        def tree_of(part: str) -> Element:
            """One file as a tree, if there is memory for all of them so far."""
            nonlocal total
            total += COPIES * listed[part].file_size
            refuse_large(path, total, len(data), f"the object {part!r}")
            return xml_of(path, package.read(part), f"the object {part!r}")

        proxies = {}
        for part in listed:
            if not part.endswith(".xml") or _is_about(part):
                continue
            node = tree_of(part)
            objects[node.get("uuid", "")] = node
            if tag(node) == "EpcExternalPartReference":
                proxies[node.get("uuid", "")] = part
        for uuid, part in proxies.items():
            folder, name = posixpath.split(part)
            relations = posixpath.join(folder, "_rels", f"{name}.rels")
            named = _external(tree_of(relations)) if relations in listed else None
            names |= {} if named is None else {uuid: named}
    _refuse_other(path, objects)
    noted("kind", "RESQML 2.0.1")
    with contextlib.ExitStack() as stack:
        yield Package(path, objects, names, len(data), stack)


def _is_about(name: str) -> bool:
    """Whether a file of a package describes the package, and no object of it."""
    return name.startswith(("docProps/", "[Content_Types]"))


def _external(relations: Element) -> str | None:
    """Name of the file that a relation of the kind "external" points to, without folders."""
    for one in relations:
        if str(one.get("Type")).endswith(EXTERNAL) and one.get("Target"):
            return re.split(r"[\\/]", unquote(str(one.get("Target"))))[-1] or None
    return None


def _refuse_other(path: Path, objects: dict[str, Element]) -> None:
    """Refuse zip files of another kind, and other versions of RESQML."""
    spaces = {str(node.tag).rpartition("}")[0].lstrip("{") for node in objects.values()}
    if "http://www.energistics.org/energyml/data/resqmlv2" in spaces:
        return
    other = next((one for one in sorted(spaces) if "resqml" in one), None)
    if other is not None:
        raise FormatError(
            f"{path}: the package has objects of {other}, expected RESQML 2.0.1. Export it as "
            "RESQML 2.0.1."
        )
    raise damaged(f"{path}: this is not a package of RESQML")
