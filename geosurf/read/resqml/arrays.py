"""Numbers of a RESQML object: in the HDF5 file, one value many times, or evenly spaced ones."""

from __future__ import annotations

from xml.etree.ElementTree import Element

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._guard import ALLOWANCE
from geosurf.read.resqml.package import Package, every, kind

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


__all__ = ["places_along", "steps_of", "values_of"]
