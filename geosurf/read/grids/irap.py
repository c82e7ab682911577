"""IRAP grids, classic (text) and binary: the map formats of RMS.

Both headers hold the same: ``-996 nrow xinc yinc``, ``xmin xmax ymin ymax``,
``ncol rotation xrot yrot`` and seven zeros (the binary one has the increments last in
its first record). Mind that the number of rows comes second and that of columns
ninth. Values run along x fastest. Neither states whether it holds elevation or
depth, nor in which unit.
"""

from __future__ import annotations

import itertools
import re
import struct
from pathlib import Path

import numpy as np

from geosurf.errors import FormatError
from geosurf.read._blocks import TextBlocks
from geosurf.read._common import agreed_scale, agreed_sign, integer, number
from geosurf.read._guard import opened, read_bytes, read_some
from geosurf.read._noted import noted
from geosurf.read.grids.nodes import GridHeader, GridNodes, nodes_from_grid
from geosurf.read.grids.text import check_count, scaled, text_values

UNDEFINED_CLASSIC = 9999900.0
UNDEFINED_BINARY = 9.9e29  # 1e30 as float32, and all above
MARK = -996
N_HEADER = 19  # values of the header of a text file
# the three header records: length in bytes, then the fields
HEADER_RECORDS = (">ii6f", ">i3f", ">7i")


def read_irap(
    path: Path, *, name: str, positive: str | None = None, length_unit: str | None = None
) -> GridNodes:
    r"""
    Read an IRAP grid, classic or binary, whichever the content is.

    Parameters
    ----------
    path : pathlib.Path
    name : str
        Name of the horizon.
    positive : {"up", "down"}
        The format does not state it, so this argument is required.
    length_unit : str, optional
        Unit of the values (z only; x and y are metres). Default ``"m"``, which
        is what RMS writes.

    Returns
    -------
    GridNodes
        Elevation [m], positive up, NaN where undefined.

    Raises
    ------
    FormatError
        If the content is not an IRAP grid, is cut short, or holds values that are not finite.
    InputError
        If `positive` is missing or `length_unit` unknown.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "top.irap"
    >>> header = "-996 2 10 10\n0 10 0 10\n2 0 0 0\n0 0 0 0 0 0 0\n"
    >>> _ = file.write_text(header + "1 2\n3 9999900.0\n")
    >>> read_irap(file, name="Top", positive="down").values
    array([[-1., -2.],
           [-3., nan]])
    """
    what = f"{path.name}: horizon {name!r}"
    scale = agreed_sign(None, positive, what) * agreed_scale(None, length_unit, "m", what)

    # Both kinds share suffixes, so the first bytes decide.
    with opened(path) as (file, _):
        classic = read_some(path, file, 64).lstrip().startswith(b"-996")
    header, values = _read_classic(path) if classic else _read_binary(path)
    noted("kind", "IRAP classic (text)" if classic else "IRAP binary (float32)")
    noted("null", f"{UNDEFINED_CLASSIC:g}" if classic else "1e30")
    noted("order of values", "rows from the origin, each along the rotation")
    return nodes_from_grid(header, scaled(values, scale), name=name, source=path.name)


def _read_classic(path: Path) -> tuple[GridHeader, np.ndarray]:
    """Header and values (nrow, ncol) of a text file, NaN where undefined."""
    blocks = TextBlocks(path)
    text = blocks.head

    # only the header's words one by one: the nodes are millions, and are taken in bulk
    words = list(itertools.islice(re.finditer(r"\S+", text), N_HEADER))
    if len(words) < N_HEADER:
        raise FormatError(
            f"{path}: found {len(words)} header values, expected 19 (-996 nrow xinc yinc ...). "
            "The file is truncated; export it again."
        )

    # lines of the header's words, for errors only
    tokens = [word[0] for word in words]
    line_of_token = [text.count("\n", 0, word.start()) + 1 for word in words]

    def whole(i: int, what: str) -> int:
        """Header value i as a whole number."""
        return integer(tokens[i], path, line_of_token[i], what)

    def real(i: int, what: str) -> float:
        """Header value i as a number."""
        return number(tokens[i], path, line_of_token[i], what)

    whole(0, "-996")
    # Order of the file: -996 nrow xinc yinc / xmin xmax ymin ymax / ncol rotation xrot yrot.
    header = GridHeader(
        ncol=whole(8, "number of columns"),
        nrow=whole(1, "number of rows"),
        xori=real(4, "xmin"),
        yori=real(6, "ymin"),
        xinc=real(2, "xinc"),
        yinc=real(3, "yinc"),
        rotation=real(9, "rotation"),
    ).checked(path, "header")
    _refuse_pivot(path, header, real(10, "xrot"), real(11, "yrot"))
    for i in range(12, 19):
        whole(i, "the last header line, seven zeros")

    # all that follows are values, wherever lines end
    blocks.skip(words[-1].end())
    values = text_values(blocks, header)
    values[values == UNDEFINED_CLASSIC] = np.nan
    return header, values.reshape(header.nrow, header.ncol)


