"""NetCDF files: what HDF5 may claim, grids too large to load, and which library opens a file."""

from __future__ import annotations

import math
import warnings
import zlib
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geosurf.errors import DependencyError, FormatError
from geosurf.read._guard import ALLOWANCE, opened, refuse_large, same_file

if TYPE_CHECKING:  # pragma: no cover - types only
    import h5py
    import xarray as xr


# ---- hdf5 ----------------------------------------
# What an HDF5 file announces, looked at before any of its arrays is read.
#
# A dataset of some bytes may declare any shape (a fill value stands for what is not stored), chunks
# larger than itself, chunks that unpack to more than a chunk, texts that are referred to a million
# times, and data in other files. Such arrays are refused, or ignored if they are not numeric.


DEFLATE, LARGEST_RATIO = 1, 1032  # filter of zlib, and how much it can pack
COPIES = 5  # of an array in 64 bits that are there at a time, from the file to the surface


def refuse_bombs(path: Path, file: h5py.File, size: int, stays: float = math.inf) -> list[str]:
    """
    Refuse what takes more memory than a file of that size may ask for.

    Parameters
    ----------
    path : pathlib.Path
        For messages.
    file : h5py.File
        Open for reading.
    size : int
        Bytes of the file.
    stays : float
        Arrays of more values than this are read in parts: they take no memory.

    Returns
    -------
    list of str
        Names of arrays of texts and other things that are not numeric and are not read.

    Raises
    ------
    FormatError
    """
    import h5py

    # Walk through all groups; hard links can make circles, so each object is visited once.
    passed_over, total, todo, seen = [], 0, [file["/"]], set()
    while todo:
        group = todo.pop()
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise FormatError(
                    f"{path}: {name!r} is a link to another file, {link.filename!r}. geosurf "
                    "does not follow such links. Copy the data into one file."
                )
            found = group.get(name)
            if found is None or (found.id in seen):  # a link to nothing, or a circle
                continue
            seen.add(found.id)
            if isinstance(found, h5py.Group):
                todo.append(found)
            elif isinstance(found, h5py.Dataset):
                # texts and references are left out: a few bytes of them may stand for gigabytes
                if found.size is not None and found.size > 1 and found.dtype.kind not in "fiub":
                    passed_over.append(str(name))
                    continue
                if (found.size or 0) > stays:
                    refuse_other_files(path, found)
                    refuse_empty(path, str(name), found.shape, *_stored_parts(found))
                    continue
                # Bytes of all variables together, since xarray may load each of them.
                total += _bytes_of(path, found, size)
                what = f"variable {name!r} of {' x '.join(map(str, found.shape or ())) or 1} values"
                refuse_large(path, COPIES * total, size, what)
    return passed_over


def _bytes_of(path: Path, data: Any, size: int) -> int:
    """Bytes in 64 bits of a dataset, or of a chunk that is larger."""
    refuse_other_files(path, data)

    # A chunk is unpacked whole, even if the dataset uses a corner of it.
    values, chunk = int(data.size or 0), math.prod(map(int, data.chunks or ()))
    if data.chunks:
        _refuse_packed(path, data, chunk * data.dtype.itemsize, size)
    return max(values, chunk) * max(8, int(data.dtype.itemsize))


