"""Packages that not every installation has, and the extra of geosurf that installs each.

Functions that need one ask for it by `need` before they compute anything: without it the error is
one sentence with the command that installs it.
"""

from __future__ import annotations

from importlib.util import find_spec

from geosurf.errors import DependencyError, GeosurfWarning

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
