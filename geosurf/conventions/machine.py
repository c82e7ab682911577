"""Packages that not every installation has, and the extra of geosurf that installs each.

Functions that need one ask for it by `need` before they compute anything: without it the error is
one sentence with the command that installs it.
"""

from __future__ import annotations

import ctypes
import math
import re
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from geosurf.errors import DependencyError, GeosurfWarning

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

# extra -> its packages, by the names that Python imports; pyproject.toml has their versions
EXTRAS = {
    "render": ("matplotlib", "pyvista", "vtkmodules"),
    "io": ("h5netcdf", "h5py", "shapefile", "trimesh"),
    "table": ("pyarrow",),
    "crs": ("pyproj",),
    "gis": ("geopandas", "rasterio", "shapely"),
    "grid": ("xtgeo",),
    "ensemble": ("dask", "distributed", "zarr"),
    "tet": ("tetgen",),
}
REQUIRED = ("numpy", "numba", "xarray", "pandas", "scipy", "meshio")
DISTRIBUTIONS = {"vtkmodules": "vtk", "shapefile": "pyshp"}  # where the names differ
DRAWING = ("matplotlib", "pyvista", "vtkmodules")


def is_installed(package: str) -> bool:
    """Whether a package can be imported; nothing is imported to find out."""
    return find_spec(package) is not None


def distribution(package: str) -> str:
    """Return the name by which an installer knows a package."""
    return DISTRIBUTIONS.get(package, package)


def install_line(package: str) -> str:
    """
    Return the command that installs a package.

    Examples
    --------
    >>> install_line("pyvista")
    'pip install "geosurf[render]"'
    >>> install_line("meshio")
    'pip install meshio'
    """
    extra = next((extra for extra, packages in EXTRAS.items() if package in packages), None)
    return f"pip install {package}" if extra is None else f'pip install "geosurf[{extra}]"'


def missing_sentence(what: str, *packages: str) -> str:
    """
    Return which of some packages is missing for something, and how to install it, or ''.

    Examples
    --------
    >>> missing_sentence("Maps need", "numpy")
    ''
    >>> missing_sentence("Maps need", "numpy", "nopackage")
    'Maps need nopackage, which is not installed. Install it with: pip install nopackage'
    """
    missing = [package for package in packages if not is_installed(package)]
    if not missing:
        return ""
    name, remedy = distribution(missing[0]), install_line(missing[0])
    return f"{what} {name}, which is not installed. Install it with: {remedy}"


def need(what: str, *packages: str) -> None:
    """
    Raise an error if a package is missing.

    Parameters
    ----------
    what : str
        Subject and verb of the sentence: ``"Maps need"``.
    *packages : str

    Raises
    ------
    DependencyError
        With the command that installs it.
    """
    if sentence := missing_sentence(what, *packages):
        raise DependencyError(sentence)


def need_plots() -> None:
    """Raise a DependencyError if maps and diagrams cannot be drawn."""
    need("Pictures need", "matplotlib")


def need_views() -> None:
    """Raise a DependencyError if views in three dimensions cannot be drawn."""
    need("Pictures in three dimensions need", *DRAWING)


def warning_without_pictures() -> GeosurfWarning | None:
    """Return the warning for a report without pictures, or None where they can be drawn."""
    sentence = missing_sentence("they need", "matplotlib")
    if not sentence:
        return None
    return GeosurfWarning(
        "picture",
        "all pictures",
        f"No pictures were drawn: {sentence.partition('. ')[0]}. All other results are complete.",
        f"Install it with: {install_line('matplotlib')}",
    )


# ---- memory ----------------------------------------
# Determine how much memory is free, and give back what is not used.


def free_memory() -> int | None:
    """Return how many bytes of memory this process can still use, or None if that is unknown.

    The least of what the system has available, and of what the limits of a container (cgroup) and
    of the process (``ulimit -v``) leave.
    """
    # Any of the three may be the tightest, and each may be unknown.
    found = [_of_system(), _of_group(), _of_process()]
    known = [free for free in found if free is not None]
    return max(0, min(known)) if known else None


def _of_system() -> int | None:
    """Bytes that the system has available."""
    try:
        # Linux; other systems have no such file, and nothing is known.
        text = Path("/proc/meminfo").read_bytes()
    except OSError:
        return None
    match = re.search(rb"^MemAvailable:\s+(\d+) kB", text, re.MULTILINE)
    return int(match[1]) << 10 if match else None


# Version 2 of cgroups; "max" stands for no limit.
def _of_group() -> int | None:
    """Bytes that the limit of a container leaves."""
    folder = Path("/sys/fs/cgroup")
    try:
        most, used = (
            (folder / name).read_text().strip() for name in ("memory.max", "memory.current")
        )
    except OSError:
        return None
    return int(most) - int(used) if most.isdigit() and used.isdigit() else None


def _of_process() -> int | None:
    """Bytes that the limit of the process leaves (``ulimit -v``)."""
    if resource is None:
        return None
    try:
        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        # Without a limit the system decides.
        if most == resource.RLIM_INFINITY:
            return None
        # The first number of statm is all of the address space, which the limit counts.
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return most - pages * resource.getpagesize()
    except OSError:
        return None


def most_memory_so_far() -> float:
    """Return the most memory that this process has had [bytes]; infinity if that is unknown.

    Examples
    --------
    >>> most_memory_so_far() > 0
    True
    """
    if resource is None:
        return math.inf
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak if sys.platform == "darwin" else peak << 10)


def give_back_memory() -> None:
    """Give memory that has been freed back to the system, where the C library knows how.

    Arrays of up to 32 MB are freed into a heap, of which later arrays fill some gaps only.

    Examples
    --------
    >>> give_back_memory()
    """
    trim = of_glibc("malloc_trim")
    if trim is not None:
        trim(0)


@cache
def of_glibc(name: str) -> Any:
    """Return a function of the GNU C library; None with another one."""
    try:
        library = ctypes.CDLL(None)
        # others have functions of the same name that do something else
        return getattr(library, name) if hasattr(library, "gnu_get_libc_version") else None
    except (OSError, AttributeError, TypeError):  # TypeError: Windows takes no None
        return None