def _stored_parts(data: h5py.Dataset) -> tuple[int, int]:
    """How many chunks a file stores of a large array, and how many the array has."""
    if not data.chunks:
        return int(data.id.get_storage_size() > 0), 1
    parts = (-(-n // step) for n, step in zip(data.shape, data.chunks, strict=True))
    return int(data.id.get_num_chunks()), math.prod(parts)


def refuse_empty(path: Path, name: str, shape: tuple[int, ...], stored: int, parts: int) -> None:
    """
    Refuse a large array of which nearly nothing is stored: reading its fill value takes hours.

    Raises
    ------
    FormatError
        If fewer than a thousandth of its parts are there.
    """
    if stored * 1000 < parts:
        size = " x ".join(map(str, shape))
        raise FormatError(
            f"{path}: variable {name!r} announces {size} values, but only {stored} of its {parts} "
            "chunks are stored. Check that the file is complete, or export only the part that has "
            "data."
        )


def refuse_other_files(path: Path, data: Any) -> None:
    """Refuse values that are in other files."""
    if data.is_virtual or data.external:
        raise FormatError(
            f"{path}: the values of {data.name!r} are in other files. Copy them into one file."
        )


def _refuse_packed(path: Path, data: Any, chunk: int, size: int) -> None:
    """Refuse chunks that unpack to more than a chunk has."""
    # filters in the order in which they pack; two of zlib multiply their ratios
    filters = data.id.get_create_plist()
    kinds = [filters.get_filter(k)[0] for k in range(filters.get_nfilters())]
    if kinds.count(DEFLATE) > 1:
        raise FormatError(
            f"{path}: {data.name!r} is compressed {kinds.count(DEFLATE)} times. Compress it "
            "once only."
        )

    # zlib packs by 1032 at most: what is stored bounds what comes out.
    if kinds[-1:] != [DEFLATE] or data.id.get_storage_size() * LARGEST_RATIO <= ALLOWANCE:
        return
    for k in range(data.id.get_num_chunks()):
        stored = data.id.get_chunk_info(k)
        if stored.filter_mask or stored.size * LARGEST_RATIO <= ALLOWANCE or stored.size > size:
            continue  # not compressed, too small to do harm, or beyond the end
        _, packed = data.id.read_direct_chunk(stored.chunk_offset)
        unpack = zlib.decompressobj()
        length = 0
        while packed and not unpack.eof and length <= chunk:
            length += len(unpack.decompress(packed, 1 << 24))
            packed = unpack.unconsumed_tail
        if length > chunk:
            raise FormatError(
                f"{path}: a chunk of {data.name!r} unpacks to more than its {chunk} bytes. "
                "The file is damaged; export it again."
            )


# ---- in parts ----------------------------------------
# NetCDF files with grids that are too large to be loaded: opened as Dask arrays.


LARGE = 1 << 26  # values: smaller arrays are read when a file is opened, which takes half a GB
PART, LONG = 1000, 4000  # nodes along a side of what is read at once, and of a chunk in a file


def opened_in_parts(path: Path, engine: str, name: str, size: int) -> xr.Dataset | None:
    """
    Return a file with a large grid as Dask arrays, or None if it has none.

    Parameters
    ----------
    path : pathlib.Path
    engine : str
        The library that reads it.
    name : str
        Opens the file that was checked; `path` opens it while its values are in use.
    size : int
        Bytes of the file.
    """
    import xarray as xr

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        texts: list[str] = []
        if engine == "h5netcdf":
            import h5py

            with h5py.File(name, "r") as found:
                if not any(getattr(one, "size", 0) > LARGE for one in found.values()):
                    return None
                texts = refuse_bombs(path, found, size, LARGE)
        how: dict[str, Any] = {
            "engine": engine, "decode_times": False, "drop_variables": texts
        }  # fmt: skip
        with xr.open_dataset(name, **how) as dataset:
            large = [one for one in dataset.variables.values() if one.size > LARGE]
            if not large:
                return None
            chunks = {dim: n for one in large for dim, n in chunks_of(one).items()}

        # by its path: it is read as long as the horizon is in use
        return xr.open_dataset(path, chunks=chunks, **how)


def chunks_of(variable: xr.Variable) -> dict[Any, int]:
    """Return chunks of a variable along its dimensions: those of its store, unless very long."""
    stored = variable.encoding.get("chunksizes") or variable.encoding.get("chunks")
    own = dict(zip(variable.dims, stored or (), strict=False))
    return {
        dim: own[dim] if 0 < own.get(dim, 0) <= LONG else min(PART, n)
        for dim, n in variable.sizes.items()
    }


# ---- netcdf file ----------------------------------------
# Open NetCDF files with the library that is installed, whole or in parts.


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
