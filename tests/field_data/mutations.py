"""Files of all formats, their mutations, and files built to take memory: cases of `mutated`."""

from __future__ import annotations

import base64
import contextlib
import io
import re
import struct
import warnings
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import geosurf as gs
from geosurf.read.model3d import read_model3d, read_regions
from tests.field_data import spoiled

HUGE = (b"99999999", b"2147483648", b"4294967295", b"99999999999", b"18446744073709551615")
WORDS = (
    *HUGE, b"1e30", b"-1", b"0", b"nan", b"inf", b"1_000", "\u0661".encode(), b"1,5", b"0x10",
    b"1e400",
)  # fmt: skip
MARKS = (
    b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff", b"\x00\x00\xfe\xff", b"\x1f\x8b\x08",
    b"PK\x03\x04",
)  # fmt: skip
LINE_ENDS = (b"\r\n", b"\r", b"\n\n", b"\x0b", b"\xe2\x80\xa8")
BLANKS = (b"\xa0", b"\xc2\xa0", b"\t", b"\x00", b",", b";")
ENCODINGS = ("utf-16", "utf-16-be", "utf-32", "utf-7")
SHORT_ROWS = ("1 ", "1\n", "\n", "1 2 3\n", "1;", "a ", "999 999 999\n", '"\n', "9,")
HEADS = ("", "-996 9 1 1\n0 9 0 9\n9 0 0 0\n0 0 0 0 0 0 0\n", "x,y,z,poly_id\n", "v ")
NAMES = (
    "top.zmap", "top.gri", "points.xyz", "points.csv", "sticks.pol", "F.ts", "F.obj", "F.off",
    "F.vtk", "F.ply", "F.inp", "outline.csv",
)  # fmt: skip
GOCAD_ROWS = ("VRTX 1 0 0 0\n", "TRGL 1 2 3\n", "a\n", "a {\n")


# ------------------------------------------------------------------- whole files
def whole_files(folder: Path) -> dict[str, bytes]:
    """Good files of all formats, by name; the name tells `read` what they hold."""
    import meshio

    paths = list(spoiled.whole_files(folder))
    corners = np.array([[2.0, -1, 9], [2, 7, 9], [4, 7, -9], [4, -1, -9]])
    triangles = [("triangle", np.array([[0, 1, 2], [0, 2, 3]]))]
    quiet = contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO())
    with quiet[0], quiet[1], warnings.catch_warnings(action="ignore"):
        mesh = meshio.Mesh(corners, triangles, point_data={"a": np.arange(4.0)})
        meshio.vtk.write(folder / "ascii.vtk", mesh, binary=False)
        meshio.vtu.write(folder / "lzma.vtu", mesh, compression="lzma")
        meshio.vtu.write(folder / "plain.vtu", mesh, compression=None)
        meshio.ply.write(folder / "ascii.ply", mesh, binary=False)
        meshio.stl.write(folder / "binary.stl", mesh, binary=True)
        bare = meshio.Mesh(corners, triangles)  # it cannot read its own text of point data
        meshio.gmsh.write(folder / "text.msh", bare, "4.1", binary=False)
        meshio.gmsh.write(folder / "binary.msh", mesh, "4.1", binary=True)
        meshio.write(folder / "abaqus.inp", mesh)
    names = (
        "ascii.vtk", "lzma.vtu", "plain.vtu", "ascii.ply", "binary.stl", "text.msh", "binary.msh",
        "abaqus.inp",
    )  # fmt: skip
    paths += [folder / name for name in names]
    found = {path.name: path.read_bytes() for path in paths}
    found |= {f"horizon_{k}.nc": data for k, data in enumerate(netcdf_files(folder))}
    found["packed.vtp"] = packed_vtp(corners.ravel(), 3)
    found["model.ml"] = MODEL.encode()
    found["properties.ts"] = PROPERTIES.encode()
    found["horizon.irap"] = gs.write(spoiled.horizon(), folder / "x.irapasc")[0].read_bytes()
    found["points_ijxyz.dat"] = b"815 1210 7.5 6.5 1.0\n816 1210 8.5 9.5 2.0\n999 999 999\n"
    found["points_comma.csv"] = b"X;Y;Z;name\n1,5;2,5;3,5;a\n4,5;5,5;6,5;b\n"
    return found