def _read_binary(path: Path) -> tuple[GridHeader, np.ndarray]:
    """Header and values (nrow, ncol) of a binary file, NaN where undefined."""
    records = _fortran_records(path, read_bytes(path))
    if len(records) < 3:
        raise FormatError(
            f"{path}: found {len(records)} records, expected 3 header records and the values. "
            "The file is truncated; export it again."
        )

    # Big-endian records of fixed lengths: six floats hold limits and steps.
    fields = []
    for i, layout in enumerate(HEADER_RECORDS):
        if len(records[i]) != struct.calcsize(layout):
            raise FormatError(
                f"{path}: header record {i + 1} has {len(records[i])} bytes, expected "
                f"{struct.calcsize(layout)}. This is not an IRAP binary grid."
            )
        fields.append(struct.unpack(layout, records[i]))

    # the upper limits are not used: they follow from origin, steps and numbers
    (mark, nrow, xmin, _, ymin, _, xinc, yinc), (ncol, rotation, xrot, yrot) = fields[:2]
    if mark != MARK:
        raise FormatError(
            f"{path}, byte 4: found {mark}, expected {MARK}. This is not an IRAP binary grid."
        )

    header = GridHeader(ncol, nrow, xmin, ymin, xinc, yinc, rotation).checked(path, "header")
    _refuse_pivot(path, header, xrot, yrot)
    # The nodes are float32, row by row from the south, in records of any length.
    body = b"".join(records[3:])
    check_count(path, len(body) / 4, header)
    values = np.frombuffer(body, dtype=">f4").astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        row, column = divmod(int(bad[0]), ncol)
        raise FormatError(
            f"{path}: node (row {row}, column {column}) is {values[bad[0]]}, expected a finite "
            "number, or 1e30 where undefined. Export the file again."
        )

    values[values >= UNDEFINED_BINARY] = np.nan
    return header, values.reshape(nrow, ncol)


def _fortran_records(path: Path, data: bytes) -> list[bytes]:
    """Split big-endian Fortran records: length, payload, length again."""
    records, at = [], 0
    # Each Fortran record has its length in bytes before and after it.
    while at < len(data):
        if at + 4 > len(data):
            raise FormatError(
                f"{path}, byte {at}: the file ends inside a record length. Export it again."
            )

        # the same number has to stand at both ends, or this is no record
        size = struct.unpack_from(">i", data, at)[0]
        end = at + 4 + size
        if size < 0 or end + 4 > len(data) or struct.unpack_from(">i", data, end)[0] != size:
            what = "This is not an IRAP grid" if at == 0 else "The file is damaged or truncated"
            raise FormatError(
                f"{path}, byte {at}: found a record length of {size}, expected the same length "
                f"after that many bytes ({len(data) - at - 4} are left). {what}; export it "
                "again, or set the right format=."
            )
        records.append(data[at + 4 : end])
        at = end + 4
    return records


def _refuse_pivot(path: Path, header: GridHeader, xrot: float, yrot: float) -> None:
    """Refuse a rotation about another point than the origin: programs disagree on it."""
    # A pivot other than the origin would move the whole grid; a thousandth of a cell is rounding.
    slack = 1e-3 * (abs(header.xinc) + abs(header.yinc))
    off = abs(xrot - header.xori) > slack or abs(yrot - header.yori) > slack
    if header.rotation % 360.0 and off:
        raise FormatError(
            f"{path}, header: rotated by {header.rotation} degrees about ({xrot}, {yrot}), "
            f"expected about the origin ({header.xori}, {header.yori}). Set xrot and yrot to the "
            "origin of the rotated grid."
        )
