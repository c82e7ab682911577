"""Open NetCDF files with the library that is installed, whole or in parts."""

from __future__ import annotations

import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from geosurf.errors import DependencyError, FormatError
from geosurf.read._guard import opened, refuse_large, same_file
from geosurf.read._hdf5 import COPIES, refuse_bombs
from geosurf.read._in_parts import opened_in_parts

if TYPE_CHECKING:  # pragma: no cover - types only
    import xarray as xr

# engine -> the first bytes of files that it reads
ENGINES = {
    "h5netcdf": (b"\x89HDF",),
    "netcdf4": (b"\x89HDF", b"CDF\x01", b"CDF\x02", b"CDF\x05"),
    "scipy": (b"CDF\x01", b"CDF\x02"),
}
# h5netcdf comes without h5py, which it reads files with
MODULES = {"h5netcdf": ("h5netcdf", "h5py"), "netcdf4": ("netCDF4",), "scipy": ("scipy",)}
# engines have no common error; these are what damaged files make them raise
DAMAGE = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NameError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
)


def in_parts(path: Path) -> xr.Dataset | None:
    """Return a file with a grid that is too large to be loaded as Dask arrays, or None."""
    if find_spec("dask") is None:
        return None
    with opened(path) as (file, size):
        engine, name = _engine(path, file.read(4)), same_file(path, file)
        try:
            return opened_in_parts(path, engine, name, size)
        except DAMAGE as error:
            if isinstance(error, FormatError):
                raise
            return None  # the reader of the whole file says what is wrong


def load(path: Path) -> xr.Dataset:
    """Return the whole file in memory, or raise an error that names the damage or package."""
    import xarray as xr

    # the library opens the very file that was checked: the path may lead elsewhere by then
    with opened(path) as (file, size), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of attributes: what is wrong with them is an error below
        engine, name = _engine(path, file.read(4)), same_file(path, file)
        try:
            # Texts are dropped: numbers only, whose memory is known before they are loaded.
            texts = _texts_of_hdf5(path, name, size) if engine == "h5netcdf" else []
            with xr.open_dataset(
                name, engine=engine, decode_times=False, drop_variables=texts
            ) as dataset:
                if engine != "h5netcdf":
                    _refuse_large_arrays(path, dataset, size)
                loaded: xr.Dataset = dataset.load()
        except DAMAGE as error:
            if isinstance(error, FormatError):
                raise
            reason = f"{type(error).__name__}: {error}".replace(name, path.name)
            raise FormatError(
                f"{path}: {engine} cannot read it ({reason[:300]}). The file is damaged or "
                "truncated; export it again."
            ) from error
    return loaded


def _engine(path: Path, head: bytes) -> str:
    """Return the first installed library that reads files that begin so."""
    if not head:
        raise FormatError(f"{path}: the file is empty (0 bytes). Export it again.")

    # by the first bytes, never by the suffix: both kinds of NetCDF are called .nc
    fitting = [
        engine for engine, marks in ENGINES.items() if any(head.startswith(mark) for mark in marks)
    ]
    if not fitting:
        raise FormatError(
            f"{path}, byte 0: found {head!r}, expected the signature of NetCDF (CDF or HDF). "
            "This is not a NetCDF file; set format= to its format."
        )

    # fitting by content, usable by what is installed
    usable = [engine for engine in fitting if all(map(find_spec, MODULES[engine]))]
    if not usable:
        raise DependencyError(
            f"{path}: reading this NetCDF file needs {' or '.join(fitting)}. Install them "
            'with: pip install "geosurf[io]"'
        )
    return usable[0]


def _texts_of_hdf5(path: Path, name: str, size: int) -> list[str]:
    """Refuse a file that needs too much memory; return the arrays that are not numeric.

    A damaged file fails here: h5netcdf, failing as it opens one, prints from its destructor. That
    happens up to the first attribute that it asks for, which is this one.
    """
    import h5py

    with h5py.File(name, "r") as file:
        file.attrs.get("_nc3_strict")
        return refuse_bombs(path, file, size)


def _refuse_large_arrays(path: Path, dataset: xr.Dataset, size: int) -> None:
    """Compare what the variables of a file announce with its size."""
    values = sum(variable.size for variable in dataset.variables.values())
    refuse_large(path, COPIES * 8 * values, size, f"a dataset of {values} values")