def netcdf_files(folder: Path) -> Iterator[bytes]:
    """A horizon in chunks, compressed, shuffled; packed in integers; in classic NetCDF."""
    top = spoiled.horizon().to_dataset()
    plans = (
        ("h5netcdf", {"zlib": True, "shuffle": True, "chunksizes": (2, 2)}),
        ("h5netcdf", {"dtype": "i2", "scale_factor": 0.25, "_FillValue": -999, "zlib": True}),
        ("scipy", {"_FillValue": -999.0}),
    )
    for engine, encoding in plans:
        top.to_netcdf(folder / "x.nc", engine=engine, encoding={"elevation": encoding})
        yield (folder / "x.nc").read_bytes()


def packed_vtp(points: np.ndarray, n_block: int, zeros: int = 0, around: int = 1) -> bytes:
    """A .vtp whose points are compressed in blocks; zeros, and compression in compression."""
    raw = points.astype("<f8").tobytes() + bytes(zeros)
    size = -(-len(raw) // n_block)
    blocks = [raw[k : k + size] for k in range(0, len(raw), size)]
    packed = blocks
    for _ in range(around):
        packed = [zlib.compress(block, 9) for block in packed]
    counts = (len(blocks), size, len(blocks[-1]) % size, *map(len, packed))
    head = struct.pack(f"<{len(counts)}Q", *counts)
    text = base64.b64encode(head).decode() + base64.b64encode(b"".join(packed)).decode()
    return (
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64" '
        'compressor="vtkZLibDataCompressor"><PolyData><Piece NumberOfPoints="4" NumberOfPolys="2">'
        '<Points><DataArray type="Float64" NumberOfComponents="3" format="binary">'
        f'{text}</DataArray></Points><Polys><DataArray type="Int64" Name="connectivity" '
        'format="ascii">0 1 2 0 2 3</DataArray><DataArray type="Int64" Name="offsets" '
        'format="ascii">3 6</DataArray></Polys></Piece></PolyData></VTKFile>'
    ).encode()


BODY = "TFACE\nVRTX 1 2 -1 9 CNXYZ\nVRTX 2 2 7 9\nVRTX 3 4 7 -9\nATOM 4 1\nTRGL 4 2 3\nEND\n"
MODEL = (
    "GOCAD Model3d 1\nHEADER {\nname:m\n}\nTSURF F1\nTFACE 1 normal_fault F1\n  0 0 0\n"
    "REGION 3 Universe\n  +1  -1  0\nREGION 4 R\n +1 0\nEND\n"
    "GOCAD TSurf 1\nHEADER {\nname:F1\n}\n" + BODY
)
PROPERTIES = (
    'GOCAD TSurf 1\nHEADER {\nNAME: "F 1"\n*solid*color: 1 0 0 1\n}\n'
    'GOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME "EPSG:23031"\nAXIS_NAME "X" "Y" "Z"\n'
    'AXIS_UNIT "m" "m" "m"\nZPOSITIVE Elevation\nEND_ORIGINAL_COORDINATE_SYSTEM\n'
    'PROPERTIES "a b" c\nESIZES 1 2\nNO_DATA_VALUES -99999 **none**\nTFACE\n'
    "PVRTX 1 2 -1 9 1 2 3 CNXYZ\nPVRTX 2 2 7 9 4 5 6\nPVRTX 3 4 7 -9 -99999 8 9\nTRGL 1 2 3\nEND\n"
)


def read(path: Path) -> object:
    """Whatever a file of this name holds."""
    name = path.name
    if name.startswith("points_ijxyz"):
        return gs.read_points(path, positive="up", columns=(3, 4, 5))
    if name.startswith("points_comma"):
        return gs.read_points(path, positive="up", decimal=",")
    if name.endswith(".ml"):
        return read_model3d(path), read_regions(path)
    return spoiled.read(path)


# --------------------------------------------------------------------- mutations
def one_of(some, rng):
    """One of some things."""
    return some[int(rng.integers(len(some)))]


def number_at(data: bytes, rng) -> re.Match[bytes] | None:
    """One of the numbers that stand in a file as text, an early one more often."""
    found = list(re.finditer(rb"-?[0-9]+(?:\.[0-9]+)?", data[:20_000]))
    return found[min(int(rng.exponential(len(found) / 3 + 1)), len(found) - 1)] if found else None


def another_number(data: bytes, rng) -> bytes:
    """A number becomes a huge one, or a word that is none."""
    at = number_at(data, rng)
    return data if at is None else data[: at.start()] + one_of(WORDS, rng) + data[at.end() :]


def exchanged_numbers(data: bytes, rng) -> bytes:
    """Two numbers in each other's place, as a header with rows for columns."""
    one, two = number_at(data, rng), number_at(data, rng)
    if one is None or two is None or one.start() == two.start():
        return data
    one, two = sorted((one, two), key=lambda m: m.start())
    return data[: one.start()] + two[0] + data[one.end() : two.start()] + one[0] + data[two.end() :]


def huge_integer(data: bytes, rng) -> bytes:
    """Four or eight bytes become a huge count."""
    at, size = int(rng.integers(max(len(data) - 8, 1))), int(rng.choice([4, 8]))
    value = int(rng.choice([0x7FFFFFFF, 0xFFFFFFFF, 0x10000000, 20_000, 1 << 24]))
    order = "little" if rng.random() < 0.5 else "big"
    return data[:at] + value.to_bytes(size, order) + data[at + size :]


def recoded(data: bytes, rng) -> bytes:
    """The same text in another encoding, with other line ends or a mark of byte order."""
    kind = int(rng.integers(6))
    if kind == 0:
        return one_of(MARKS, rng) + data
    if kind == 1:
        return data.replace(b"\n", one_of(LINE_ENDS, rng))
    if kind == 2:
        return data.decode("latin-1").encode(one_of(ENCODINGS, rng))
    if kind == 3:
        return data.replace(b" ", one_of(BLANKS, rng))
    return data.replace(b".", b",") if kind == 4 else one_of(MARKS, rng)


def repeated(data: bytes, rng) -> bytes:
    """A block of the file many times over."""
    i, j = np.sort(rng.integers(0, len(data) + 1, 2)).tolist()
    times = int(rng.choice([2, 3, 100]))
    return data[:i] + data[i:j] * times + data[j:]


def zeroed(data: bytes, rng) -> bytes:
    """A run of zeros in the file, or at its end."""
    at, n = int(rng.integers(len(data) + 1)), int(rng.choice([1, 8, 4096, 1 << 20]))
    return data[:at] + bytes(n) + (data[at:] if rng.random() < 0.5 else b"")


def other_lines(data: bytes, rng) -> bytes:
    """Lines dropped, repeated or exchanged, words made others."""
    return spoiled.spoiled_text(data.decode("latin-1"), rng).encode("utf-8")


MUTATIONS: tuple[Callable[..., bytes], ...] = (
    spoiled.spoiled_bytes, spoiled.spoiled_bytes, another_number, another_number,
    exchanged_numbers, huge_integer, recoded, repeated, zeroed, other_lines,
)  # fmt: skip


# ------------------------------------------------------------------------- bombs
def declared(file, data) -> None:
    """Say that values over northing and easting are elevations in metres."""
    data.attrs["positive"], data.attrs["units"] = "up", "m"
    for k, key in enumerate(("northing", "easting")):
        data.dims[k].attach_scale(file[key])


def hdf5_bomb(rng) -> bytes:
    """A small NetCDF that announces much: its shape, chunks, filters, texts, or other files."""
    import h5py

    n, kind = int(rng.choice([3_000, 20_000, 200_000])), int(rng.integers(6))
    kept = io.BytesIO()
    with h5py.File(kept, "w") as file:
        shape = (n, n) if kind in (0, 5) else (2, 3)
        for key, length in zip(("northing", "easting"), shape, strict=True):
            values = np.arange(min(length, 20_000), dtype="f4") if kind else np.arange(3.0)
            options = {"compression": "gzip", "chunks": (1024,)} if length > 99 else {}
            axis = file.create_dataset(key, shape=(length,), dtype="f4", **options)
            axis[: len(values)] = values[:length]
            axis.make_scale(key)
        options = {
            0: {"chunks": (1000, 1000), "compression": "gzip", "fillvalue": 1.0},
            1: {"chunks": (n, n), "maxshape": (None, None), "compression": "gzip"},
            5: {"dtype": "i1", "chunks": (1000, 1000)},
        }.get(kind, {})  # fmt: skip
        dtype = options.pop("dtype", "f8")
        data = file.create_dataset("elevation", shape=shape, dtype=dtype, **options)
        declared(file, data)
        if kind == 2:
            file["other"] = h5py.ExternalLink("/dev/zero", "/x")
        if kind == 3:
            words = {"dtype": h5py.string_dtype(), "fillvalue": b"x" * 9999}
            file.create_dataset("names", shape=(n,), **words)
        if kind == 4:
            layout = h5py.VirtualLayout(shape=(n, n), dtype="f8")
            file.create_virtual_dataset("more", layout)
    return kept.getvalue()


def zeros_packed(power: int) -> bytes:
    """So many zeros, a power of two, in a thousandth of their bytes: one packed piece, repeated."""
    packer, piece = zlib.compressobj(9, wbits=-15), 1 << 20
    packed = packer.compress(bytes(piece)) + packer.flush(zlib.Z_FULL_FLUSH)
    check = ((1 << power) % 65521) << 16 | 1
    return b"x\xda" + packed * ((1 << power) // piece) + b"\x03\x00" + check.to_bytes(4, "big")


def packed_chunk_bomb(rng) -> bytes:
    """A NetCDF one of whose chunks unpacks to far more than a chunk."""
    import h5py

    kept, packed = io.BytesIO(), zeros_packed(int(rng.integers(26, 30)))
    with h5py.File(kept, "w") as file:
        for key, length in (("northing", 2), ("easting", 3)):
            file[key] = np.arange(float(length))
            file[key].make_scale(key)
        data = file.create_dataset("elevation", (2, 3), "f8", chunks=(2, 3), compression="gzip")
        declared(file, data)
        data.id.write_direct_chunk((0, 0), packed)
    return kept.getvalue()


def xml_bomb(rng) -> bytes:
    """Entities within entities, blocks of zeros, or one appended array named many times."""
    kind = int(rng.integers(3))
    if kind == 0:
        n = int(rng.integers(5, 12))
        words = ["0 " * 99, *(f"&e{k};" * 10 for k in range(n - 1))]
        rows = "".join(f'<!ENTITY e{k} "{word}">' for k, word in enumerate(words))
        plain = packed_vtp(np.zeros(12), 1).decode()
        text = re.sub(r"(format=.)binary(.>)[^<]*", rf"\1ascii\2&e{n - 1};", plain)
        return f"<!DOCTYPE a [{rows}]>{text}".encode()
    if kind == 1:
        zeros = 1 << int(rng.integers(20, 26))
        return packed_vtp(np.zeros(12), int(rng.integers(1, 17)), zeros, int(rng.integers(1, 3)))
    raw = struct.pack("<Q", 1 << 18) + bytes(1 << 18)
    arrays = '<DataArray type="Int8" Name="a{}" NumberOfComponents="65536" '
    arrays += 'format="appended" offset="0"/>'
    many = "".join(arrays.format(k) for k in range(int(rng.integers(1, 3000))))
    plain = packed_vtp(np.zeros(12), 1).decode().replace(' compressor="vtkZLibDataCompressor"', "")
    plain = re.sub(r"(format=.)binary(.>)[^<]*", r"\1ascii\2 2 -1 9 2 7 9 4 7 -9 4 -1 -9", plain)
    text = plain.replace("<Points>", f"<PointData>{many}</PointData><Points>")
    head, end = text.split("</VTKFile>")[0], b"</AppendedData></VTKFile>"
    return head.encode() + b'<AppendedData encoding="raw">_' + raw + end


def text_bomb(rng) -> tuple[str, bytes]:
    """Text that is as short as words can be, and all the more of them."""
    n = int(rng.choice([100_000, 1_000_000]))
    row, name, head = (one_of(some, rng) for some in (SHORT_ROWS, NAMES, HEADS))
    if name == "F.ts":
        head, row = "GOCAD TSurf 1\n", one_of(GOCAD_ROWS, rng)
    return name, (head + row * n).encode()


def case_of(seed: int, files: dict[str, bytes]) -> tuple[str, bytes]:
    """Name and content of one mutated file."""
    rng = np.random.default_rng([163, seed])
    kind = seed % 50
    if kind == 0:
        return "horizon_bomb.nc", hdf5_bomb(rng)
    if kind == 1:
        return "horizon_bomb.nc", packed_chunk_bomb(rng)
    if kind in (2, 3):
        return "bomb.vtp", xml_bomb(rng)
    if kind == 4:
        return text_bomb(rng)
    name = sorted(files)[int(rng.integers(len(files)))]
    data = files[name]
    for _ in range(int(rng.integers(1, 4))):
        data = MUTATIONS[int(rng.integers(len(MUTATIONS)))](data, rng)
    return name, bytes(data)
